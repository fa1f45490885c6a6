//! A parameter without a unit in a file with units of its own: the unit that its uses need.
//!
//! ```text
//! [units]                a = 50 in inertia = "1 kg*a^2/12": kg m^2 come out where a is a length,
//! length = "mm"          so the help is a = "50 mm"
//! ```
//!
//! Each dimension that has a name is tried in place of the missing one.

use super::codes;
use super::definition::ParameterState;
use super::dimension::{Dimension, NOUNS};
use super::reader::Reader;
use super::replay::Constant;
use super::units::{Quantity, UNITS};
use super::value::{Kind, Lowered};
use super::written_unit::WrittenUnit;
use crate::diagnostic::Diagnostic;
use crate::message::short;

impl Reader<'_> {
    /// In a file with units of its own, a bare parameter in a product, with something of the dimension `other`,
    /// could mean anything.
    pub(super) fn needs_unit(&mut self, bare: &Lowered, other: Dimension) {
        // The parameter itself, or the one without a unit in a product or a difference.
        let is_bare = |p: &&ParameterState| {
            p.result.as_ref().is_some_and(|result| result.kind == Kind::Bare)
                && self
                    .pool
                    .symbol_id(p.symbol)
                    .is_some_and(|id| self.pool.depends_on(bare.expr, id))
        };
        let itself = self.parameters.iter().find(|p| p.symbol == bare.expr);
        let known = itself.or_else(|| self.parameters.iter().find(is_bare));
        let (message, location, help) = match known {
            Some(p) => {
                let value = p.result.as_ref().and_then(|result| result.value).or(bare.value);
                let value = short(value.map_or(0.0, Constant::look));
                let example = if other.is_electrical() { "ohm" } else { "N/m" };
                (
                    format!("`{}` = {value} needs its unit", p.name),
                    p.span.clone(),
                    format!("write for example `{} = \"{value} {example}\"`", p.name),
                )
            }
            None => (
                "a product of numbers without units".to_owned(),
                bare.span.clone(),
                "give the parameters in it their units".to_owned(),
            ),
        };
        // One unit cures all uses.
        let is_known =
            |fault: &Diagnostic| fault.code == codes::NEEDS_UNIT && fault.message == message;
        if known.is_some() && self.faults.iter().any(is_known) {
            self.is_unit_missing = true;
            return;
        }
        self.report(
            Diagnostic::error(codes::NEEDS_UNIT, message)
                .at(location, "no unit here, and the file has units of its own")
                .at(bare.span.clone(), "multiplied here")
                .help(help),
        );
        self.is_unit_missing = true;
    }

    /// Puts the unit with which a value becomes the quantity that is needed into the fault of the parameter that
    /// lacks it; `read` reads the value again.
    pub(super) fn find_needed_unit(
        &mut self,
        quantity: Quantity,
        mut read: impl FnMut(&mut Self) -> Option<Lowered>,
    ) {
        if !std::mem::take(&mut self.is_unit_missing) {
            return;
        }
        let Some((fault_idx, parameter_idx)) = self.missing_unit() else { return };
        let (n_faults, n_calls) = (self.faults.len(), self.table_calls.len());
        let before = self.parameters[parameter_idx].result.clone();
        let mut fits = |reader: &mut Self, dimension: Dimension| {
            if let Some(result) = &mut reader.parameters[parameter_idx].result {
                result.kind = Kind::Known(dimension);
            }
            let lowered = read(reader);
            let is_good = reader.faults.len() == n_faults && !reader.is_unit_missing;
            reader.faults.truncate(n_faults);
            reader.table_calls.truncate(n_calls);
            reader.is_unit_missing = false;
            is_good && lowered.is_some_and(|of| of.kind == Kind::Known(quantity.dimension()))
        };
        let named = NOUNS.iter().map(|(dimension, ..)| *dimension);
        let found = named.filter(|d| *d != Dimension::NONE).find(|d| fits(self, *d));
        self.parameters[parameter_idx].result = before;
        let Some(dimension) = found else { return };
        let known = &self.parameters[parameter_idx];
        let value = known.result.as_ref().and_then(|of| of.value).map_or(0.0, Constant::look);
        let (name, unit) = (known.name.clone(), self.own_unit(dimension));
        self.faults[fault_idx].help =
            Some(format!("write for example `{name} = \"{} {unit}\"`", short(value)));
    }

    /// The last fault of a missing unit, and the parameter that lacks it.
    fn missing_unit(&self) -> Option<(usize, usize)> {
        let fault_idx = self.faults.iter().rposition(|fault| fault.code == codes::NEEDS_UNIT)?;
        let place = &self.faults[fault_idx].labels.first()?.span;
        let parameter_idx = self.parameters.iter().position(|known| known.span == *place)?;
        Some((fault_idx, parameter_idx))
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
