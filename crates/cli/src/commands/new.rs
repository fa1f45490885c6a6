//! `bksim new NAME`: a small commented model that solves.

use std::path::PathBuf;

use serde_json::json;

use crate::args::New;
use crate::exit::{Failure, Status};
use crate::output;
use crate::output_file::put;

const TEMPLATE: &str = include_str!("../../new.toml");

pub(crate) fn run(args: &New, as_json: bool) -> Result<Status, Failure> {
    let stem = args.name.strip_suffix(".toml").unwrap_or(&args.name);
    let path = PathBuf::from(format!("{stem}.toml"));
    if path.exists() && !args.force {
        let help = Some("choose another name, or add --force to overwrite it".to_owned());
        return Err(Failure::file(&path, "exists already".to_owned(), help));
    }
    put(&path, TEMPLATE.as_bytes())?;
    let file = path.display().to_string();
    if as_json {
        output::json("new", json!({ "output": file }))?;
    } else {
        output::text(&format!("wrote {file}\nnext:  bksim solve {file}"))?;
    }
    Ok(Status::Done)
}
