//! The model that a text is, and the faults in it.

use std::ops::Range;

use bksim::Mechanism;
use bksim::model::Model;
use bksim::model::diagnostic::{Diagnostic, Severity};
use bksim::model::file::Limits;
use bksim_load::{InputError, Text, parse, whole};
use serde_json::{Value, json};

use super::document::Document;

/// A model with what was said of its text, or that alone.
pub(super) struct Judged {
    pub(super) model: Option<Model>,
    source: Option<Text>,
    faults: Vec<Diagnostic>,
}

impl Judged {
    /// The bytes of the text where its errors are.
    pub(super) fn places(&self, document: &Document) -> Vec<usize> {
        let Some(source) = &self.source else { return Vec::new() };
        let located = self.faults.iter().filter(|fault| fault.is_error()).map(|f| source.locate(f));
        let here = located.filter(|located| located.path == document.path);
        here.filter_map(|located| Some(located.fault.labels.first()?.span.start)).collect()
    }
}

/// Reads the text of a document, its parts from the folder of its file.
pub(super) fn judge(document: &Document, nesting: usize) -> Judged {
    let name = document.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let text = Text::new(&document.path, &document.text);
    let limits = Limits { nesting };
    let read = whole(text, limits).and_then(|(text, warnings)| {
        let mut loaded = parse(text, &name, &[], limits)?;
        loaded.warnings.splice(0..0, warnings);
        Ok(loaded)
    });
    match read {
        Ok(loaded) => Judged {
            model: Some(loaded.model),
            source: Some(loaded.source),
            faults: loaded.warnings,
        },
        Err(InputError::Model { source_text, diagnostics }) => {
            Judged { model: None, source: Some(*source_text), faults: diagnostics }
        }
        Err(_) => Judged { model: None, source: None, faults: Vec::new() },
    }
}

/// The equations of a model that has any.
pub(super) fn derived(document: &Document, nesting: usize) -> Option<Mechanism> {
    Mechanism::derive(judge(document, nesting).model?, Vec::new()).ok()
}

/// The faults of a document, those of other files at its top.
pub(super) fn of(document: &Document, nesting: usize) -> Value {
    let judged = judge(document, nesting);
    let Some(source) = &judged.source else { return json!([]) };
    let all = judged.faults.iter().map(|fault| {
        let located = source.locate(fault);
        let is_here = located.path == document.path;
        let first = located.fault.labels.first().filter(|_| is_here);
        let span: Range<usize> = first.map_or(0..0, |label| label.span.clone());
        let more = first.map(|label| label.text.as_str()).filter(|text| !text.is_empty());
        let mut message = fault.message.clone();
        if let Some(more) = more {
            message = format!("{message}: {more}");
        }
        let notes = fault.notes.iter().map(|note| format!("\nnote: {note}"));
        message.extend(notes.chain(fault.help.iter().map(|help| format!("\nhelp: {help}"))));
        json!({
            "range": document.range(&span),
            "severity": if fault.severity == Severity::Error { 1 } else { 2 },
            "code": fault.code.0,
            "source": "bksim",
            "message": message,
        })
    });
    all.collect()
}
