//! Model files and drawings: opened here, read by the library.

mod drawn;
pub(crate) mod logged;

use std::fs;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use bksim::Mechanism;
use bksim::cad::compose::named_drawing;
use bksim::mbs::diagnostic::{Code, Diagnostic, Severity};
use bksim::mbs::file::{Limits, Reading, Source, decode, read};
use bksim::mbs::model::Model;

use crate::args::ModelArgs;
use crate::exit::Failure;

pub(crate) use self::drawn::{Drawn, Located, read_sheet};

/// Larger model files are refused: a mechanism of ten thousand bodies takes a tenth of this.
const LARGEST_MODEL_BYTES: u64 = 64 * 1024 * 1024;

/// The text of a model, for excerpts in messages.
#[derive(Clone, Debug)]
#[expect(clippy::struct_field_names, reason = "the text of a `Text` is its text")]
pub(crate) struct Text {
    pub(crate) path: PathBuf,
    pub(crate) text: String,
    /// Where the text comes from, if it came out of a drawing.
    pub(crate) drawn: Option<Rc<Drawn>>,
}

/// A model that was read, with its text and its warnings.
#[derive(Debug)]
pub(crate) struct Loaded {
    pub(crate) source: Text,
    pub(crate) model: Model,
    pub(crate) warnings: Vec<Diagnostic>,
}

/// Opens and reads a model: a model file, a drawing, or a model file beside a drawing.
pub(crate) fn load(args: &ModelArgs, max_nesting: usize) -> Result<Loaded, Failure> {
    let path = &args.model;
    let bytes = read_bytes(path)?;
    let name = path.file_stem().map_or_else(|| "model".into(), |stem| stem.to_string_lossy());
    let name = default_name(path, &name);
    let (source, warnings) = if is_drawing(&bytes, path) {
        drawn::compose(path, bytes, None, args)?
    } else {
        let text = Text { path: path.clone(), text: utf8(path, &bytes)?, drawn: None };
        match named_drawing(&text.text) {
            Some(drawing) => drawn::beside(text, &drawing, args, max_nesting)?,
            None => (text, Vec::new()),
        }
    };
    let mut loaded = parse(source, &name, &args.set, max_nesting)?;
    loaded.warnings.splice(0..0, warnings);
    Ok(loaded)
}

/// The bytes of a file that is small enough to be a model.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    let known = fs::metadata(path).map_err(|e| Failure::reading(path, &e))?;
    if known.is_dir() {
        let help = Some(format!("name a file in it: `{}`", path.join("model.toml").display()));
        return Err(Failure::file(path, "is a directory, not a model file".to_owned(), help));
    }
    let size = known.len();
    if size > LARGEST_MODEL_BYTES {
        let what = format!("is {size} bytes long; a model may have {LARGEST_MODEL_BYTES}");
        return Err(Failure::Input { path: path.to_owned(), what, help: None });
    }
    fs::read(path).map_err(|e| Failure::reading(path, &e))
}

fn utf8(path: &Path, bytes: &[u8]) -> Result<String, Failure> {
    match decode(bytes) {
        Ok(text) => Ok(text.to_owned()),
        Err(fault) => {
            let text = String::from_utf8_lossy(bytes).into_owned();
            let source = Box::new(Text { path: path.to_owned(), text, drawn: None });
            Err(Failure::Model { source, diagnostics: vec![fault] })
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
pub(crate) fn parse(
    source: Text,
    name: &str,
    overrides: &[(String, String)],
    max_nesting: usize,
) -> Result<Loaded, Failure> {
    let limits = Limits { nesting: max_nesting };
    let Reading { model, diagnostics } =
        read(&Source { text: &source.text, name, overrides, limits });
    match model {
        Some(model) => Ok(Loaded { source, model, warnings: diagnostics }),
        None => Err(Failure::Model { source: Box::new(source), diagnostics }),
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

/// Derives the equations, passing faults on with their text.
pub(crate) fn derive(source: &Text, model: Model) -> Result<Mechanism, Failure> {
    Mechanism::derive(model, Vec::new()).map_err(|rejected| source.rejected(rejected.0))
}

impl Text {
    pub(crate) fn rejected(&self, diagnostics: Vec<Diagnostic>) -> Failure {
        Failure::Model { source: Box::new(self.clone()), diagnostics }
    }

    /// Whether a file is one of those that the model was read from.
    pub(crate) fn files(&self) -> Vec<&Path> {
        match &self.drawn {
            Some(drawn) => drawn.files(),
            None => vec![&self.path],
        }
    }
}

/// Line and column of a byte, counted from one, columns in characters.
pub(crate) fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let mut end = byte.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let before = &text[..end];
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    let line = before.matches('\n').count() + 1;
    (line, before[line_start..].chars().count() + 1)
}

/// The severity in the words of a message.
pub(crate) fn severity_word(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    }
}

/// The code as text.
pub(crate) fn code_text(code: Code) -> &'static str {
    code.0
}
