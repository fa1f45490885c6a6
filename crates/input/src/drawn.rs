//! Models that come out of drawings, and where in the drawing, or in the file beside it, their faults
//! are.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bksim::cad::compose::{Composition, Origin};
use bksim::cad::excerpt::{Excerpts, describe};
use bksim::cad::model::{ModelOptions, Refused, Sheet, sheet};
use bksim::cad::units;
use bksim::model::diagnostic::{Diagnostic, Label};
use bksim::model::file::check_syntax;

use crate::error::InputError;
use crate::load::{Request, read_bytes};
use crate::text::{Text, line_and_column};

/// What a text was composed from.
#[derive(Debug)]
pub struct Drawn {
    drawing: PathBuf,
    drawing_text: String,
    /// The model file beside the drawing.
    side: Option<(PathBuf, String)>,
    /// The composed model, its diagnostics taken out.
    pub composition: Composition,
}

/// A diagnostic in the file it is about.
#[derive(Clone, PartialEq, Debug)]
pub struct Located<'t> {
    /// The file.
    pub path: &'t Path,
    /// Its text, which the spans are of.
    pub text: &'t str,
    /// The diagnostic with spans of that text.
    pub fault: Diagnostic,
}

/// A drawing and what is attached to it; `unit` is what one unit of it is unless it says so.
///
/// # Errors
/// [`InputError`] when the unit is none, or the bytes are no drawing.
pub fn read_sheet(path: &Path, bytes: Vec<u8>, unit: Option<&str>) -> Result<Sheet, InputError> {
    let known = |name: &str| units::by_name(name).ok_or(InputError::Unit { name: name.to_owned() });
    let unit = unit.map(known).transpose()?;
    sheet(bytes, unit)
        .map_err(|Refused { text, diagnostics }| Text::new(path, text).rejected(diagnostics))
}

/// Composes the model of a drawing, with the warnings that came of it.
pub(crate) fn compose(
    path: &Path,
    bytes: Vec<u8>,
    side: Option<Text>,
    request: &Request<'_>,
) -> Result<(Text, Vec<Diagnostic>), InputError> {
    let sheet = read_sheet(path, bytes, request.unit)?;
    let options = ModelOptions {
        side: side.as_ref().map(|side| side.text.as_str()),
        tolerance: request.tolerance,
        ..ModelOptions::default()
    };
    let mut composition = sheet.compose(options);
    let diagnostics = std::mem::take(&mut composition.diagnostics);
    let text = composition.text.clone();
    let shown = side.as_ref().map_or(path, |side| &side.path).to_owned();
    let drawn = Drawn {
        drawing: path.to_owned(),
        drawing_text: sheet.text,
        side: side.map(|side| (side.path, side.text)),
        composition,
    };
    // Faults of the drawing have spans of its text, which comes behind the composed one.
    let diagnostics: Vec<Diagnostic> =
        diagnostics.into_iter().map(|fault| moved(fault, text.len() + 1)).collect();
    let source = Text { path: shown, text, drawn: Some(Arc::new(drawn)) };
    if diagnostics.iter().any(Diagnostic::is_error) {
        return Err(source.rejected(diagnostics));
    }
    Ok((source, diagnostics))
}

/// Composes the model of a file that names a drawing.
pub(crate) fn beside(
    side: Text,
    drawing: &str,
    request: &Request<'_>,
) -> Result<(Text, Vec<Diagnostic>), InputError> {
    let faults = check_syntax(&side.text, request.limits);
    if faults.iter().any(Diagnostic::is_error) {
        return Err(side.rejected(faults));
    }
    let path = side.path.parent().unwrap_or(Path::new("")).join(drawing);
    let bytes = read_bytes(&path)?;
    compose(&path, bytes, Some(side), request)
}

fn moved(mut fault: Diagnostic, by: usize) -> Diagnostic {
    for label in &mut fault.labels {
        label.span = label.span.start + by..label.span.end + by;
    }
    fault
}

/// The files that a text may come from.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Home {
    Drawing,
    Side,
    Composed,
}

impl Drawn {
    pub(crate) fn files(&self) -> Vec<&Path> {
        let side = self.side.as_ref().map(|(path, _)| path.as_path());
        std::iter::once(self.drawing.as_path()).chain(side).collect()
    }

    /// Puts a diagnostic of the composed text into the file that its first label is about; labels in
    /// other files become notes.
    pub(crate) fn locate<'t>(&'t self, text: &'t Text, fault: &Diagnostic) -> Located<'t> {
        let mut moved = Diagnostic { labels: Vec::new(), ..fault.clone() };
        let mut home = None;
        for label in &fault.labels {
            let (found, label) = self.place(text, label, &mut moved);
            let Some(label) = label else {
                home = home.or(Some(found));
                continue;
            };
            if *home.get_or_insert(found) == found {
                moved.labels.push(label);
                continue;
            }
            let (path, words) = self.file(text, found);
            let (line, column) = line_and_column(words, label.span.start);
            let place = format!("{}:{line}:{column}", path.display());
            moved.notes.push(format!("{place}: {}", label.text));
        }
        let (path, words) = self.file(text, home.unwrap_or(Home::Drawing));
        Located { path, text: words, fault: moved }
    }

    fn file<'t>(&'t self, text: &'t Text, home: Home) -> (&'t Path, &'t str) {
        match (home, &self.side) {
            (Home::Side, Some((path, words))) => (path, words),
            (Home::Composed, _) => (&text.path, &text.text),
            (Home::Drawing | Home::Side, _) => (&self.drawing, &self.drawing_text),
        }
    }

    /// The file of a label and the label there; what has no text is noted in words.
    fn place(&self, text: &Text, label: &Label, fault: &mut Diagnostic) -> (Home, Option<Label>) {
        let offset = text.text.len() + 1;
        if label.span.start >= offset {
            let span = label.span.start - offset..label.span.end - offset;
            return (Home::Drawing, Some(Label { span, text: label.text.clone() }));
        }
        match self.composition.origin(&label.span) {
            Origin::Side(span) => (Home::Side, Some(Label { span, text: label.text.clone() })),
            Origin::Composed => (Home::Composed, Some(label.clone())),
            Origin::Drawing(place) => {
                let what = describe(&place);
                let words =
                    if label.text.is_empty() { what } else { format!("{}: {what}", label.text) };
                let span = Excerpts::new(&self.drawing_text).first_line(&place);
                if span.is_none() {
                    fault.notes.push(words.clone());
                }
                (Home::Drawing, span.map(|span| Label { span, text: words }))
            }
        }
    }
}
