//! Models that come out of drawings, and where in the drawing, or in the file beside it, their faults
//! are.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use bksim::cad::compose::{Composition, Origin};
use bksim::cad::excerpt::{Excerpts, describe};
use bksim::cad::model::{ModelOptions, Refused, Sheet, sheet};
use bksim::cad::units;
use bksim::mbs::diagnostic::{Diagnostic, Label};
use bksim::mbs::file::{Limits, check_syntax};

use super::{Text, read_bytes};
use crate::args::{DrawingArgs, ModelArgs};
use crate::exit::Failure;

/// What a text was composed from.
#[derive(Debug)]
pub(crate) struct Drawn {
    drawing: PathBuf,
    drawing_text: String,
    /// The model file beside the drawing.
    side: Option<(PathBuf, String)>,
    /// The composed model.
    pub(crate) composition: Composition,
}

/// A diagnostic in the file it is about.
pub(crate) struct Located<'t> {
    pub(crate) path: &'t Path,
    pub(crate) text: &'t str,
    pub(crate) fault: Diagnostic,
}

/// A drawing and what is attached to it.
pub(crate) fn read_sheet(
    path: &Path,
    bytes: Vec<u8>,
    args: &DrawingArgs,
) -> Result<Sheet, Failure> {
    let unit = match &args.units {
        None => None,
        Some(name) => Some(units::by_name(name).ok_or_else(|| {
            let help = "one of mm, cm, m, inch, ft, …: `bksim explain D006` lists them";
            Failure::usage(format!("`--units {name}` is no unit of length"), help)
        })?),
    };
    sheet(bytes, unit).map_err(|Refused { text, diagnostics }| {
        let source = Box::new(Text { path: path.to_owned(), text, drawn: None });
        Failure::Model { source, diagnostics }
    })
}

/// Composes the model of a drawing, with the warnings that came of it.
pub(super) fn compose(
    path: &Path,
    bytes: Vec<u8>,
    side: Option<Text>,
    args: &ModelArgs,
) -> Result<(Text, Vec<Diagnostic>), Failure> {
    let sheet = read_sheet(path, bytes, &args.drawing)?;
    let options = ModelOptions {
        side: side.as_ref().map(|side| side.text.as_str()),
        tolerance: args.drawing.tolerance,
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
    let source = Text { path: shown, text, drawn: Some(Rc::new(drawn)) };
    if diagnostics.iter().any(Diagnostic::is_error) {
        return Err(Failure::Model { source: Box::new(source), diagnostics });
    }
    Ok((source, diagnostics))
}

/// Composes the model of a file that names a drawing.
pub(super) fn beside(
    side: Text,
    drawing: &str,
    args: &ModelArgs,
    max_nesting: usize,
) -> Result<(Text, Vec<Diagnostic>), Failure> {
    let faults = check_syntax(&side.text, Limits { nesting: max_nesting });
    if faults.iter().any(Diagnostic::is_error) {
        return Err(Failure::Model { source: Box::new(side), diagnostics: faults });
    }
    let path = side.path.parent().unwrap_or(Path::new("")).join(drawing);
    let bytes = read_bytes(&path)?;
    compose(&path, bytes, Some(side), args)
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
    pub(super) fn files(&self) -> Vec<&Path> {
        let side = self.side.as_ref().map(|(path, _)| path.as_path());
        std::iter::once(self.drawing.as_path()).chain(side).collect()
    }

    /// Puts a diagnostic of the composed text into the file that its first label is about; labels in
    /// other files become notes.
    fn locate<'t>(&'t self, text: &'t Text, fault: &Diagnostic) -> Located<'t> {
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
            let (line, column) = super::line_and_column(words, label.span.start);
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

impl Text {
    /// A diagnostic in the file it is about.
    pub(crate) fn locate(&self, fault: &Diagnostic) -> Located<'_> {
        match &self.drawn {
            Some(drawn) => drawn.locate(self, fault),
            None => Located { path: &self.path, text: &self.text, fault: fault.clone() },
        }
    }
}
