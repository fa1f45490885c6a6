//! A text read as far as that goes: a model with masses, or positions alone, and all faults.

use bksim_analysis::{AnalysisError, with_held_assembly};
use bksim_model::Model;
use bksim_model::diagnostic::Diagnostic;
use bksim_model::file::{Expansion, Limits, Source, expand, read};

/// A text that was read.
#[derive(Debug)]
pub(crate) struct Readings {
    /// The text with parts of the library in it.
    pub(crate) whole: String,
    /// The model.
    pub(crate) model: Option<Model>,
    /// Without masses, where they are missing or at fault; `None` where the model is whole.
    pub(crate) geometry: Option<Model>,
    /// Faults, their places in the text that was read.
    pub(crate) faults: Vec<Diagnostic>,
    /// How parts were put into the text, if it has some.
    pub(crate) expansion: Option<Expansion>,
}

/// Reads a text. What it names in other files is not there.
pub(crate) fn readings(text: &str, name: &str) -> Readings {
    let mut closed = |_: &str| Err("is another file, which a text by itself has not".to_owned());
    let expansion = expand(name, text, Limits::default(), &mut closed);
    let whole = expansion.as_ref().map_or(text, |e| e.text.as_str()).to_owned();
    let mut faults = Vec::new();
    if let Some(expansion) = &expansion {
        let of_parts = expansion.faults.iter().cloned();
        faults.extend(of_parts.map(|fault| placed(fault, |span| Some(expansion.source(span)))));
    }
    let has_parts_at_fault = faults.iter().any(Diagnostic::is_error);
    if has_parts_at_fault {
        return Readings { whole, model: None, geometry: None, faults, expansion };
    }

    let reading = read(&Source::new(&whole, name));
    let own = |fault| own_place_of(fault, expansion.as_ref());
    faults.extend(reading.diagnostics.into_iter().map(own));
    let model = reading.model.and_then(|model| held(model, &mut faults, expansion.as_ref()));
    let geometry = if model.is_none() {
        let source = Source { is_geometry: true, ..Source::new(&whole, name) };
        read(&source).model.and_then(|model| with_held_assembly(model).ok())
    } else {
        None
    };
    Readings { whole, model, geometry, faults, expansion }
}

/// The model with the assembly that it chooses.
fn held(
    model: Model,
    faults: &mut Vec<Diagnostic>,
    expansion: Option<&Expansion>,
) -> Option<Model> {
    match with_held_assembly(model) {
        Ok(model) => Some(model),
        Err(error) => {
            let of_start = rejected(&error);
            faults.extend(of_start.into_iter().map(|fault| own_place_of(fault, expansion)));
            None
        }
    }
}

/// The faults of an answer.
pub(crate) fn rejected(error: &AnalysisError) -> Vec<Diagnostic> {
    error.diagnostics()
}

/// A fault of the whole text with its places in the text that was read.
pub(crate) fn own_place_of(fault: Diagnostic, expansion: Option<&Expansion>) -> Diagnostic {
    match expansion {
        Some(expansion) => placed(fault, |span| expansion.origin(span)),
        None => fault,
    }
}

fn placed(
    mut fault: Diagnostic,
    of: impl Fn(&std::ops::Range<usize>) -> Option<(usize, std::ops::Range<usize>)>,
) -> Diagnostic {
    fault.labels.retain_mut(|label| match of(&label.span) {
        Some((0, span)) => {
            label.span = span;
            true
        }
        _ => false,
    });
    fault
}
