//! `bksim expand`: a model of several files as one text.

use std::path::Path;

use bksim::model::file::Limits;
use bksim_load::{Request, load};
use serde_json::json;

use crate::exit::{Failure, Status};
use crate::output;
use crate::render;

pub(crate) fn run(path: &Path, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let request = Request { limits: Limits { nesting }, is_geometry: true, ..Request::new(path) };
    let loaded = load(&request)?;
    if as_json {
        let files = loaded.source.files().into_iter().map(|file| file.display().to_string());
        let mut body = json!({ "model": loaded.source.text, "files": files.collect::<Vec<_>>() });
        body["diagnostics"] = render::json_all(&loaded.source, &loaded.warnings);
        output::json("expand", body)?;
    } else {
        render::print_all(&loaded.source, &loaded.warnings);
        output::text(loaded.source.text.trim_end())?;
    }
    Ok(Status::Done)
}
