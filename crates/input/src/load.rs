//! From a path to a model: a model file, a drawing, or a model file beside a drawing.

use std::fs;
use std::path::Path;

use bksim::cad::compose::named_drawing;
use bksim::model::Model;
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{Limits, Reading, Recording, Source, decode, read_recorded};

use crate::drawn;
use crate::error::InputError;
use crate::text::Text;

/// Larger model files are refused: a mechanism of ten thousand bodies takes a tenth of this.
const LARGEST_MODEL_BYTES: u64 = 64 * 1024 * 1024;

/// What to load, and how.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// A model file or a drawing.
    pub path: &'a Path,
    /// Definitions in place of those of parameters.
    pub overrides: &'a [(String, String)],
    /// The unit of a drawing that states none, `mm`.
    pub unit: Option<&'a str>,
    /// How far apart points of a drawing may be that are one, in units of the drawing.
    pub tolerance: Option<f64>,
    /// What is accepted of a model's text.
    pub limits: Limits,
}

impl<'a> Request<'a> {
    /// The file as it is.
    pub fn new(path: &'a Path) -> Self {
        Self { path, overrides: &[], unit: None, tolerance: None, limits: Limits::default() }
    }
}

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

/// Opens and reads a model: a model file, a drawing, or a model file beside a drawing.
///
/// # Errors
/// [`InputError`].
pub fn load(request: &Request<'_>) -> Result<Loaded, InputError> {
    let path = request.path;
    let bytes = read_bytes(path)?;
    let name = path.file_stem().map_or_else(|| "model".into(), |stem| stem.to_string_lossy());
    let name = default_name(path, &name);
    let (source, warnings) = if is_drawing(&bytes, path) {
        drawn::compose(path, bytes, None, request)?
    } else {
        let text = Text::new(path, utf8(path, &bytes)?);
        match named_drawing(&text.text) {
            Some(drawing) => drawn::beside(text, &drawing, request)?,
            None => (text, Vec::new()),
        }
    };
    let mut loaded = parse(source, &name, request.overrides, request.limits)?;
    loaded.warnings.splice(0..0, warnings);
    Ok(loaded)
}

/// The bytes of a file that is small enough to be a model.
///
/// # Errors
/// [`InputError`] when it cannot be read, or is too large.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, InputError> {
    let known = fs::metadata(path).map_err(|e| InputError::reading(path, &e))?;
    if known.is_dir() {
        let help = Some(format!("name a file in it: `{}`", path.join("model.toml").display()));
        let what = "is a directory, not a model file".to_owned();
        return Err(InputError::File { path: path.to_owned(), what, help });
    }
    let size = known.len();
    if size > LARGEST_MODEL_BYTES {
        let what = format!("is {size} bytes long; a model may have {LARGEST_MODEL_BYTES}");
        return Err(InputError::NoModel { path: path.to_owned(), what });
    }
    fs::read(path).map_err(|e| InputError::reading(path, &e))
}

fn utf8(path: &Path, bytes: &[u8]) -> Result<String, InputError> {
    match decode(bytes) {
        Ok(text) => Ok(text.to_owned()),
        Err(fault) => {
            let text = String::from_utf8_lossy(bytes);
            Err(Text::new(path, text).rejected(vec![fault]))
        }
    }
}

/// Whether a file is a drawing: by what it holds, or, where it holds something else, by its name.
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

/// As [`parse`], with how values follow from parameters that vary; see
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
    let text = &source.text;
    let (Reading { model, diagnostics }, recording) =
        read_recorded(&Source { text, name, overrides, limits }, varied);
    match model {
        Some(model) => Ok((Loaded { source, model, warnings: diagnostics }, recording)),
        None => Err(source.rejected(diagnostics)),
    }
}

/// `examples/slider-crank/model.toml` and `drawing.dxf` are called after their directory.
fn default_name(path: &Path, stem: &str) -> String {
    let directory = path.parent().and_then(Path::file_name);
    match directory {
        Some(directory) if stem == "model" || stem == "drawing" => {
            directory.to_string_lossy().into_owned()
        }
        _ => stem.to_owned(),
    }
}
