//! `bksim cad body|joint|load|drive add|set|remove`: changes of what is attached to a drawing.

use std::path::{Path, PathBuf};

use bksim::cad::drawing::Handle;
use bksim::cad::edit::{Plan, Statement, Subject, add, remove, set};
use bksim::cad::patch::apply;
use bksim::model::diagnostic::Diagnostic;
use bksim::model::message::counted;
use serde_json::json;

use super::written::exists;
use crate::args::edit::{self as args, Change};
use crate::exit::{Failure, Status};
use crate::origin::{is_of_model, label_of, stamped};
use crate::output;
use crate::output_file::{is_same_file, put};
use crate::render;
use crate::source::{Text, read_bytes, read_sheet};

pub(super) fn run(subject: Subject, change: &Change, as_json: bool) -> Result<Status, Failure> {
    let named = match change {
        Change::Add(args) | Change::Set(args) => &args.named,
        Change::Remove(named) => named,
    };
    let path = &named.drawing;
    let output = output_path(named)?;
    let bytes = read_bytes(path)?;
    let sheet = read_sheet(path, bytes.clone(), &named.reading)?;
    let source = Text::new(path.clone(), sheet.text);

    // What is asked for, as edits; then the drawing with them.
    let statement = statement(subject, change, named);
    let plan = match change {
        Change::Add(_) => add(&sheet.attachments, &statement),
        Change::Set(_) => set(&sheet.drawing, &sheet.attachments, &statement),
        Change::Remove(_) => remove(&sheet.drawing, &sheet.attachments, &statement),
    };
    let Plan { edits, mut warnings } = plan.map_err(|fault| source.rejected(vec![fault]))?;
    let patched = apply(bytes, &edits).map_err(|faults| source.rejected(faults))?;
    warnings.extend(patched.warnings);

    // What was written must read; what it then says may still be at fault, and is told.
    let written = read_sheet(&output, patched.bytes.clone(), &named.reading)?;
    // A copy is known again by its mark; in a drawing that is edited in its place nothing else changes.
    let bytes = if named.output.is_none() || is_same_file(&output, path) {
        patched.bytes
    } else {
        stamped(&output, patched.bytes, &label_of(path))
    };
    put(&output, &bytes)?;
    let after = Text::new(output.clone(), written.text);
    let new: Vec<Diagnostic> =
        written.diagnostics.into_iter().filter(|it| is_new(it, &sheet.diagnostics)).collect();
    if as_json {
        let mut diagnostics = vec![render::json_all(&source, &warnings)];
        diagnostics.push(render::json_all(&after, &new));
        let diagnostics: Vec<_> =
            diagnostics.iter().filter_map(|it| it.as_array()).flatten().cloned().collect();
        let body = json!({
            "output": output.display().to_string(),
            "edits": edits.len(),
            "diagnostics": diagnostics,
        });
        output::json("cad edit", body)?;
        return Ok(Status::Done);
    }
    render::print_all(&source, &warnings);
    render::print_all(&after, &new);
    let count = counted(edits.len(), "edit", "edits");
    output::report(&format!("wrote {} ({count})", output.display()))?;
    Ok(Status::Done)
}

fn statement(subject: Subject, change: &Change, named: &args::Named) -> Statement {
    let mut statement = Statement {
        subject,
        name: named.name.clone(),
        kind: named.kind.clone(),
        entities: named.entities.iter().map(|&handle| Handle(handle)).collect(),
        at: None,
        to: None,
        axis: None,
        values: Vec::new(),
    };
    if let Change::Add(args) | Change::Set(args) = change {
        (statement.at, statement.to, statement.axis) = (args.at, args.to, args.axis);
        statement.values.clone_from(&args.values);
    }
    statement
}

/// Lines move with an edit: the words alone tell whether a fault was there before.
fn is_new(fault: &Diagnostic, before: &[Diagnostic]) -> bool {
    !before.iter().any(|it| it.code == fault.code && it.message == fault.message)
}

/// The file that will be written. One that exists and was not read is replaced if an earlier edit of this drawing has
/// made it, anything else only with `--force`.
fn output_path(named: &args::Named) -> Result<PathBuf, Failure> {
    let Some(output) = &named.output else { return Ok(named.drawing.clone()) };
    let kind = |path: &Path| path.extension().map(std::ffi::OsStr::to_ascii_lowercase);
    if kind(output) != kind(&named.drawing) {
        let message = format!("`{}` is another kind of file than the drawing", output.display());
        return Err(Failure::usage(message, "an edited drawing keeps its format"));
    }
    let label = label_of(&named.drawing);
    let is_own = || is_same_file(output, &named.drawing) || is_of_model(output, &label);
    if output.exists() && !named.force && !is_own() {
        return Err(exists(output));
    }
    Ok(output.clone())
}
