//! The text of a model and the files it came from: a fault in it is shown in the file that its author
//! wrote.
//!
//! A text composed from a drawing has spans of three files. Below its length they are spans of the
//! composed text, whose values come from the drawing or from the sidecar, the model file next to it;
//! above, they are spans of the drawing's text, which follows the composed one after a gap of one byte.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bksim::cad::compose::{Composition, Origin};
use bksim::cad::excerpt::{Excerpts, describe};
use bksim::model::diagnostic::{Diagnostic, Label};
use bksim::model::file::Expansion;

/// The text of a model, for excerpts in messages.
#[derive(Clone, Debug)]
pub struct Text {
    /// The file it is from; the name that stands in messages.
    pub path: PathBuf,
    /// The text.
    pub text: String,
    /// The files it was composed from, if it came out of a drawing.
    pub drawn: Option<Arc<Drawn>>,
    /// The files that it was put together from, if it has parts.
    pub parts: Option<Arc<Parts>>,
    /// True where a program put it together from parts of its own: then no file has its lines.
    pub is_built: bool,
}

/// A model with the files of its parts.
#[derive(Debug)]
pub struct Parts {
    pub(crate) expansion: Expansion,
    /// Paths of its files, in their order.
    pub(crate) paths: Vec<PathBuf>,
    /// The model as it was before.
    pub(crate) model: Text,
}

/// The files that a text was composed from.
#[derive(Debug)]
pub struct Drawn {
    pub(crate) drawing: PathBuf,
    pub(crate) drawing_text: String,
    /// Path and text of the model file next to the drawing.
    pub(crate) sidecar: Option<(PathBuf, String)>,
    /// The composed model, its diagnostics taken out.
    pub composition: Composition,
}

/// A diagnostic in the file it is about.
#[derive(Clone, PartialEq, Debug)]
pub struct Located<'t> {
    /// The file.
    pub path: &'t Path,
    /// Text that the spans are of.
    pub text: &'t str,
    /// The diagnostic with spans of that text.
    pub fault: Diagnostic,
}

impl Text {
    /// A text by itself.
    pub fn new(path: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        Self { path: path.into(), text: text.into(), drawn: None, parts: None, is_built: false }
    }

    /// The files that the model was read from.
    pub fn files(&self) -> Vec<&Path> {
        if let Some(parts) = &self.parts {
            let files = parts.paths.iter().zip(&parts.expansion.files).skip(1);
            let others = files.filter(|(_, file)| !file.is_of_library());
            let others = others.map(|(path, _)| path.as_path());
            return parts.model.files().into_iter().chain(others).collect();
        }
        let Some(drawn) = &self.drawn else { return vec![&self.path] };
        let sidecar = drawn.sidecar.as_ref().map(|(path, _)| path.as_path());
        std::iter::once(drawn.drawing.as_path()).chain(sidecar).collect()
    }

    /// Puts a diagnostic into the file that its first label is about; labels in other files become
    /// notes.
    pub fn locate(&self, fault: &Diagnostic) -> Located<'_> {
        if let Some(parts) = &self.parts {
            return parts.locate(fault);
        }
        let Some(drawn) = &self.drawn else {
            return Located { path: &self.path, text: &self.text, fault: fault.clone() };
        };
        // Faults of the drawing itself have its words already.
        let is_drawn = fault.code.0.starts_with('D');
        let words = |text: &String| {
            if is_drawn { text.clone() } else { drawn.composition.drawn_words(text) }
        };
        let mut moved = Diagnostic {
            labels: Vec::new(),
            message: words(&fault.message),
            notes: fault.notes.iter().map(words).collect(),
            help: fault.help.as_ref().map(words),
            ..fault.clone()
        };
        let mut home = None;
        for label in &fault.labels {
            let Site { file, label, note } = drawn.site(&self.text, label);
            moved.notes.extend(note);
            let Some(label) = label else {
                home = home.or(Some(file));
                continue;
            };
            if *home.get_or_insert(file) == file {
                moved.labels.push(label);
                continue;
            }
            let (path, text) = self.file(drawn, file);
            let (line, column) = line_and_column(text, label.span.start);
            moved.notes.push(format!("{}:{line}:{column}: {}", path.display(), label.text));
        }
        let (path, text) = self.file(drawn, home.unwrap_or(File::Drawing));
        Located { path, text, fault: moved }
    }

    /// Diagnostics that say different things: a part that is used twice has its faults twice.
    pub(crate) fn distinct(&self, diagnostics: Vec<Diagnostic>) -> Vec<Diagnostic> {
        if self.parts.is_none() {
            return diagnostics;
        }
        let mut located: Vec<Located<'_>> = Vec::new();
        let mut is_new = |fault: &Diagnostic| {
            let place = self.locate(fault);
            let is_new = !located.contains(&place);
            located.push(place);
            is_new
        };
        diagnostics.into_iter().filter(|fault| is_new(fault)).collect()
    }

    /// Path and text of a file that this text came from.
    fn file<'t>(&'t self, drawn: &'t Drawn, file: File) -> (&'t Path, &'t str) {
        match (file, &drawn.sidecar) {
            (File::Sidecar, Some((path, text))) => (path, text),
            (File::Composed, _) => (&self.path, &self.text),
            (File::Drawing | File::Sidecar, _) => (&drawn.drawing, &drawn.drawing_text),
        }
    }
}

impl Parts {
    /// Puts a diagnostic into the file that its first label is about.
    fn locate(&self, fault: &Diagnostic) -> Located<'_> {
        let mut moved = Diagnostic { labels: Vec::new(), ..fault.clone() };
        let mut home = None;
        for (file_idx, label) in fault.labels.iter().filter_map(|label| self.site(label)) {
            if *home.get_or_insert(file_idx) == file_idx {
                moved.labels.push(label);
                continue;
            }
            let (path, text) = (&self.paths[file_idx], &self.expansion.files[file_idx].text);
            let (line, column) = line_and_column(text, label.span.start);
            moved.notes.push(format!("{}:{line}:{column}: {}", path.display(), label.text));
        }
        match home.unwrap_or(0) {
            0 => self.model.locate(&moved),
            file_idx => Located {
                path: &self.paths[file_idx],
                text: &self.expansion.files[file_idx].text,
                fault: moved,
            },
        }
    }
}

/// A fault with all its spans later by `offset` bytes.
pub(crate) fn moved_by(mut fault: Diagnostic, offset: usize) -> Diagnostic {
    for label in &mut fault.labels {
        label.span = label.span.start + offset..label.span.end + offset;
    }
    fault
}

/// The files that a label may be in.
#[derive(Clone, Copy, PartialEq, Eq)]
enum File {
    Drawing,
    Sidecar,
    Composed,
}

/// The file of a label with the label there, or with a note where the file has no text to show.
struct Site {
    file: File,
    label: Option<Label>,
    note: Option<String>,
}

impl Drawn {
    /// The site of a label whose span is of the composed text with the drawing's text after it.
    fn site(&self, composed: &str, label: &Label) -> Site {
        let found = |file, span| {
            let label = Some(Label { span, text: label.text.clone() });
            Site { file, label, note: None }
        };
        let offset = drawing_offset(composed);
        if label.span.start >= offset {
            return found(File::Drawing, label.span.start - offset..label.span.end - offset);
        }
        match self.composition.origin(&label.span) {
            Origin::Sidecar(span) => found(File::Sidecar, span),
            Origin::Composed => found(File::Composed, label.span.clone()),
            Origin::Drawing(entity) => {
                let entity_text = describe(&entity);
                let text = match label.text.as_str() {
                    "" => entity_text,
                    text => format!("{text}: {entity_text}"),
                };
                match Excerpts::new(&self.drawing_text).first_line(&entity) {
                    Some(span) => {
                        let label = Some(Label { span, text });
                        Site { file: File::Drawing, label, note: None }
                    }
                    None => Site { file: File::Drawing, label: None, note: Some(text) },
                }
            }
        }
    }
}

/// Where spans of the drawing's text begin in diagnostics of a composed text.
pub(crate) fn drawing_offset(composed: &str) -> usize {
    composed.len() + 1
}

/// Line and column of a byte, counted from one, columns in characters.
pub fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let mut end = byte.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let before = &text[..end];
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    let line = before.matches('\n').count() + 1;
    (line, before[line_start..].chars().count() + 1)
}
