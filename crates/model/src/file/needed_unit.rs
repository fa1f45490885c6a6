//! A parameter without a unit in a file with units of its own: the unit that its uses need.
//!
//! ```text
//! [units]                a = 50 in inertia = "1 kg*a^2/12": kg m^2 come out where a is a length,
//! length = "mm"          so the help is a = "50 mm"
//! ```
//!
//! It is a pure number where it is multiplied, such as a coefficient of friction. Where that does not fit, each
//! dimension that has a name is tried in place of the missing one.

use bksim_expr::{Syntax, SyntaxKind};

use super::codes;
use super::definition::ParameterState;
use super::dimension::{Dimension, NOUNS};
use super::reader::Reader;
use super::replay::Constant;
use super::tree::Quoted;
use super::units::{Quantity, UNITS};
use super::value::{Kind, Lowered, Scope};
use super::written_unit::WrittenUnit;
use crate::diagnostic::{Diagnostic, Span};
use crate::message::{listed, short};

impl Reader<'_> {
    /// Lowers a whole expression that is to be `needed`, if it is to be something. Every fault in it is reported; `None`
    /// when there was one, here or in a parameter that it uses.
    pub(super) fn lower_as(
        &mut self,
        syntax: &Syntax,
        quoted: &Quoted<'_>,
        (what, scope): (&str, Scope),
        needed: Option<Quantity>,
    ) -> Option<Lowered> {
        let n_faults = self.faults.len();
        let lowered = self.lower_once(syntax, quoted, what, scope);
        if self.units.is_si() || scope == Scope::Output || fits(lowered.as_ref(), needed) {
            return lowered;
        }
        let named: Vec<(usize, Span)> = syntax
            .nodes
            .iter()
            .filter_map(|node| {
                let SyntaxKind::Name(name) = &node.kind else { return None };
                let is_it = |p: &ParameterState| p.name == *name && is_bare(p);
                let at = self.parameters.iter().position(is_it)?;
                Some((at, quoted.span_of(&node.span)))
            })
            .collect();
        let reported = self.faults.split_off(n_faults);
        let found = named.into_iter().find_map(|(idx, span)| {
            let dimension = self.missing_dimension(idx, needed, |reader| {
                reader.lower_once(syntax, quoted, what, scope)
            })?;
            Some((idx, span, dimension))
        });
        let Some((idx, span, dimension)) = found else {
            self.faults.extend(reported);
            return lowered;
        };
        let value = self.parameters[idx].result.as_ref().and_then(|of| of.value);
        let value = short(value.map_or(0.0, Constant::look));
        let unit = self.own_unit(dimension);
        let name = &self.parameters[idx].name;
        let help = format!("write for example `{name} = \"{value} {unit}\"`");
        self.report_missing_unit(idx, span, help);
        None
    }

    /// The dimension with which a parameter without unit makes a value fit.
    fn missing_dimension(
        &mut self,
        idx: usize,
        needed: Option<Quantity>,
        mut read: impl FnMut(&mut Self) -> Option<Lowered>,
    ) -> Option<Dimension> {
        let (n_faults, n_calls) = (self.faults.len(), self.table_calls.len());
        let before = self.parameters[idx].result.clone();
        let mut tried = |reader: &mut Self, dimension: Dimension| {
            if let Some(result) = &mut reader.parameters[idx].result {
                result.kind = Kind::Known(dimension);
            }
            let lowered = read(reader);
            let is_good = reader.faults.len() == n_faults && fits(lowered.as_ref(), needed);
            reader.faults.truncate(n_faults);
            reader.table_calls.truncate(n_calls);
            is_good
        };
        let named = NOUNS.iter().map(|(dimension, ..)| *dimension);
        let found = named.filter(|d| *d != Dimension::NONE).find(|d| tried(self, *d));
        self.parameters[idx].result = before;
        found
    }

    /// A number without a unit that is multiplied where nothing says what it must be, as in a result.
    pub(super) fn needs_unit(&mut self, bare: &Lowered, other: Dimension) {
        let Some(&idx) = self.without_unit_in(bare).first() else {
            self.report(
                Diagnostic::error(codes::NEEDS_UNIT, "a product of numbers without units")
                    .at(bare.span.clone(), "no unit here, and the file has units of its own")
                    .help("give the parameters in it their units"),
            );
            return;
        };
        let p = &self.parameters[idx];
        let value = p.result.as_ref().and_then(|result| result.value).or(bare.value);
        let value = short(value.map_or(0.0, Constant::look));
        let example = if other.is_electrical() { "ohm" } else { "N/m" };
        let name = &p.name;
        let help = format!(
            "write for example `{name} = \"{value} {example}\"`, or `{name} = \"{value} rad\"` if it is a pure number"
        );
        self.report_missing_unit(idx, bare.span.clone(), help);
    }

    /// One unit cures all uses.
    fn report_missing_unit(&mut self, idx: usize, multiplied: Span, help: String) {
        let p = &self.parameters[idx];
        let value = p.result.as_ref().and_then(|result| result.value);
        let value = short(value.map_or(0.0, Constant::look));
        let message = format!("`{}` = {value} needs its unit", p.name);
        let is_known =
            |fault: &Diagnostic| fault.code == codes::NEEDS_UNIT && fault.message == message;
        if self.faults.iter().any(is_known) {
            return;
        }
        let place = p.span.clone();
        self.report(
            Diagnostic::error(codes::NEEDS_UNIT, message)
                .at(place, "no unit here, and the file has units of its own")
                .at(multiplied, "multiplied here")
                .help(help),
        );
    }

    /// A note on parameters without unit that were multiplied, for values that are something else than needed.
    pub(super) fn pure_numbers(&self) -> Option<String> {
        let names: Vec<&str> =
            self.read_as_pure.iter().map(|&idx| self.parameters[idx].name.as_str()).collect();
        let has = match names.len() {
            0 => return None,
            1 => "has no unit, and is a pure number",
            _ => "have no unit, and are pure numbers",
        };
        Some(format!("{} {has} where multiplied", listed(&names)))
    }

    /// Takes numbers without unit as pure ones.
    pub(super) fn take_as_pure(&mut self, bare: &Lowered) {
        for idx in self.without_unit_in(bare) {
            if !self.read_as_pure.contains(&idx) {
                self.read_as_pure.push(idx);
            }
        }
    }

    /// The parameters without a unit that a value depends on.
    fn without_unit_in(&self, bare: &Lowered) -> Vec<usize> {
        let in_it = |p: &ParameterState| {
            let symbol = self.pool.symbol_id(p.symbol);
            is_bare(p) && symbol.is_some_and(|id| self.pool.depends_on(bare.expr, id))
        };
        (0..self.parameters.len()).filter(|&idx| in_it(&self.parameters[idx])).collect()
    }

    /// The unit of bare numbers of a dimension in this file, as it is written; that of SI where none says it.
    pub(super) fn own_unit(&self, dimension: Dimension) -> String {
        let si = dimension.to_string();
        let base = |name: &str| {
            let of = WrittenUnit::parse(name).map(|unit| unit.dimension)?;
            let scale = self.units.scale_of(of);
            UNITS.iter().find(|unit| unit.dimension == of && unit.scale == scale && !unit.is_angle)
        };
        let mut own = String::new();
        let mut word = String::new();
        let flush = |word: &mut String, own: &mut String| {
            let name = base(word).map_or(word.as_str(), |unit| unit.name);
            own.push_str(name);
            word.clear();
        };
        for c in si.chars() {
            if c.is_alphabetic() {
                word.push(c);
                continue;
            }
            flush(&mut word, &mut own);
            own.push(c);
        }
        flush(&mut word, &mut own);
        let is_it = WrittenUnit::parse(&own)
            .is_some_and(|unit| unit.scale == self.units.scale_of(dimension));
        if is_it { own } else { si }
    }
}

/// True of a parameter without a unit.
fn is_bare(p: &ParameterState) -> bool {
    p.result.as_ref().is_some_and(|result| result.kind == Kind::Bare)
}

/// True of a value that could be read and is what is needed.
fn fits(lowered: Option<&Lowered>, needed: Option<Quantity>) -> bool {
    let Some(lowered) = lowered else { return false };
    match (lowered.kind, needed) {
        (Kind::Known(found), Some(needed)) => found == needed.dimension(),
        _ => true,
    }
}
