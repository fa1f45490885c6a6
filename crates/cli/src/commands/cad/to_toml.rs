//! `bksim cad to-toml`: the model of a drawing as a model file.

use serde_json::json;

use super::written;
use crate::args::cad::ToToml;
use crate::exit::{Failure, Status};
use crate::origin::label_of;
use crate::output;
use crate::output_file::check_ending;
use crate::render;
use crate::source::load;

pub(super) fn run(args: &ToToml, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    args.output.iter().try_for_each(|path| check_ending(path, &["toml"]))?;
    let loaded = load(&args.model, nesting)?;
    let text = &loaded.source.text;
    if let Some(path) = &args.output {
        let mut inputs = loaded.source.files();
        inputs.push(&args.model.model);
        written::refuse_inputs(path, &inputs)?;
        let label = label_of(&loaded.source.path);
        written::put_own(path, (args.force, &label), text.clone().into_bytes())?;
    }
    if as_json {
        let output = args.output.as_ref().map(|path| path.display().to_string());
        let diagnostics = render::json_all(&loaded.source, &loaded.warnings);
        let body = json!({ "output": output, "model": text, "diagnostics": diagnostics });
        output::json("cad to-toml", body)?;
        return Ok(Status::Done);
    }
    render::print_all(&loaded.source, &loaded.warnings);
    match &args.output {
        Some(path) => output::report(&format!("wrote {}", path.display()))?,
        None => output::text(text.trim_end())?,
    }
    Ok(Status::Done)
}
