//! [`Stated`]: the values of a start that were read.

use std::collections::HashMap;

use super::codes;
use super::reader::Reader;
use crate::diagnostic::Diagnostic;
use crate::measure::{Initial, Measure, Orientation};

/// The values so far, and the orientations among them as turns.
#[derive(Default)]
pub(super) struct Stated {
    pub(super) values: Vec<Initial>,
    pub(super) orientations: Vec<Orientation>,
    /// Which of them states each measure.
    of_measure: HashMap<Measure, usize>,
}

impl Reader<'_> {
    /// Adds a value unless the same thing was stated before under another name.
    pub(super) fn push_initial(&mut self, value: Initial, initial: &mut Stated) {
        let known = *initial.of_measure.entry(value.measure).or_insert(initial.values.len());
        let Some(first) = initial.values.get(known) else {
            initial.values.push(value);
            return;
        };
        let message = format!("the start of `{}` is given twice", value.name);
        self.report(
            Diagnostic::error(codes::DUPLICATE, message)
                .at(value.span, "again here")
                .at(first.span.clone(), format!("first given here, as `{}`", first.name))
                .help("keep one of the two"),
        );
    }
}
