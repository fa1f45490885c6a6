//! The faults that the stages find, in the order in which they find them.

use bksim_model::diagnostic::Diagnostic;

use crate::attachment::Attachment;
use crate::codes;
use crate::drawing::Location;
use crate::excerpt::Excerpts;

/// A list of faults, each once and with the entities it is about.
#[derive(Debug)]
pub(super) struct Faults<'a> {
    excerpts: &'a Excerpts<'a>,
    list: Vec<Diagnostic>,
}

impl<'a> Faults<'a> {
    /// An empty list; excerpts are of the drawing's text.
    pub(super) fn new(excerpts: &'a Excerpts<'a>) -> Self {
        Self { excerpts, list: Vec::new() }
    }

    /// True if one of them is an error.
    pub(super) fn has_error(&self) -> bool {
        self.list.iter().any(Diagnostic::is_error)
    }

    /// All faults.
    pub(super) fn into_list(self) -> Vec<Diagnostic> {
        self.list
    }

    /// Adds a fault of an entity.
    pub(super) fn add(&mut self, fault: Diagnostic, location: &Location) {
        self.add_labelled(fault, location, "");
    }

    /// Adds a fault of an entity with some words at its excerpt.
    pub(super) fn add_labelled(&mut self, fault: Diagnostic, location: &Location, label: &str) {
        let fault = self.excerpts.at(fault, location, label);
        if !self.list.contains(&fault) {
            self.list.push(fault);
        }
    }

    /// Adds a fault of several entities.
    pub(super) fn add_at_all<'l>(
        &mut self,
        fault: Diagnostic,
        locations: impl IntoIterator<Item = &'l Location>,
    ) {
        let at = |fault, location| self.excerpts.at(fault, location, "");
        let fault = locations.into_iter().fold(fault, at);
        self.list.push(fault);
    }

    /// A list for what is not to be reported.
    pub(super) fn unheard(&self) -> Self {
        Self::new(self.excerpts)
    }

    /// Adds the fault of two entities that contradict each other.
    pub(super) fn add_pair(&mut self, fault: Diagnostic, [here, there]: [&Location; 2]) {
        let fault = self.excerpts.at(fault, here, "here");
        self.add_labelled(fault, there, "and here");
    }

    /// Adds the fault that something stands in two locations.
    pub(super) fn add_duplicate(
        &mut self,
        message: &str,
        help: &str,
        [here, there]: [&Location; 2],
    ) {
        let fault = Diagnostic::error(codes::DUPLICATE_NAME, message).help(help);
        self.add_pair(fault, [here, there]);
    }

    /// Adds the fault that something has no name.
    pub(super) fn add_nameless(&mut self, what: &str, attachment: &Attachment) {
        let fault = Diagnostic::error(codes::NO_NAME, format!("{what} has no name"))
            .help("give it one: the attribute NAME, or `name=…` in its record");
        self.add(fault, &attachment.location);
    }
}
