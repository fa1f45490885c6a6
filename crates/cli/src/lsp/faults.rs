//! The model that a text is, and the faults in it.

use std::ops::Range;

use bksim::analysis::Positions;
use bksim::messages::{level, worded};
use bksim::model::Model;
use bksim::model::cure::{Cure, cures};
use bksim::model::diagnostic::{Diagnostic, Severity};
use bksim::model::file::Limits;
use bksim::{Mechanism, Rejected};
use bksim_load::{InputError, Request, Text, load_text};
use serde_json::{Value, json};

use super::document::Document;
use crate::commands::check::{at_start, lacks_masses_alone, of_positions_alone};

/// Starts of models with more bodies are left to commands: an editor does not wait for them.
const MOST_BODIES: usize = 300;

/// A model with what was said of its text, or that alone.
pub(super) struct Judged {
    pub(super) model: Option<Model>,
    pub(super) source: Option<Text>,
    faults: Vec<Diagnostic>,
    /// True if positions alone can be asked for.
    is_geometry: bool,
    /// Why another file that the model names cannot be read.
    unread: Option<String>,
}

/// A fault of a document as an editor has it, with its cures.
#[derive(Clone, Debug)]
pub(super) struct Shown {
    pub(super) span: Range<usize>,
    pub(super) json: Value,
    pub(super) cures: Vec<Cure>,
}

impl Judged {
    /// The bytes of the text where its errors are.
    pub(super) fn places(&self, document: &Document) -> Vec<usize> {
        let Some(source) = &self.source else { return Vec::new() };
        let located = self.faults.iter().filter(|fault| fault.is_error()).map(|f| source.locate(f));
        let here = located.filter(|located| located.path == document.path);
        here.filter_map(|located| Some(located.fault.labels.first()?.span.start)).collect()
    }

    /// The faults for an editor, those of other files at the top; `pages` is the address of the page of a code.
    pub(super) fn shown(&self, document: &Document, pages: Option<&str>) -> Vec<Shown> {
        let unread = self.unread.iter().map(|message| Shown {
            span: 0..0,
            json: json!({ "range": document.range(&(0..0)), "severity": 1, "source": "bksim", "message": message }),
            cures: Vec::new(),
        });
        let of = |source: &Text| -> Vec<Shown> {
            self.faults.iter().map(|fault| one(source, fault, document, pages)).collect()
        };
        unread.chain(self.source.iter().flat_map(of)).collect()
    }

    /// Everything that can be said of the start, with the warnings of the reading; `None` of a model without faults of
    /// its own that is no longer current, or is too large.
    pub(super) fn started(mut self, is_current: &dyn Fn() -> bool) -> Option<Self> {
        let model = self.model.take().filter(|model| model.bodies.len() <= MOST_BODIES)?;
        if self.is_geometry {
            if let Err(error) = Positions::of(model) {
                self.faults.extend(error.diagnostics());
            }
            return Some(self);
        }
        let read = self.faults.clone();
        let found = Mechanism::derive(model, Vec::new()).and_then(|mechanism| {
            if is_current() { at_start(&mechanism, read) } else { Err(Rejected(Vec::new())) }
        });
        match found {
            Ok((_, warnings)) => self.faults = warnings,
            Err(Rejected(faults)) => self.faults.extend(faults),
        }
        is_current().then_some(self)
    }
}

/// Reads the text of a document, its parts from the folder of its file.
pub(super) fn judge(document: &Document, nesting: usize) -> Judged {
    let load = |is_geometry: bool| {
        let limits = Limits { nesting };
        let request = Request { limits, is_geometry, ..Request::new(&document.path) };
        load_text(Text::new(&document.path, &document.text), &request)
    };
    let nothing =
        Judged { model: None, source: None, faults: Vec::new(), is_geometry: false, unread: None };
    match load(false) {
        Ok(loaded) => Judged {
            model: Some(loaded.model),
            source: Some(loaded.source),
            faults: loaded.warnings,
            ..nothing
        },
        Err(InputError::Model { source_text, diagnostics }) => {
            if lacks_masses_alone(&diagnostics)
                && let Ok(loaded) = load(true)
                && let Some(warning) = of_positions_alone(&loaded.model, &diagnostics)
            {
                let faults = loaded.warnings.into_iter().chain([warning]).collect();
                let (model, source) = (Some(loaded.model), Some(loaded.source));
                return Judged { model, source, faults, is_geometry: true, ..nothing };
            }
            Judged { source: Some(*source_text), faults: diagnostics, ..nothing }
        }
        Err(error) => Judged { unread: Some(error.to_string()), ..nothing },
    }
}

/// The equations of a model that has any.
pub(super) fn derived(document: &Document, nesting: usize) -> Option<Mechanism> {
    Mechanism::derive(judge(document, nesting).model?, Vec::new()).ok()
}

fn one(source: &Text, fault: &Diagnostic, document: &Document, pages: Option<&str>) -> Shown {
    // Cures are found by the English.
    let english = source.locate(fault).fault;
    let (fault, explanation) = worded(fault);
    let located = source.locate(&fault);
    let is_here = located.path == document.path;
    let first = located.fault.labels.first().filter(|_| is_here);
    let span: Range<usize> = first.map_or(0..0, |label| label.span.clone());
    let more = first.map(|label| label.text.as_str()).filter(|text| !text.is_empty());
    let mut message = fault.message.clone();
    if let Some(more) = more {
        message = format!("{message}: {more}");
    }
    let line = |what: &'static str, text: &String| format!("\n{}: {text}", level(what));
    let notes = located.fault.notes.iter().map(|note| line("note", note));
    message.extend(notes.chain(located.fault.help.iter().map(|help| line("help", help))));
    if let Some(words) = explanation {
        let notes = [&words.title, &words.meaning, &words.cure];
        message.extend(notes.map(|note| format!("\n{note}")));
    }
    let mut json = json!({
        "range": document.range(&span),
        "severity": if fault.severity == Severity::Error { 1 } else { 2 },
        "code": fault.code.0,
        "source": "bksim",
        "message": message,
    });
    if let Some(pages) = pages {
        json["codeDescription"] = json!({ "href": pages.replace("{code}", fault.code.0) });
    }
    let cures = if is_here { cures(&document.text, &english) } else { Vec::new() };
    Shown { span, json, cures }
}
