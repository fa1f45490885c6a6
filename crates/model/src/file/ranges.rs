//! `[ranges]`: between which values sliders and searches move a number of the model.

use super::cases::{Change, end, gather, leads, place};
use super::codes;
use super::dimension::Dimension;
use super::reader::Reader;
use super::tree::{Node, Table, Value};
use super::value::{Kind, Lowered, Scope, describe};
use super::words::{cut, suggest};
use crate::diagnostic::Diagnostic;
use crate::message::short;
use crate::range::StatedRange;

impl Reader<'_> {
    /// Reads the ranges; the values that they are about were read before.
    pub(super) fn read_ranges(&mut self, root: &Table) -> Vec<StatedRange> {
        let Some(entry) = root.get("ranges") else { return Vec::new() };
        let Some(table) = self.table(&entry.node, "`ranges`") else { return Vec::new() };
        let mut stated = Vec::new();
        gather(table, &mut Vec::new(), &mut stated);
        stated.iter().filter_map(|stated| self.read_range(root, stated)).collect()
    }

    fn read_range(&mut self, root: &Table, stated: &Change) -> Option<StatedRange> {
        let name = stated.path.join(".");
        let what = format!("the range of `{}`", cut(&name));
        let Some(path) = place(root, &stated.path).filter(|path| leads(root, path)) else {
            self.report(no_value(root, stated, "which the model does not have"));
            return None;
        };
        let value = self.ranged(root, stated, &path)?;

        // Two ends of the kind of the value, in order.
        let form = "a list of two values";
        let ends = self.array(&stated.node, &what, form, "[\"80 mm\", \"120 mm\"]")?;
        let [low, high] = ends else {
            let message = format!("{what} has {} values in place of two", ends.len());
            let help = "write the least and the largest value: `[\"80 mm\", \"120 mm\"]`";
            let fault = Diagnostic::error(codes::BAD_RANGE, message);
            self.report(fault.at(stated.node.span.clone(), "no range").help(help));
            return None;
        };
        let low = self.end(low, &value, &what)?;
        let high = self.end(high, &value, &what)?;
        if low >= high {
            let message = format!("{what} ends before it begins");
            let help = "write the least value first, and a larger one after it";
            let fault = Diagnostic::error(codes::BAD_RANGE, message);
            self.report(fault.at(stated.node.span.clone(), "no range").help(help));
            return None;
        }
        let own = value.value?.look();
        if !(low..=high).contains(&own) {
            let unit = match value.kind {
                Kind::Known(dimension) if dimension != Dimension::NONE => format!(" {dimension}"),
                Kind::Known(_) if value.is_angle => " rad".to_owned(),
                _ => String::new(),
            };
            let [own, low, high] = [own, low, high].map(short);
            let message = format!(
                "`{}` is {own}{unit}, outside of its range from {low} to {high}{unit}",
                cut(&name)
            );
            let fault = Diagnostic::warning(codes::OUTSIDE_RANGE, message);
            let fault = fault.at(value.span, "outside").at(stated.node.span.clone(), "its range");
            self.report(fault.help("widen the range, or give the value another number in it"));
        }
        Some(StatedRange { path: path.join("."), ends: [low, high] })
    }

    /// The number at a path; `None` where it has faults of its own.
    fn ranged(&mut self, root: &Table, stated: &Change, path: &[String]) -> Option<Lowered> {
        if let [section, name] = path
            && section == "parameters"
        {
            let known = self.parameters.iter().find(|known| known.name == *name)?;
            let (result, span) = (known.result.clone(), known.span.clone());
            // A bare number from outside takes the place of a quantity: its kind follows from its uses alone.
            let is_open = result.as_ref().is_some_and(|result| result.kind == Kind::Bare);
            if is_open && known.is_from_outside {
                return None;
            }
            return result.map(|result| Lowered { span, ..result });
        }
        // Its section has reported what is wrong with it.
        let n_faults = self.faults.len();
        let found = end(root, path).and_then(|node| self.lowered(node, "", Scope::Constant));
        self.faults.truncate(n_faults);
        if found.is_none() && !self.faults.iter().any(Diagnostic::is_error) {
            self.report(no_value(root, stated, "which is no number"));
        }
        found
    }

    /// An end of a range in SI; of a value without a unit, a number without one.
    fn end(&mut self, node: &Node, value: &Lowered, what: &str) -> Option<f64> {
        let end = self.lowered(node, what, Scope::Constant)?;
        let end = match (value.kind, end.kind) {
            (Kind::Known(dimension), Kind::Bare) => self.adopt(&end, dimension, value.is_angle),
            (own, found) if own == found => end,
            (own, found) => {
                let noun = |kind: Kind, is_angle: bool| match kind {
                    Kind::Known(dimension) => describe(dimension, is_angle),
                    Kind::Bare => "a number without unit".to_owned(),
                };
                let [own, found] = [noun(own, value.is_angle), noun(found, end.is_angle)];
                let message = format!("{what}: expected {own}, found {found}");
                self.report(
                    Diagnostic::error(codes::WRONG_DIMENSION, message)
                        .at(end.span, "another kind than the value")
                        .at(value.span.clone(), "the value")
                        .help("write both ends and the value in units of one kind"),
                );
                return None;
            }
        };
        end.value.map(super::replay::Constant::look)
    }
}

/// The fault of a range of something that no slider moves.
fn no_value(root: &Table, stated: &Change, why: &str) -> Diagnostic {
    let name = stated.path.join(".");
    let fault = Diagnostic::error(
        codes::NO_RANGED,
        format!("a range is stated of `{}`, {why}", cut(&name)),
    )
    .at(stated.span.clone(), "no such number");
    let parameters: Vec<&str> = match root.get("parameters").map(|entry| &entry.node.value) {
        Some(Value::Table(table)) => table.entries.iter().map(|e| e.key.as_str()).collect(),
        _ => Vec::new(),
    };
    match stated.path.as_slice() {
        [one] => fault.help(suggest(one, &parameters)),
        _ => fault.help(
            "name a parameter, or the path of a number that the file states, such as `A.angle` of `[initial]`",
        ),
    }
}

/// Ranges that a text states, as they are written, by the names that searches and sweeps vary; none of a text with faults.
pub fn stated_ranges(text: &str) -> Vec<(String, [String; 2])> {
    let root = text.parse::<toml::Table>().unwrap_or_default();
    let mut found = Vec::new();
    let mut left: Vec<(String, &toml::Value)> =
        root.get("ranges").map(|value| (String::new(), value)).into_iter().collect();
    while let Some((path, value)) = left.pop() {
        match value {
            toml::Value::Table(table) => {
                let below = table.iter().rev().map(|(key, value)| {
                    (if path.is_empty() { key.clone() } else { format!("{path}.{key}") }, value)
                });
                left.extend(below);
            }
            toml::Value::Array(ends) => {
                let written =
                    |end: &toml::Value| end.as_str().map_or(end.to_string(), str::to_owned);
                let ends: Vec<String> = ends.iter().map(written).collect();
                let own = ["parameters.", "initial."].iter().find_map(|at| path.strip_prefix(at));
                let name = own.unwrap_or(&path).to_owned();
                found.extend(<[String; 2]>::try_from(ends).ok().map(|ends| (name, ends)));
            }
            _ => (),
        }
    }
    found
}
