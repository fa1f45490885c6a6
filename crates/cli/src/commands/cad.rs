//! `bksim cad`: what is in a drawing, and drawings from models.

mod dist;
mod doctor;
mod edit;
mod from_toml;
mod list;
mod mass;
mod template;
mod to_toml;
mod trace;
mod written;

use std::path::{Path, PathBuf};

use bksim::cad::compose::{Composition, named_drawing};
use bksim::cad::container::is_drawing;
use bksim::cad::edit::Subject;
use bksim::cad::model::{ModelOptions, Sheet};
use bksim::model::diagnostic::Diagnostic;

use crate::args::DrawingArgs;
use crate::args::cad::Cad;
use crate::exit::{Failure, Status};
use crate::render;
use crate::source::{Text, read_bytes, read_sheet};

/// The name of a command in its JSON object.
pub(crate) fn name(command: &Cad) -> &'static str {
    match command {
        Cad::Mass(_) => "cad mass",
        Cad::Dist(_) => "cad dist",
        Cad::List(_) => "cad list",
        Cad::Doctor(_) => "cad doctor",
        Cad::ToToml(_) => "cad to-toml",
        Cad::Body(_) | Cad::Joint(_) | Cad::Load(_) | Cad::Drive(_) => "cad edit",
        Cad::Template(_) => "cad template",
        Cad::FromToml(_) => "cad from-toml",
        Cad::Trace(_) => "cad trace",
    }
}

pub(crate) fn run(command: &Cad, json: bool, nesting: usize) -> Result<Status, Failure> {
    match command {
        Cad::Mass(args) => mass::run(args, json),
        Cad::Dist(args) => dist::run(args, json),
        Cad::List(args) => list::run(args, json),
        Cad::Doctor(args) => doctor::run(args, json),
        Cad::ToToml(args) => to_toml::run(args, json, nesting),
        Cad::Body(change) => edit::run(Subject::Body, change, json),
        Cad::Joint(change) => edit::run(Subject::Joint, change, json),
        Cad::Load(change) => edit::run(Subject::Load, change, json),
        Cad::Drive(change) => edit::run(Subject::Drive, change, json),
        Cad::Template(args) => template::run(args, json),
        Cad::FromToml(args) => from_toml::run(args, json, nesting),
        Cad::Trace(args) => trace::run(args, json, nesting),
    }
}

/// A drawing with its parts, and what is wrong with it in the drawing's own terms.
struct Parts {
    sheet: Sheet,
    composition: Composition,
    source: Text,
}

/// Reads the parts of a drawing; faults that `is_harmless` are left out, errors refuse it.
fn parts(
    path: &Path,
    args: &DrawingArgs,
    plate: [Option<&str>; 2],
    is_harmless: fn(&Diagnostic) -> bool,
) -> Result<Parts, Failure> {
    let (drawing, sidecar) = drawing_of(path)?;
    let path = drawing.as_path();
    let sheet = read_sheet(path, read_bytes(path)?, args)?;
    let sidecar = sidecar.as_deref();
    let options =
        ModelOptions { tolerance: args.tolerance, plate, sidecar, ..ModelOptions::default() };
    let mut composition = sheet.compose(options);
    composition.diagnostics.retain(|fault| !is_harmless(fault));
    let source = Text::new(path.to_owned(), sheet.text.clone());
    if composition.diagnostics.iter().any(Diagnostic::is_error) {
        return Err(source.rejected(composition.diagnostics).into());
    }
    Ok(Parts { sheet, composition, source })
}

/// The drawing that is meant, and the text of the model file next to it if that was named.
fn drawing_of(path: &Path) -> Result<(PathBuf, Option<String>), Failure> {
    let bytes = read_bytes(path)?;
    let text = std::str::from_utf8(&bytes).ok().filter(|_| !is_drawing(&bytes));
    let Some((text, drawing)) = text.and_then(|text| Some((text, named_drawing(text)?))) else {
        return Ok((path.to_owned(), None));
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    Ok((folder.join(drawing), Some(text.to_owned())))
}

impl Parts {
    fn print_warnings(&self) {
        render::print_all(&self.source, &self.composition.diagnostics);
    }
}

/// Bodies without mass are no fault where only their shapes are asked for.
fn is_missing_mass(fault: &Diagnostic) -> bool {
    fault.code == bksim::cad::codes::NO_MASS
}
