//! `[io]`: inputs and outputs.

use super::codes;
use super::gather::coordinate_names;
use super::reader::{Fields, Reader};
use super::tree::{Node, Table, Value};
use crate::diagnostic::{Diagnostic, Span};
use crate::io::Io;
use crate::measure::Measure;
use crate::model::Model;

pub(super) const IO_KEYS: &[&str] = &["input", "output"];

/// Names with their positions, which are looked up when the model is there.
#[derive(Default)]
pub(super) struct WrittenIo {
    inputs: Vec<(String, Span)>,
    outputs: Vec<(String, Span)>,
}

impl Reader<'_> {
    /// Reads the names; none where nothing is stated.
    pub(super) fn read_io(&mut self, root: &Table) -> WrittenIo {
        let Some(entry) = root.get("io") else { return WrittenIo::default() };
        let Some(table) = self.table(&entry.node, "`io`") else { return WrittenIo::default() };
        let fields =
            Fields::open(self, table, "`[io]`".to_owned(), entry.key_span.clone(), IO_KEYS);
        let mut names = |key: &str| match fields.get(key) {
            Some(node) => self.read_channel_names(node, &fields.what(key)),
            None => Vec::new(),
        };
        WrittenIo { inputs: names("input"), outputs: names("output") }
    }

    fn read_channel_names(&mut self, node: &Node, what: &str) -> Vec<(String, Span)> {
        let names = coordinate_names(node, self.text);
        let written = if let Value::Array(values) = &node.value { values.len() } else { 1 };
        if names.len() != written {
            let help = "for example [\"u\"] or [\"crank.angle\", \"crank.rate\"]";
            self.wrong_kind(node, what, "an array of names", &node.value, help);
            return Vec::new();
        }
        names
    }

    /// The names, all of which the model has; each other one is reported.
    pub(super) fn known_io(&mut self, model: &Model, written: WrittenIo) -> Io {
        let is_input = |name: &str| {
            model.parameters.iter().any(|parameter| parameter.name == name)
                || model.joints.iter().any(|joint| joint.name == name)
                || Measure::named(model, name).is_some_and(Measure::is_position)
        };
        let is_output = |name: &str| model.has_quantity(name);
        let unknown = |name: &str, span: &Span, what: &str, help: &str| {
            let is_fitting = |measure: Option<Measure>| {
                what == "output" || measure.is_some_and(Measure::is_position)
            };
            let near = model.did_you_mean(name, is_fitting);
            Diagnostic::error(codes::UNKNOWN_NAME, format!("`{name}` is no {what}"))
                .at(span.clone(), "the model has nothing of this name")
                .help(near.unwrap_or_else(|| help.to_owned()))
        };
        for (name, span) in written.inputs.iter().filter(|(name, _)| !is_input(name)) {
            let help = "write a parameter that loads depend on, a joint, or a position such as `crank.angle`";
            self.report(unknown(name, span, "input", help));
        }
        for (name, span) in written.outputs.iter().filter(|(name, _)| !is_output(name)) {
            let help = "write a measure such as `crank.angle`, `crank.rate` or `rod.P.x`, a state, a signal, or a reaction such as `reactions.A.fx`";
            self.report(unknown(name, span, "output", help));
        }
        let names = |all: Vec<(String, Span)>| all.into_iter().map(|(name, _)| name).collect();
        Io { inputs: names(written.inputs), outputs: names(written.outputs) }
    }
}
