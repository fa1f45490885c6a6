//! Models that come out of drawings: a drawing alone, or with its sidecar, the model file next to it.

use std::path::Path;
use std::sync::Arc;

use bksim::cad::model::{ModelOptions, Refused, Sheet, sheet};
use bksim::cad::units;
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::check_syntax;

use crate::error::InputError;
use crate::file::read_bytes;
use crate::request::Request;
use crate::text::{Drawn, Text, drawing_offset, moved_by};

/// A drawing with its attachments; `unit` is the length of one unit of a drawing that states none.
///
/// # Errors
/// [`InputError`] when the unit is none, or the bytes are no drawing.
pub fn read_sheet(path: &Path, bytes: Vec<u8>, unit: Option<&str>) -> Result<Sheet, InputError> {
    let known = |name: &str| units::by_name(name).ok_or(InputError::Unit { name: name.to_owned() });
    let unit = unit.map(known).transpose()?;
    sheet(bytes, unit)
        .map_err(|Refused { text, diagnostics }| Text::new(path, text).rejected(diagnostics))
}

/// Composes the model of a drawing; returns its text and the warnings about the drawing.
pub(crate) fn compose(
    path: &Path,
    bytes: Vec<u8>,
    sidecar: Option<Text>,
    request: &Request<'_>,
) -> Result<(Text, Vec<Diagnostic>), InputError> {
    let sheet = read_sheet(path, bytes, request.unit)?;
    let options = ModelOptions {
        sidecar: sidecar.as_ref().map(|sidecar| sidecar.text.as_str()),
        tolerance: request.tolerance,
        is_geometry: request.is_geometry,
        ..ModelOptions::default()
    };
    let mut composition = sheet.compose(options);
    let diagnostics = std::mem::take(&mut composition.diagnostics);
    let text = composition.text.clone();
    let shown = sidecar.as_ref().map_or(path, |sidecar| &sidecar.path).to_owned();
    let drawn = Drawn {
        drawing: path.to_owned(),
        drawing_text: sheet.text,
        sidecar: sidecar.map(|sidecar| (sidecar.path, sidecar.text)),
        composition,
    };
    let offset = drawing_offset(&text);
    let diagnostics: Vec<Diagnostic> =
        diagnostics.into_iter().map(|fault| moved_by(fault, offset)).collect();
    let drawn = Some(Arc::new(drawn));
    let source = Text { drawn, ..Text::new(shown, text) };
    if diagnostics.iter().any(Diagnostic::is_error) {
        return Err(source.rejected(diagnostics));
    }
    Ok((source, diagnostics))
}

/// Composes the model of a file that names a drawing.
pub(crate) fn compose_named(
    sidecar: Text,
    drawing: &str,
    request: &Request<'_>,
) -> Result<(Text, Vec<Diagnostic>), InputError> {
    let faults = check_syntax(&sidecar.text, request.limits);
    if faults.iter().any(Diagnostic::is_error) {
        return Err(sidecar.rejected(faults));
    }
    let folder = sidecar.path.parent().unwrap_or(Path::new(""));
    let path = folder.join(drawing);
    let is_here = folder.as_os_str().is_empty();
    refuse_outside(if is_here { Path::new(".") } else { folder }, &path, &sidecar)?;
    let bytes = read_bytes(&path)?;
    compose(&path, bytes, Some(sidecar), request)
}

/// Refuses a file that does not lie in a folder, when all links are resolved: a model from elsewhere has no
/// business with other files.
fn refuse_outside(folder: &Path, path: &Path, named_in: &Text) -> Result<(), InputError> {
    // One that is not there has its own fault.
    let [Ok(folder), Ok(found)] = [folder.canonicalize(), path.canonicalize()] else {
        return Ok(());
    };
    if found.starts_with(&folder) {
        return Ok(());
    }
    let what =
        format!("lies outside of the folder of `{}`, which names it", named_in.path.display());
    let help = Some("copy the drawing next to the model".to_owned());
    Err(InputError::File { path: path.to_owned(), what, help })
}
