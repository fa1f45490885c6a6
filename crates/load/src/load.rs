//! From a path to a model: a model file, a drawing, or a model file that names its drawing.

use std::path::Path;

use bksim::analysis::with_held_assembly;
use bksim::cad::compose::named_drawing;
use bksim::model::Model;
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{Limits, Reading, Recording, Source, decode, read_recorded};

use crate::drawing::{compose, compose_named};
use crate::error::InputError;
use crate::file::{STDIN, is_stdin, read_bytes};
use crate::parts::whole;
use crate::request::Request;
use crate::text::Text;

/// A model that was read, with its text and its warnings.
#[derive(Debug)]
pub struct Loaded {
    /// The text it was read from.
    pub source: Text,
    /// The model.
    pub model: Model,
    /// Warnings found on the way.
    pub warnings: Vec<Diagnostic>,
}

/// Opens and reads a model: a model file, a drawing, or a model file that names its drawing.
///
/// # Errors
/// [`InputError`].
pub fn load(request: &Request<'_>) -> Result<Loaded, InputError> {
    let bytes = read_bytes(request.path)?;
    let path = if is_stdin(request.path) { Path::new(STDIN) } else { request.path };
    if is_drawing(&bytes, path) {
        return completed(compose(path, bytes, None, request)?, path, request);
    }
    load_text(Text::new(path, utf8(path, &bytes)?), request)
}

/// Reads the text of a model file as [`load`] does, whatever the file has; a drawing that it names is opened.
///
/// # Errors
/// [`InputError`].
pub fn load_text(text: Text, request: &Request<'_>) -> Result<Loaded, InputError> {
    let path = text.path.clone();
    let composed = match named_drawing(&text.text) {
        Some(drawing) => compose_named(text, &drawing, request)?,
        None => (text, Vec::new()),
    };
    completed(composed, &path, request)
}

/// The model of a text, with the parts that it uses.
fn completed(
    (source, mut warnings): (Text, Vec<Diagnostic>),
    path: &Path,
    request: &Request<'_>,
) -> Result<Loaded, InputError> {
    let Request { overrides, limits, is_geometry, .. } = *request;
    let name = name_of(path);
    // Warnings about a drawing have their places in the text without parts.
    let is_drawn = source.drawn.is_some();
    let (source, of_parts) = whole(source, limits)?;
    if is_drawn && source.parts.is_some() {
        for fault in &mut warnings {
            fault.labels.clear();
        }
    }
    warnings.extend(of_parts);
    let (mut loaded, _) = read_text(source, |text| {
        let source = Source { overrides, limits, is_geometry, ..Source::new(text, &name) };
        read_recorded(&source, &[])
    })?;
    loaded.warnings.splice(0..0, warnings);
    Ok(loaded)
}

fn utf8(path: &Path, bytes: &[u8]) -> Result<String, InputError> {
    match decode(bytes) {
        // Line ends of old programs, a carriage return alone: TOML knows none.
        Ok(text) if !text.contains('\n') => Ok(text.replace('\r', "\n")),
        Ok(text) => Ok(text.to_owned()),
        Err(fault) => {
            let text = String::from_utf8_lossy(bytes);
            Err(Text::new(path, text).rejected(vec![fault]))
        }
    }
}

/// True for a drawing, and for a model file that names one.
pub fn is_drawn(path: &Path) -> bool {
    let Ok(bytes) = read_bytes(path) else { return false };
    is_drawing(&bytes, path) || decode(&bytes).is_ok_and(|text| named_drawing(text).is_some())
}

/// Whether a file is a drawing: by its bytes, or, where they are something else, by its name.
fn is_drawing(bytes: &[u8], path: &Path) -> bool {
    let ending = path.extension().map(std::ffi::OsStr::to_ascii_lowercase);
    let is_named = ending.is_some_and(|ending| ending == "dxf" || ending == "dwg");
    is_named || bksim::cad::container::recognise(bytes).is_ok()
}

/// Reads the text of a model.
///
/// # Errors
/// [`InputError::Model`] with every fault.
pub fn parse(
    source: Text,
    name: &str,
    overrides: &[(String, String)],
    limits: Limits,
) -> Result<Loaded, InputError> {
    parse_recorded(source, name, overrides, &[], limits).map(|(loaded, _)| loaded)
}

/// Model as of [`parse`], with how values follow from parameters that vary; see
/// [`bksim::model::file::read_recorded`].
///
/// # Errors
/// [`InputError::Model`] with every fault.
pub fn parse_recorded(
    source: Text,
    name: &str,
    overrides: &[(String, String)],
    varied: &[String],
    limits: Limits,
) -> Result<(Loaded, Option<Recording>), InputError> {
    let (source, of_parts) = whole(source, limits)?;
    let (mut loaded, recording) = read_text(source, |text| {
        read_recorded(&Source { overrides, limits, ..Source::new(text, name) }, varied)
    })?;
    loaded.warnings.splice(0..0, of_parts);
    Ok((loaded, recording))
}

fn read_text(
    source: Text,
    read: impl FnOnce(&str) -> (Reading, Option<Recording>),
) -> Result<(Loaded, Option<Recording>), InputError> {
    let (Reading { model, diagnostics }, recording) = read(&source.text);
    match model {
        Some(model) => match with_held_assembly(model) {
            Ok(model) => {
                let warnings = source.distinct(diagnostics);
                Ok((Loaded { source, model, warnings }, recording))
            }
            Err(error) => Err(source.rejected(error.diagnostics())),
        },
        None => Err(source.rejected(diagnostics)),
    }
}

/// The name of a model's file, after which results are called: its name without ending. `model.toml` and
/// `drawing.dxf` have the name of their folder, and standard input is `model`.
pub fn name_of(path: &Path) -> String {
    let stem = path.file_stem().map_or_else(|| "model".into(), |stem| stem.to_string_lossy());
    if is_stdin(path) || path == Path::new(STDIN) {
        return "model".to_owned();
    }
    let is_common = stem == "model" || stem == "drawing";
    match path.parent().and_then(Path::file_name) {
        Some(folder) if is_common => folder.to_string_lossy().into_owned(),
        _ => stem.into_owned(),
    }
}

/// The name of a file with its ending and its folder, `slider-crank/model.toml`: how a result says which file it was
/// made from, wherever the folder is.
pub fn label_of(path: &Path) -> String {
    if is_stdin(path) {
        return STDIN.to_owned();
    }
    let whole = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let file = whole.file_name().unwrap_or_default().to_string_lossy().into_owned();
    match whole.parent().and_then(Path::file_name) {
        Some(folder) => format!("{}/{file}", folder.to_string_lossy()),
        None => file,
    }
}
