//! Models for commands: read by the library, their faults as failures of a command.

pub mod logged;
pub mod motion;
pub mod shown;

use std::path::Path;

use bksim::Mechanism;
use bksim::cad::model::Sheet;
use bksim::model::Model;
use bksim::model::file::Limits;
use bksim_load::Request;
pub use bksim_load::{Loaded, Text, is_stdin};

use crate::args::{DrawingArgs, ModelArgs};
use crate::exit::Failure;
use crate::output;
use crate::waiting::waiting;

/// Opens and reads a model: a model file, a drawing, or a model file next to a drawing.
///
/// # Errors
/// A file that cannot be read, or faults of the model.
pub fn load(args: &ModelArgs, max_nesting: usize) -> Result<Loaded, Failure> {
    load_as(args, max_nesting, false)
}

/// Model as of [`load()`], for positions alone: bodies need no masses.
///
/// # Errors
/// As [`load()`].
pub fn load_geometry(args: &ModelArgs, max_nesting: usize) -> Result<Loaded, Failure> {
    load_as(args, max_nesting, true)
}

fn load_as(args: &ModelArgs, max_nesting: usize, is_geometry: bool) -> Result<Loaded, Failure> {
    output::about_case(args.set.case());
    let request = Request {
        path: &args.model,
        overrides: &args.set,
        unit: args.drawing.units.as_deref(),
        tolerance: args.drawing.tolerance,
        limits: Limits { nesting: max_nesting },
        is_geometry,
    };
    Ok(bksim_load::load(&request)?)
}

/// The bytes of a file that is small enough to be a model.
///
/// # Errors
/// A file that cannot be read.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    Ok(bksim_load::read_bytes(path)?)
}

/// A drawing and what is attached to it.
pub(crate) fn read_sheet(
    path: &Path,
    bytes: Vec<u8>,
    args: &DrawingArgs,
) -> Result<Sheet, Failure> {
    Ok(bksim_load::read_sheet(path, bytes, args.units.as_deref())?)
}

/// Reads the text of a model.
pub(crate) fn parse(
    source: Text,
    name: &str,
    overrides: &[(String, String)],
    max_nesting: usize,
) -> Result<Loaded, Failure> {
    Ok(bksim_load::parse(source, name, overrides, Limits { nesting: max_nesting })?)
}

/// Derives the equations, passing faults on with their text.
///
/// # Errors
/// Faults of the model.
pub fn derive(source: &Text, model: Model) -> Result<Mechanism, Failure> {
    let derived = waiting("deriving the equations", || Mechanism::derive(model, Vec::new()));
    derived.map_err(|rejected| source.rejected(rejected.0).into())
}
