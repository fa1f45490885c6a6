//! `bksim cad template`: a drawing with the blocks ready to insert.

use bksim::cad::write::template::{self, template};
use serde_json::json;

use super::written;
use crate::args::draw::Template;
use crate::exit::{Failure, Status};

pub(super) fn run(args: &Template, as_json: bool) -> Result<Status, Failure> {
    written::check(&args.written, &[])?;
    let style = &args.style;
    let wanted =
        template::Template { release: style.dxf_version, unit: &style.units, size: args.size };
    let bytes = template(&wanted).map_err(|e| Failure::writing(&args.written.output, &e))?;
    // A template is of no model, and takes the place of another template alone.
    written::write("cad template", (&args.written, ""), bytes, &json!([]), as_json)
}
