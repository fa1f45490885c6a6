//! Dimensions, units and the quantities a model is made of.
//!
//! Angles are dimensionless; that a number is an angle is remembered only where it is a matter of
//! wording or of what a bare number means.

use std::fmt;

/// Exponents of metre, kilogram and second in twelfths, so that square and cube roots stay exact.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Dimension {
    length: i32,
    mass: i32,
    time: i32,
}

/// One whole exponent in the steps of [`Dimension`].
const STEPS: i32 = 12;

impl Dimension {
    /// A pure number or an angle.
    pub(super) const NONE: Self = Self::new(0, 0, 0);

    /// From whole exponents.
    pub(super) const fn new(length: i32, mass: i32, time: i32) -> Self {
        Self { length: length * STEPS, mass: mass * STEPS, time: time * STEPS }
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
        Some(Self { length: scale(self.length)?, mass: scale(self.mass)?, time: scale(self.time)? })
    }

    fn combine(self, other: Self, op: fn(i32, i32) -> i32) -> Self {
        Self {
            length: op(self.length, other.length),
            mass: op(self.mass, other.mass),
            time: op(self.time, other.time),
        }
    }

    /// The noun for such a quantity, when there is one: `mass`.
    pub(super) fn noun(self) -> Option<&'static str> {
        NOUNS.iter().find(|(dimension, ..)| *dimension == self).map(|&(_, noun, _)| noun)
    }
}

/// Names of dimensions and their usual SI unit.
const NOUNS: &[(Dimension, &str, &str)] = &[
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
];

impl fmt::Display for Dimension {
    /// The SI unit: `kg m^2`; nothing for a pure number.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((.., unit)) = NOUNS.iter().find(|(dimension, ..)| dimension == self) {
            return f.write_str(unit);
        }
        let bases = [(self.mass, "kg"), (self.length, "m"), (self.time, "s")];
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

/// A conversion factor `up / down · π^pi`, so that 25 mm is exactly 25/1000 m and 30 deg is π/6.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Scale {
    /// A whole number below 2⁵³, as long as units are combined sensibly.
    pub(super) up: f64,
    /// As `up`.
    pub(super) down: f64,
    pub(super) pi: i32,
}

impl Scale {
    /// No conversion.
    pub(super) const ONE: Self = Self { up: 1.0, down: 1.0, pi: 0 };

    /// The value in SI.
    pub(super) fn apply(self, value: f64) -> f64 {
        value * self.up / self.down * std::f64::consts::PI.powi(self.pi)
    }

    /// Of a product of units.
    pub(super) fn times(self, other: Self) -> Self {
        Self { up: self.up * other.up, down: self.down * other.down, pi: self.pi + other.pi }
    }

    /// Of a power of a unit.
    pub(super) fn powi(self, exponent: i32) -> Self {
        let n = exponent.abs();
        let (up, down) = (self.up.powi(n), self.down.powi(n));
        let (up, down) = if exponent < 0 { (down, up) } else { (up, down) };
        Self { up, down, pi: self.pi * exponent }
    }

    /// Whether it changes nothing.
    pub(super) fn is_one(self) -> bool {
        self.up == self.down && self.pi == 0
    }
}

/// A unit of measurement.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unit {
    pub(super) name: &'static str,
    pub(super) scale: Scale,
    pub(super) dimension: Dimension,
    /// Whether it measures angles.
    pub(super) is_angle: bool,
}

const fn unit(name: &'static str, up: f64, down: f64, [l, m, t]: [i32; 3]) -> Unit {
    let scale = Scale { up, down, pi: 0 };
    Unit { name, scale, dimension: Dimension::new(l, m, t), is_angle: false }
}

const fn angle(name: &'static str, up: f64, down: f64, pi: i32) -> Unit {
    Unit { name, scale: Scale { up, down, pi }, dimension: Dimension::NONE, is_angle: true }
}

const LENGTH: [i32; 3] = [1, 0, 0];
const MASS: [i32; 3] = [0, 1, 0];
const TIME: [i32; 3] = [0, 0, 1];
const RATE: [i32; 3] = [0, 0, -1];
const FORCE: [i32; 3] = [1, 1, -2];
const ENERGY: [i32; 3] = [2, 1, -2];
const POWER: [i32; 3] = [2, 1, -3];
const PRESSURE: [i32; 3] = [-1, 1, -2];

/// Every unit, with its exact factor to SI. Sources: the SI brochure (BIPM 2019); the
/// international yard and pound (1959), with standard gravity 9.80665 m/s² for forces.
pub(super) const UNITS: &[Unit] = &[
    unit("m", 1.0, 1.0, LENGTH),
    unit("km", 1000.0, 1.0, LENGTH),
    unit("dm", 1.0, 10.0, LENGTH),
    unit("cm", 1.0, 100.0, LENGTH),
    unit("mm", 1.0, 1000.0, LENGTH),
    unit("um", 1.0, 1e6, LENGTH),
    unit("µm", 1.0, 1e6, LENGTH),
    unit("in", 254.0, 1e4, LENGTH),
    unit("ft", 3048.0, 1e4, LENGTH),
    unit("kg", 1.0, 1.0, MASS),
    unit("g", 1.0, 1000.0, MASS),
    unit("mg", 1.0, 1e6, MASS),
    unit("t", 1000.0, 1.0, MASS),
    unit("lb", 45_359_237.0, 1e8, MASS),
    unit("s", 1.0, 1.0, TIME),
    unit("ms", 1.0, 1000.0, TIME),
    unit("us", 1.0, 1e6, TIME),
    unit("min", 60.0, 1.0, TIME),
    unit("h", 3600.0, 1.0, TIME),
    angle("rad", 1.0, 1.0, 0),
    angle("mrad", 1.0, 1000.0, 0),
    angle("deg", 1.0, 180.0, 1),
    angle("°", 1.0, 180.0, 1),
    angle("rev", 2.0, 1.0, 1),
    Unit {
        name: "rpm",
        scale: Scale { up: 1.0, down: 30.0, pi: 1 },
        dimension: Dimension::new(0, 0, -1),
        is_angle: true,
    },
    unit("Hz", 1.0, 1.0, RATE),
    unit("kHz", 1000.0, 1.0, RATE),
    unit("N", 1.0, 1.0, FORCE),
    unit("mN", 1.0, 1000.0, FORCE),
    unit("kN", 1000.0, 1.0, FORCE),
    unit("MN", 1e6, 1.0, FORCE),
    unit("kgf", 980_665.0, 1e5, FORCE),
    unit("lbf", 44_482_216_152_605.0, 1e13, FORCE),
    unit("J", 1.0, 1.0, ENERGY),
    unit("mJ", 1.0, 1000.0, ENERGY),
    unit("kJ", 1000.0, 1.0, ENERGY),
    unit("Nm", 1.0, 1.0, ENERGY),
    unit("W", 1.0, 1.0, POWER),
    unit("kW", 1000.0, 1.0, POWER),
    unit("Pa", 1.0, 1.0, PRESSURE),
    unit("kPa", 1000.0, 1.0, PRESSURE),
    unit("MPa", 1e6, 1.0, PRESSURE),
    unit("GPa", 1e9, 1.0, PRESSURE),
    unit("bar", 1e5, 1.0, PRESSURE),
];

/// The unit of this name; case counts.
pub(super) fn find_unit(name: &str) -> Option<&'static Unit> {
    UNITS.iter().find(|unit| unit.name == name)
}

/// The quantity that a value of the model must be, and the reading of a bare number for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quantity {
    /// In messages: `length`.
    pub(super) noun: &'static str,
    /// Exponents of the file's units of length, mass, time, angle and force.
    exponents: [i32; 5],
    /// An example as an author would write it.
    pub(super) example: &'static str,
}

const fn quantity(noun: &'static str, exponents: [i32; 5], example: &'static str) -> Quantity {
    Quantity { noun, exponents, example }
}

impl Quantity {
    pub(super) const NUMBER: Self = quantity("a pure number", [0, 0, 0, 0, 0], "0.5");
    pub(super) const LENGTH: Self = quantity("length", [1, 0, 0, 0, 0], "25 mm");
    pub(super) const MASS: Self = quantity("mass", [0, 1, 0, 0, 0], "1 kg");
    pub(super) const TIME: Self = quantity("time", [0, 0, 1, 0, 0], "10 s");
    pub(super) const INTERVAL: Self = quantity("time", [0, 0, 1, 0, 0], "0.01 s");
    pub(super) const ANGLE: Self = quantity("angle", [0, 0, 0, 1, 0], "30 deg");
    pub(super) const VELOCITY: Self = quantity("velocity", [1, 0, -1, 0, 0], "0.5 m/s");
    pub(super) const RATE: Self = quantity("angular velocity", [0, 0, -1, 1, 0], "3 rad/s");
    pub(super) const ACCELERATION: Self = quantity("acceleration", [1, 0, -2, 0, 0], "9.81 m/s^2");
    pub(super) const INERTIA: Self = quantity("moment of inertia", [2, 1, 0, 0, 0], "0.2 kg m^2");
    pub(super) const DENSITY: Self = quantity("density", [-3, 1, 0, 0, 0], "7850 kg/m^3");
    pub(super) const FORCE: Self = quantity("force", [0, 0, 0, 0, 1], "20 N");
    pub(super) const TORQUE: Self = quantity("torque", [1, 0, 0, 0, 1], "5 N m");
    pub(super) const STIFFNESS: Self = quantity("stiffness", [-1, 0, 0, 0, 1], "200 N/m");
    pub(super) const DAMPING: Self = quantity("damping", [-1, 0, 1, 0, 1], "3 N s/m");
    pub(super) const TORSION: Self = quantity("torsional stiffness", [1, 0, 0, -1, 1], "5 N m/rad");
    pub(super) const TORSION_DAMPING: Self =
        quantity("torsional damping", [1, 0, 1, -1, 1], "0.1 N m s/rad");

    pub(super) const ANGULAR_ACCELERATION: Self =
        quantity("angular acceleration", [0, 0, -2, 1, 0], "2 rad/s^2");
    pub(super) const MOMENTUM: Self = quantity("momentum", [1, 1, -1, 0, 0], "2 kg m/s");
    pub(super) const ANGULAR_MOMENTUM: Self =
        quantity("angular momentum", [2, 1, -1, 0, 0], "0.3 kg m^2/s");

    /// Its dimension.
    pub(super) fn dimension(self) -> Dimension {
        let [length, mass, time, _, force] = self.exponents;
        Dimension::new(length + force, mass + force, time - 2 * force)
    }

    /// Whether it is an angle, so that a bare number may be degrees.
    pub(super) fn is_angle(self) -> bool {
        self.exponents == Self::ANGLE.exponents
    }
}

/// The units of bare numbers in one file.
#[derive(Clone, Debug)]
pub(super) struct FileUnits {
    /// Scales of length, mass, time, angle and force.
    scales: [Scale; 5],
    /// Whether the author stated the unit of length.
    pub(super) length_stated: bool,
    /// Whether the author stated the unit of angle.
    pub(super) angle_stated: bool,
}

impl Default for FileUnits {
    /// SI and radians.
    fn default() -> Self {
        Self { scales: [Scale::ONE; 5], length_stated: false, angle_stated: false }
    }
}

impl FileUnits {
    /// Keys of the `[units]` table, in the order of the exponents, with what each measures.
    pub(super) const KEYS: [(&'static str, Quantity); 5] = [
        ("length", Quantity::LENGTH),
        ("mass", Quantity::MASS),
        ("time", Quantity::TIME),
        ("angle", Quantity::ANGLE),
        ("force", Quantity::FORCE),
    ];

    /// Sets the unit of the key with this index.
    pub(super) fn set(&mut self, key_idx: usize, unit: &Unit) {
        self.scales[key_idx] = unit.scale;
        self.length_stated |= key_idx == 0;
        self.angle_stated |= key_idx == 3;
    }

    /// Whether every bare number is SI.
    pub(super) fn is_si(&self) -> bool {
        self.scales.iter().all(|scale| scale.is_one())
    }

    /// Factor to SI of a bare number that stands for the quantity.
    pub(super) fn scale(&self, quantity: Quantity) -> Scale {
        self.scales
            .iter()
            .zip(quantity.exponents)
            .fold(Scale::ONE, |product, (scale, n)| product.times(scale.powi(n)))
    }

    /// Factor to SI of a bare number that is added to a known dimension: through the quantity of
    /// that name where there is one (a force in the file's force unit), else base by base.
    pub(super) fn scale_of(&self, dimension: Dimension) -> Scale {
        const KNOWN: [Quantity; 8] = [
            Quantity::FORCE,
            Quantity::TORQUE,
            Quantity::STIFFNESS,
            Quantity::DAMPING,
            Quantity::LENGTH,
            Quantity::MASS,
            Quantity::TIME,
            Quantity::TORSION_DAMPING,
        ];
        if let Some(quantity) = KNOWN.iter().find(|q| q.dimension() == dimension) {
            return self.scale(*quantity);
        }
        let [length, mass, time, ..] = self.scales;
        [(length, dimension.length), (mass, dimension.mass), (time, dimension.time)]
            .iter()
            .fold(Scale::ONE, |product, (scale, steps)| product.times(scale.powi(steps / STEPS)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::codes;
    use super::*;

    #[test]
    fn millimetres_convert_exactly() {
        let mm = find_unit("mm").expect("a unit").scale;
        assert_eq!(mm.apply(25.0), 0.025);
        assert_eq!(mm.powi(2).apply(1e6), 1.0);
        assert_eq!(mm.powi(-1).apply(1.0), 1000.0);
    }

    #[test]
    fn examples_of_quantities_name_units_of_their_dimension() {
        let all = [Quantity::LENGTH, Quantity::MASS, Quantity::TIME, Quantity::ANGLE];
        for quantity in all {
            let name = quantity.example.split(' ').nth(1).expect("a unit");
            assert_eq!(find_unit(name).expect("a unit").dimension, quantity.dimension());
        }
    }

    #[test]
    fn the_page_of_units_lists_them_all() {
        let mut pages = codes::PAGES.iter();
        let page = pages.find(|page| page.code == codes::UNKNOWN_UNIT).expect("a page").text;
        for unit in UNITS {
            assert!(page.contains(&format!("`{}`", unit.name)), "{} is not listed", unit.name);
        }
    }

    #[test]
    fn force_keeps_its_unit_beside_millimetres() {
        let mut units = FileUnits::default();
        units.set(0, find_unit("mm").expect("a unit"));
        assert_eq!(units.scale(Quantity::FORCE), Scale::ONE);
        assert_eq!(units.scale(Quantity::TORQUE).apply(500.0), 0.5);
        assert_eq!(units.scale(Quantity::STIFFNESS).apply(2.0), 2000.0);
    }

    #[test]
    fn dimensions_print_as_units() {
        assert_eq!(Quantity::TORQUE.dimension().to_string(), "N m");
        assert_eq!(Dimension::new(2, 0, -3).to_string(), "m^2/s^3");
        let root = Dimension::new(1, 0, 0).power(0.5).expect("twelfths");
        assert_eq!(root.to_string(), "m^0.5");
        assert_eq!(root.times(root), Dimension::new(1, 0, 0));
    }
}
