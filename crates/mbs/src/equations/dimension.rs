//! Units of named constants, from the equation they stand in.
//!
//! A number in a model may carry a unit that its formula no longer shows (`"0.5 kg"` is ½), so the
//! unit of a constant is not that of its parameters. It is the unit of the equation over that of
//! the other factors of the term, which are coordinates, rates, multipliers and angles.

use std::collections::HashMap;
use std::fmt;

use bksim_expr::{Expr, Function, Pool, SymbolId};

use crate::coordinate::{Coordinate, CoordinateKind, Owner};
use crate::system::SymbolicSystem;
use bksim_model::{Model, MotionKind, StateId};

/// Exponents of kilogram, metre, second and ampere.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Dimension {
    mass: i64,
    length: i64,
    time: i64,
    current: i64,
}

const fn dimension(mass: i64, length: i64, time: i64) -> Dimension {
    Dimension { mass, length, time, current: 0 }
}

/// A pure number or an angle.
pub(super) const NONE: Dimension = dimension(0, 0, 0);
const LENGTH: Dimension = dimension(0, 1, 0);
const TIME: Dimension = dimension(0, 0, 1);
pub(super) const FORCE: Dimension = dimension(1, 1, -2);
pub(super) const MOMENT: Dimension = dimension(1, 2, -2);

const fn electrical(mass: i64, length: i64, time: i64, current: i64) -> Dimension {
    Dimension { current, ..dimension(mass, length, time) }
}

/// One row for each kind of constant that has a letter or a unit of its own.
#[rustfmt::skip]
const LETTERS: [(Dimension, &str, &str); 18] = [
    (dimension(1, 2, 0),  "J", "kg m^2"),  // moment of inertia
    (dimension(1, 1, 0),  "S", "kg m"),    // first moment of mass
    (dimension(1, 0, 0),  "M", "kg"),      // mass
    (MOMENT,              "W", "N m"),     // moment of weight, torque, torsional stiffness
    (FORCE,               "F", "N"),       // force, weight
    (dimension(1, 0, -2), "K", "N/m"),     // stiffness
    (dimension(1, 0, -1), "D", "N s/m"),   // damping
    (dimension(1, 1, -1), "D", "N s"),     // damping that couples turning and sliding
    (dimension(1, 2, -1), "D", "N m s"),   // torsional damping
    (LENGTH,              "L", "m"),       // length
    (dimension(0, 2, 0),  "A", "m^2"),     // square of a length
    (NONE,                "C", ""),        // pure number
    (electrical(0, 0, 0, 1),   OTHER, "A"),
    (electrical(1, 2, -3, -1), OTHER, "V"),
    (electrical(1, 2, -3, -2), OTHER, "ohm"),
    (electrical(1, 2, -2, -2), OTHER, "H"),
    (electrical(1, 2, -2, -1), OTHER, "N m/A"),  // torque constant, back-EMF
    (electrical(1, 1, -2, -1), OTHER, "N/A"),    // force constant
];

/// Letter of constants whose unit is not known or has no letter.
const OTHER: &str = "P";

impl Dimension {
    fn times(self, other: Self, exponent: i64) -> Self {
        Self {
            mass: self.mass + other.mass * exponent,
            length: self.length + other.length * exponent,
            time: self.time + other.time * exponent,
            current: self.current + other.current * exponent,
        }
    }

    /// Of a quotient.
    pub(super) fn over(self, other: Self) -> Self {
        self.times(other, -1)
    }

    fn row(self) -> Option<&'static (Dimension, &'static str, &'static str)> {
        LETTERS.iter().find(|row| row.0 == self)
    }
}

/// The letter that names a constant of this dimension.
pub(super) fn letter(dimension: Option<Dimension>) -> &'static str {
    dimension.and_then(Dimension::row).map_or(OTHER, |row| row.1)
}

impl fmt::Display for Dimension {
    /// The SI unit: `kg m^2`; nothing for a pure number.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(row) = self.row() {
            return f.write_str(row.2);
        }
        let Self { mass, length, time, current } = *self;
        // As in the model: 1 kg = 1 V A s³/m².
        let bases = match current {
            0 => [(mass, "kg"), (0, "A"), (length, "m"), (time, "s")],
            _ => [
                (mass, "V"),
                (current + mass, "A"),
                (length - 2 * mass, "m"),
                (time + 3 * mass, "s"),
            ],
        };
        let part = |&(n, unit): &(i64, &str)| match n {
            0 => None,
            1 => Some(unit.to_owned()),
            n => Some(format!("{unit}^{n}")),
        };
        f.write_str(&bases.iter().filter_map(part).collect::<Vec<_>>().join(" "))
    }
}

/// The units of what is not constant.
pub(super) struct Units {
    /// `None` of the states without unit.
    of_symbol: HashMap<SymbolId, Option<Dimension>>,
}

impl Units {
    pub(super) fn new(model: &Model, system: &SymbolicSystem) -> Self {
        let mut of_symbol = HashMap::from([(model.time, Some(TIME))]);
        for coordinate in system.coordinates() {
            let rate = of_rate(model, coordinate);
            of_symbol.insert(coordinate.q, rate.map(|rate| rate.times(TIME, 1)));
            of_symbol.insert(coordinate.v, rate);
            of_symbol.insert(coordinate.a, rate.map(|rate| rate.times(TIME, -1)));
        }
        for constraint in &system.constraints {
            let effort = match constraint.effort {
                MotionKind::Translation => FORCE,
                MotionKind::Rotation => MOMENT,
            };
            of_symbol.insert(constraint.lambda, Some(effort));
        }
        Self { of_symbol }
    }

    /// The unit of a product of coordinates, rates, multipliers, sines and cosines.
    pub(super) fn of_product(&self, pool: &Pool, e: Expr) -> Option<Dimension> {
        let mut all = NONE;
        for (base, exponent) in pool.factors(e) {
            let symbol = pool.symbol_id(base).and_then(|symbol| self.of_symbol.get(&symbol));
            let own = match (symbol, pool.called_function(base)) {
                (Some(&own), _) => own?,
                (None, Some((Function::Sin | Function::Cos | Function::Tan, _))) => NONE,
                _ if pool.as_number(base).is_some() => NONE,
                _ => return None,
            };
            all = all.times(own, exponent);
        }
        Some(all)
    }
}

/// The unit of the velocity of a coordinate, which is that of a state; radians count as numbers.
fn of_rate(model: &Model, coordinate: &Coordinate) -> Option<Dimension> {
    if let Owner::State(StateId(state)) = coordinate.owner {
        let [mass, length, time, current] = model.states[state].exponents?;
        return Some(Dimension { mass, length, time, current });
    }
    let value = if coordinate.kind == CoordinateKind::Length { LENGTH } else { NONE };
    Some(value.times(TIME, -1))
}

/// The unit of a Lagrange equation, and of that of a state: the unit of its rate.
pub(super) fn of_equation(model: &Model, coordinate: &Coordinate) -> Option<Dimension> {
    match coordinate.kind {
        CoordinateKind::Angle | CoordinateKind::Quaternion => Some(MOMENT),
        CoordinateKind::Length => Some(FORCE),
        CoordinateKind::Integral => of_rate(model, coordinate).map(|rate| rate.times(TIME, -1)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_follow_the_unit() {
        let inertia = MOMENT.over(dimension(0, 0, -2));
        assert_eq!((letter(Some(inertia)), inertia.to_string()), ("J", "kg m^2".to_owned()));
        assert_eq!(letter(Some(dimension(3, 0, 0))), "P");
        assert_eq!(dimension(1, -1, -2).to_string(), "kg m^-1 s^-2");
        assert_eq!(letter(None), "P");
        let voltage = electrical(1, 2, -3, -1);
        assert_eq!((letter(Some(voltage)), voltage.to_string()), ("P", "V".to_owned()));
        assert_eq!(voltage.over(TIME).to_string(), "V s^-1");
        // The torque constant times the current is a torque.
        let constant = MOMENT.over(electrical(0, 0, 0, 1));
        assert_eq!(constant.to_string(), "N m/A");
        assert_eq!(voltage.times(TIME, 1), constant);
    }
}
