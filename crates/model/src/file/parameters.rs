//! `[parameters]`: named numbers that may be defined through each other, in any order.

use bksim_expr::Syntax;

use super::definition::{Definition, ParameterState};
use super::names::Meaning;
use super::promote::identifier;
use super::reader::Reader;
use super::replay::Constant;
use super::tree::{Entry, Quoted, Table, Value};
use super::value::{Kind, Lowered, Scope};
use super::words::cut;
use super::{CASE, codes};
use crate::diagnostic::Diagnostic;
use crate::model::Parameter;

/// State of a parameter in the search for an order.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Visit {
    New,
    Open,
    Done,
}

impl Reader<'_> {
    /// Defines the time.
    pub(super) fn define_time(&mut self) -> bksim_expr::SymbolId {
        self.define("t", Meaning::Time, None);
        let time = self.pool.symbol("t");
        self.pool.symbol_id(time).expect("a symbol was just made")
    }

    /// Gathers the names and definitions of all parameters: those of the file, and values that became some.
    pub(super) fn gather_parameters(
        &mut self,
        root: &Table,
        promoted: &[Entry],
        overrides: &[(String, String)],
    ) {
        if let Some(entry) = root.get("parameters")
            && let Some(table) = self.table(&entry.node, "`parameters`")
        {
            for entry in &table.entries {
                if self.usable_name(&entry.key, &entry.key_span, "parameter") {
                    self.gather_parameter(entry);
                }
            }
        }
        for entry in promoted {
            self.gather_parameter(entry);
        }
        for (name, text) in overrides {
            let is_case = name == CASE && !self.parameters.iter().any(|known| known.name == CASE);
            if !is_case {
                self.replace(name, text);
            }
        }
    }

    fn gather_parameter(&mut self, entry: &Entry) {
        let name = entry.key.as_str();
        let idx = self.parameters.len();
        let identifier = identifier(name);
        if !self.define(&identifier, Meaning::Parameter(idx), Some(entry.key_span.clone())) {
            return;
        }
        let span = entry.node.span.clone();
        let definition = match &entry.node.value {
            Value::Number { value, digits } => {
                Definition::Number { value: *value, digits: digits.clone() }
            }
            Value::Text(_) => match entry.node.text(self.text) {
                Some(Quoted { text, whole, start }) => {
                    Definition::Text { text: text.to_owned(), start, whole }
                }
                None => Definition::Faulty,
            },
            other => {
                let what = format!("parameter `{name}`");
                self.wrong_kind(&entry.node, &what, "a quantity", other, "for example \"25 mm\"");
                Definition::Faulty
            }
        };
        self.parameters.push(ParameterState {
            name: name.to_owned(),
            symbol: self.pool.symbol(&identifier),
            span,
            definition,
            is_from_outside: false,
            result: None,
            expr: None,
        });
    }

    /// Puts a definition from outside for that of the file.
    fn replace(&mut self, name: &str, text: &str) {
        let Some(known) = self.parameters.iter_mut().find(|known| known.name == name) else {
            let names: Vec<String> = self.parameters.iter().map(|p| p.name.clone()).collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let message =
                format!("`{}` is set from outside, but the model has no such parameter", cut(name));
            let fault = Diagnostic::error(codes::UNKNOWN_OVERRIDE, message);
            let help = if name.contains('.') {
                "a path leads to a value of the file: `loads.gravity.acceleration.1`, `rod.mass`, `A.rate`".to_owned()
            } else {
                super::words::suggest(name, &names)
            };
            self.report(fault.help(help));
            return;
        };
        let whole = known.span.clone();
        known.definition = Definition::Text { text: text.to_owned(), start: None, whole };
        known.is_from_outside = true;
    }

    /// Reads all parameters, each after those it uses.
    pub(super) fn read_parameters(&mut self) {
        let trees: Vec<Option<Syntax>> =
            (0..self.parameters.len()).map(|idx| self.parse_parameter(idx)).collect();
        let used: Vec<Vec<usize>> = trees
            .iter()
            .map(|tree| {
                let names = tree.iter().flat_map(Syntax::names);
                let meanings = names.filter_map(|(name, _)| match self.names.plain(name) {
                    Some(Meaning::Parameter(idx)) => Some(idx),
                    _ => None,
                });
                meanings.collect()
            })
            .collect();
        let order = self.order(&used);
        for &idx in &order {
            self.evaluate_parameter(idx, trees[idx].as_ref());
        }
        self.parameter_order = order;
    }

    fn parse_parameter(&mut self, idx: usize) -> Option<Syntax> {
        let Definition::Text { text, start, whole } = &self.parameters[idx].definition else {
            return None;
        };
        let (text, start, whole) = (text.clone(), *start, whole.clone());
        let quoted = Quoted { text: &text, whole, start };
        let what = format!("parameter `{}`", self.parameters[idx].name);
        let before = self.faults.len();
        let tree = self.parse(&quoted, &what, "25 mm");
        self.note_text(before, &quoted);
        tree
    }

    /// Shows a text in the faults since `before` when its own positions are not in the file: it came
    /// from outside, or holds escapes.
    fn note_text(&mut self, before: usize, quoted: &Quoted<'_>) {
        if quoted.start.is_none() {
            for fault in &mut self.faults[before..] {
                fault.notes.push(format!("its value reads `{}`", cut(quoted.text)));
            }
        }
    }

    /// File order, but each parameter after those it uses; reports and leaves out cycles.
    ///
    /// A depth-first search on an explicit stack: a chain of definitions may be long.
    fn order(&mut self, used: &[Vec<usize>]) -> Vec<usize> {
        let mut visits = vec![Visit::New; used.len()];
        let mut order = Vec::new();
        for start in 0..used.len() {
            let mut path: Vec<(usize, usize)> = Vec::new();
            if visits[start] == Visit::New {
                visits[start] = Visit::Open;
                path.push((start, 0));
            }
            while let Some((idx, next)) = path.last_mut() {
                let Some(&child) = used[*idx].get(*next) else {
                    visits[*idx] = Visit::Done;
                    order.push(*idx);
                    path.pop();
                    continue;
                };
                *next += 1;
                match visits[child] {
                    Visit::New => {
                        visits[child] = Visit::Open;
                        path.push((child, 0));
                    }
                    Visit::Open => {
                        let from = path.iter().position(|(idx, _)| *idx == child).unwrap_or(0);
                        let cycle: Vec<usize> = path[from..].iter().map(|(idx, _)| *idx).collect();
                        self.report_cycle(&cycle);
                    }
                    Visit::Done => (),
                }
            }
        }
        order
    }

    fn report_cycle(&mut self, cycle: &[usize]) {
        let is_known =
            cycle.iter().all(|&idx| matches!(self.parameters[idx].definition, Definition::Faulty));
        if is_known {
            return;
        }
        // The cycle starts with the parameter that stands first in the file.
        let first = cycle.iter().position(|idx| Some(idx) == cycle.iter().min()).unwrap_or(0);
        let turned: Vec<usize> = cycle[first..].iter().chain(&cycle[..first]).copied().collect();
        let names: Vec<&str> =
            turned.iter().map(|&idx| self.parameters[idx].name.as_str()).collect();
        let shown = if names.len() > 8 {
            format!("{} → … → {}", names[..7].join(" → "), names[0])
        } else {
            format!("{} → {}", names.join(" → "), names[0])
        };
        let message = match names.as_slice() {
            [name] => format!("parameter `{name}` is defined by itself"),
            _ => format!("parameters define each other in a cycle: {shown}"),
        };
        let mut fault = Diagnostic::error(codes::CYCLE, message);
        for (at, &idx) in turned.iter().enumerate().take(8) {
            let next = names[(at + 1) % names.len()];
            fault = fault.at(self.parameters[idx].span.clone(), format!("needs `{next}`"));
        }
        let help = format!("give one of them a value of its own, for example `{} = 1`", names[0]);
        for &idx in cycle {
            self.parameters[idx].definition = Definition::Faulty;
        }
        self.report(fault.help(help));
    }

    fn evaluate_parameter(&mut self, idx: usize, tree: Option<&Syntax>) {
        let known = &mut self.parameters[idx];
        let (symbol, span) = (known.symbol, known.span.clone());
        let what = format!("parameter `{}`", known.name);
        let before = self.faults.len();
        let lowered = match (std::mem::replace(&mut known.definition, Definition::Faulty), tree) {
            (Definition::Number { value, digits }, _) => {
                self.literal(value, &digits, &what, "25 mm", &span)
            }
            (Definition::Text { text, start, whole }, Some(tree)) => {
                let quoted = Quoted { text: &text, whole, start };
                let lowered = self.lower(tree, &quoted, &what, Scope::Constant);
                self.note_text(before, &quoted);
                lowered
            }
            _ => None,
        };
        let Some(lowered) = lowered else { return };
        let known = &mut self.parameters[idx];
        let constants = &mut self.constants;
        let value = lowered.value.map(|value| constants.parameter(&known.name, value));
        known.expr = Some(lowered.expr);
        known.result =
            Some(Lowered { expr: symbol, value, is_literal: false, unit_span: None, ..lowered });
    }

    /// The parameters of the model, each after those it uses.
    pub(super) fn take_parameters(&mut self) -> Vec<Parameter> {
        let order = std::mem::take(&mut self.parameter_order);
        order.into_iter().filter_map(|idx| self.parameter(idx)).collect()
    }

    /// Their values, in the same order.
    pub(super) fn parameter_values(&self) -> Vec<Constant> {
        let states = self.parameter_order.iter().map(|&idx| &self.parameters[idx]);
        states.filter_map(|known| known.result.as_ref()?.value).collect()
    }

    fn parameter(&self, idx: usize) -> Option<Parameter> {
        let known = &self.parameters[idx];
        let result = known.result.as_ref()?;
        Some(Parameter {
            name: known.name.clone(),
            symbol: self.pool.symbol_id(known.symbol)?,
            definition: known.expr?,
            value: result.value?.look(),
            unit: match result.kind {
                Kind::Known(dimension) => {
                    let unit = dimension.to_string();
                    if unit.is_empty() && result.is_angle { "rad".to_owned() } else { unit }
                }
                Kind::Bare => String::new(),
            },
            span: known.span.clone(),
        })
    }
}
