//! `bksim import --to`: a model as a robot file of another program.

use bksim::import::{Exported, Format, export};
use bksim::model::diagnostic::{Code, Diagnostic, Span};
use serde_json::json;

use crate::args::import::{Import, To};
use crate::exit::{Failure, Status};
use crate::output;
use crate::output_file::check_ending;
use crate::render;
use crate::source::Loaded;

/// Writes the robot; `before` are lines about the file that the model itself was imported from.
pub(super) fn run(
    args: &Import,
    to: To,
    (loaded, before): (Loaded, Vec<String>),
    as_json: bool,
) -> Result<Status, Failure> {
    let (format, endings): (_, &[&str]) = match to {
        To::Urdf => (Format::Urdf, &["urdf", "xml"]),
        To::Mjcf => (Format::Mjcf, &["xml", "mjcf"]),
        To::Sdf => (Format::Sdf, &["sdf", "world"]),
    };
    args.output.iter().try_for_each(|path| check_ending(path, endings))?;
    let Loaded { source, model, warnings } = loaded;
    // The place of a span in the file that it came from: name, line, column.
    let place = |span: &Span| {
        let located = source.locate(&Diagnostic::warning(Code("I025"), "").at(span.clone(), ""));
        let start = located.fault.labels.first().map_or(0, |label| label.span.start);
        let (line, column) = bksim_load::line_and_column(located.text, start);
        let name = located.path.file_name().unwrap_or(located.path.as_os_str());
        (name.to_string_lossy().into_owned(), line, column)
    };
    let shown = |span: &Span| {
        let (name, line, _) = place(span);
        format!("{name}:{line}")
    };
    let exported = export(model, format, &shown);
    let exported = exported.map_err(|rejected| source.rejected(rejected.0))?;
    let Exported { text, faults, left_out, n_bodies, n_joints } = exported;
    if let Some(path) = &args.output {
        super::import_drawing::write(path, &args.file, args.force, text.as_bytes())?;
    }
    let diagnostics: Vec<_> = warnings.into_iter().chain(faults).collect();
    if as_json {
        let left_out = left_out.iter().map(|(what, span)| {
            let (file, line, column) = place(span);
            json!({ "what": what, "file": file, "line": line, "column": column })
        });
        let body = json!({
            "output": args.output.as_ref().map(|path| path.display().to_string()),
            "format": format.name(),
            "files": source.files(),
            "n_bodies": n_bodies,
            "n_joints": n_joints,
            "names": [],
            "left_out": left_out.collect::<Vec<_>>(),
            "model": text,
            "diagnostics": render::json_all(&source, &diagnostics),
        });
        output::json("import", body)?;
        return Ok(Status::Done);
    }
    render::print_all(&source, &diagnostics);
    let Some(path) = &args.output else {
        output::text(text.trim_end())?;
        return Ok(Status::Done);
    };
    let format = format.name();
    let mut lines =
        vec![format!("wrote {}: {format}, bodies {n_bodies}, joints {n_joints}", path.display())];
    lines.extend(before);
    lines.extend(left_out.iter().map(|(what, span)| format!("left out {what} ({})", shown(span))));
    output::report(&lines.join("\n"))?;
    Ok(Status::Done)
}
