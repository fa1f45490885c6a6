//! [`Dimension`]: what kind of quantity a number is, and the SI unit that says so.

use std::fmt;

/// Exponents of metre, kilogram, second and ampere in twelfths, so that square and cube roots stay exact.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Dimension {
    length: i32,
    mass: i32,
    time: i32,
    current: i32,
}

/// One whole exponent in the steps of [`Dimension`].
const STEPS: i32 = 12;

impl Dimension {
    /// A pure number or an angle.
    pub(super) const NONE: Self = Self::new(0, 0, 0);

    /// A mechanical one, from whole exponents.
    pub(super) const fn new(length: i32, mass: i32, time: i32) -> Self {
        Self { length: length * STEPS, mass: mass * STEPS, time: time * STEPS, current: 0 }
    }

    /// This mechanical one times a whole power of the ampere.
    const fn amperes(self, exponent: i32) -> Self {
        Self { current: exponent * STEPS, ..self }
    }

    /// True where the ampere occurs in it.
    pub(super) fn is_electrical(self) -> bool {
        self.current != 0
    }

    /// Exponents of kilogram, metre, second and ampere; `None` where they are not whole.
    pub(super) fn whole(self) -> Option<[i64; 4]> {
        let all = [self.mass, self.length, self.time, self.current];
        let are_whole = all.iter().all(|steps| steps % STEPS == 0);
        are_whole.then(|| all.map(|steps| i64::from(steps / STEPS)))
    }

    /// Exponents of metre, kilogram and second, without what they have beyond whole ones.
    pub(super) fn mechanical(self) -> [i32; 3] {
        [self.length, self.mass, self.time].map(|steps| steps / STEPS)
    }

    /// Of a product.
    pub(super) fn times(self, other: Self) -> Self {
        self.combine(other, i32::saturating_add)
    }

    /// Of a quotient.
    pub(super) fn over(self, other: Self) -> Self {
        self.combine(other, i32::saturating_sub)
    }

    /// Of a power; `None` when the exponents would not be twelfths.
    pub(super) fn power(self, exponent: f64) -> Option<Self> {
        let scale = |steps: i32| {
            let exact = f64::from(steps) * exponent;
            let near = exact.round();
            let fits = (exact - near).abs() < 1e-9 && near.abs() < 1e6;
            #[expect(clippy::cast_possible_truncation, reason = "bounded and whole")]
            fits.then_some(near as i32)
        };
        Some(Self {
            length: scale(self.length)?,
            mass: scale(self.mass)?,
            time: scale(self.time)?,
            current: scale(self.current)?,
        })
    }

    fn combine(self, other: Self, op: fn(i32, i32) -> i32) -> Self {
        Self {
            length: op(self.length, other.length),
            mass: op(self.mass, other.mass),
            time: op(self.time, other.time),
            current: op(self.current, other.current),
        }
    }

    /// The noun for such a quantity, when there is one: `mass`.
    pub(super) fn noun(self) -> Option<&'static str> {
        NOUNS.iter().find(|(dimension, ..)| *dimension == self).map(|&(_, noun, _)| noun)
    }
}

// Exponents of metre, kilogram, second and ampere.
pub(super) const CURRENT: [i32; 4] = [0, 0, 0, 1];
pub(super) const CHARGE: [i32; 4] = [0, 0, 1, 1];
pub(super) const VOLTAGE: [i32; 4] = [2, 1, -3, -1];
pub(super) const RESISTANCE: [i32; 4] = [2, 1, -3, -2];
pub(super) const CONDUCTANCE: [i32; 4] = [-2, -1, 3, 2];
pub(super) const INDUCTANCE: [i32; 4] = [2, 1, -2, -2];
pub(super) const CAPACITANCE: [i32; 4] = [-2, -1, 4, 2];
pub(super) const FLUX: [i32; 4] = [2, 1, -2, -1];
pub(super) const FLUX_DENSITY: [i32; 4] = [0, 1, -2, -1];

/// Names of dimensions and their usual SI unit.
pub(super) const NOUNS: &[(Dimension, &str, &str)] = &[
    (Dimension::NONE, "a pure number", ""),
    (Dimension::new(1, 0, 0), "length", "m"),
    (Dimension::new(0, 1, 0), "mass", "kg"),
    (Dimension::new(0, 0, 1), "time", "s"),
    (Dimension::new(2, 0, 0), "area", "m^2"),
    (Dimension::new(3, 0, 0), "volume", "m^3"),
    (Dimension::new(1, 0, -1), "velocity", "m/s"),
    (Dimension::new(1, 0, -2), "acceleration", "m/s^2"),
    (Dimension::new(0, 0, -1), "rate", "1/s"),
    (Dimension::new(0, 0, -2), "angular acceleration", "1/s^2"),
    (Dimension::new(1, 1, -2), "force", "N"),
    (Dimension::new(2, 1, -2), "torque or energy", "N m"),
    (Dimension::new(0, 1, -2), "stiffness", "N/m"),
    (Dimension::new(0, 1, -1), "damping", "N s/m"),
    (Dimension::new(2, 1, -1), "torsional damping", "N m s"),
    (Dimension::new(2, 1, 0), "moment of inertia", "kg m^2"),
    (Dimension::new(2, 1, -3), "power", "W"),
    (Dimension::new(-1, 1, -2), "pressure", "Pa"),
    (Dimension::new(-3, 1, 0), "density", "kg/m^3"),
    (electrical(CURRENT), "electric current", "A"),
    (electrical(CHARGE), "electric charge", "C"),
    (electrical(VOLTAGE), "voltage", "V"),
    (electrical(RESISTANCE), "resistance", "ohm"),
    (electrical(CONDUCTANCE), "conductance", "S"),
    (electrical(INDUCTANCE), "inductance", "H"),
    (electrical(CAPACITANCE), "capacitance", "F"),
    // Volt seconds: of a motor also those per radian of its back-EMF.
    (electrical(FLUX), "torque constant or magnetic flux", "N m/A"),
    (electrical([1, 1, -2, -1]), "force constant", "N/A"),
    (electrical(FLUX_DENSITY), "magnetic flux density", "T"),
];

/// From whole exponents, that of the ampere the last.
pub(super) const fn electrical([l, m, t, i]: [i32; 4]) -> Dimension {
    Dimension::new(l, m, t).amperes(i)
}

impl fmt::Display for Dimension {
    /// The SI unit: `kg m^2`, `V/s`; nothing for a pure number.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((.., unit)) = NOUNS.iter().find(|(dimension, ..)| dimension == self) {
            return f.write_str(unit);
        }
        let Self { length, mass, time, current } = *self;
        // 1 kg = 1 V A s³/m²: with the volt for the kilogram, electrical units stay short.
        let bases = if self.is_electrical() {
            let length = length.saturating_sub(mass.saturating_mul(2));
            let time = time.saturating_add(mass.saturating_mul(3));
            let current = current.saturating_add(mass);
            [(mass, "V"), (current, "A"), (length, "m"), (time, "s")]
        } else {
            [(mass, "kg"), (length, "m"), (time, "s"), (0, "A")]
        };
        let part = |steps: i32, unit: &str| {
            let exponent = f64::from(steps) / f64::from(STEPS);
            if steps == STEPS { unit.to_owned() } else { format!("{unit}^{exponent}") }
        };
        let over: Vec<String> =
            bases.iter().filter(|(n, _)| *n > 0).map(|&(n, unit)| part(n, unit)).collect();
        let under: Vec<String> =
            bases.iter().filter(|(n, _)| *n < 0).map(|&(n, unit)| part(-n, unit)).collect();
        f.write_str(if over.is_empty() { "1" } else { "" })?;
        f.write_str(&over.join(" "))?;
        match under.as_slice() {
            [] => Ok(()),
            [one] => write!(f, "/{one}"),
            many => write!(f, "/({})", many.join(" ")),
        }
    }
}
