//! The text of a model, and whence it came.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bksim::model::diagnostic::Diagnostic;

use crate::drawn::{Drawn, Located};
use crate::error::InputError;

/// The text of a model, for excerpts in messages.
#[derive(Clone, Debug)]
pub struct Text {
    /// The file it is from; the name that stands in messages.
    pub path: PathBuf,
    /// The text.
    pub text: String,
    /// Where the text comes from, if it came out of a drawing.
    pub drawn: Option<Arc<Drawn>>,
}

impl Text {
    /// A text by itself.
    pub fn new(path: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        Self { path: path.into(), text: text.into(), drawn: None }
    }

    /// Faults of this text.
    pub fn rejected(&self, diagnostics: Vec<Diagnostic>) -> InputError {
        InputError::Model { source_text: Box::new(self.clone()), diagnostics }
    }

    /// The files that the model was read from.
    pub fn files(&self) -> Vec<&Path> {
        match &self.drawn {
            Some(drawn) => drawn.files(),
            None => vec![&self.path],
        }
    }

    /// A diagnostic in the file it is about.
    pub fn locate(&self, fault: &Diagnostic) -> Located<'_> {
        match &self.drawn {
            Some(drawn) => drawn.locate(self, fault),
            None => Located { path: &self.path, text: &self.text, fault: fault.clone() },
        }
    }
}

/// Line and column of a byte, counted from one, columns in characters.
pub fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let mut end = byte.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let before = &text[..end];
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    let line = before.matches('\n').count() + 1;
    (line, before[line_start..].chars().count() + 1)
}
