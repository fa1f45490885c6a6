//! `bksim page MODEL --live`: a model as a page that edits, poses and solves it.

use std::io::Write;
use std::path::Path;

use bksim_cli::args::page::Page;
use bksim_cli::exit::{Failure, Status};
use bksim_cli::origin::{is_of_model, label_of, stamped};
use bksim_cli::output;
use bksim_cli::output_file::OutputFile;
use bksim_cli::source::load;
use bksim_page::{LiveOptions, live};
use serde_json::json;

use super::no_page;
use crate::commands::module::{backdrop, module};

pub(crate) fn run(
    args: &Page,
    path: &Path,
    as_json: bool,
    nesting: usize,
) -> Result<Status, Failure> {
    let input = args.run.input.as_path();
    // An empty file is an empty plane to draw on.
    let is_empty = std::fs::read(input).is_ok_and(|bytes| bytes.trim_ascii().is_empty());
    let (text, name) = if is_empty {
        let stem = input.file_stem().unwrap_or_default();
        (String::new(), stem.to_string_lossy().into_owned())
    } else {
        let loaded = load(&args.run.model(), nesting)?;
        (loaded.source.text, loaded.model.name)
    };
    let module = module()?;
    let label = label_of(input);
    let may_replace = args.force || is_of_model(path, &label);
    let output = OutputFile::plan(path, ("model", &[input]), may_replace, "nothing was written")?;
    let units = args.run.reading.drawing.units.as_ref();
    let under = args.under.as_deref().map(|path| backdrop(path, units)).transpose()?;
    let options = LiveOptions { title: args.title.clone(), is_served: false, under };
    let html = live(&text, &name, &module, &options).map_err(|e| no_page(input, &e, None))?;
    let html = stamped(path, html.into_bytes(), &label);
    let mut out = output.create()?;
    out.write_all(&html).map_err(|e| Failure::writing(path, &e))?;
    out.finish()?;
    if as_json {
        let body = json!({ "output": path.display().to_string(), "bytes": html.len() });
        output::json("page", body)?;
    } else {
        let size = output::number((html.len() as f64 / 1e3).round());
        output::report(&format!("wrote {}: {size} kB", path.display()))?;
    }
    Ok(Status::Done)
}
