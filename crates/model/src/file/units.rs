//! Units and the quantities a model is made of.
//!
//! Angles are dimensionless; that a number is an angle is remembered only where it is a matter of
//! wording or of what a bare number means.

use super::dimension::{
    CAPACITANCE, CHARGE, CONDUCTANCE, CURRENT, Dimension, FLUX, FLUX_DENSITY, INDUCTANCE,
    RESISTANCE, VOLTAGE, electrical,
};

/// A conversion factor `up / down · π^pi`, so that 25 mm is exactly 25/1000 m and 30 deg is π/6.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Scale {
    /// A whole number below 2⁵³, as long as units are combined sensibly.
    pub(super) up: f64,
    /// Divisor, read like `up`.
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

    /// True if it changes nothing.
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
    /// True if it measures angles.
    pub(super) is_angle: bool,
}

const fn unit(name: &'static str, up: f64, down: f64, [l, m, t]: [i32; 3]) -> Unit {
    let scale = Scale { up, down, pi: 0 };
    Unit { name, scale, dimension: Dimension::new(l, m, t), is_angle: false }
}

const fn electric(name: &'static str, up: f64, down: f64, exponents: [i32; 4]) -> Unit {
    let scale = Scale { up, down, pi: 0 };
    Unit { name, scale, dimension: electrical(exponents), is_angle: false }
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
    unit("Wh", 3600.0, 1.0, ENERGY),
    unit("kWh", 3.6e6, 1.0, ENERGY),
    unit("Nm", 1.0, 1.0, ENERGY),
    unit("W", 1.0, 1.0, POWER),
    unit("mW", 1.0, 1000.0, POWER),
    unit("kW", 1000.0, 1.0, POWER),
    unit("Pa", 1.0, 1.0, PRESSURE),
    unit("kPa", 1000.0, 1.0, PRESSURE),
    unit("MPa", 1e6, 1.0, PRESSURE),
    unit("GPa", 1e9, 1.0, PRESSURE),
    unit("bar", 1e5, 1.0, PRESSURE),
    electric("A", 1.0, 1.0, CURRENT),
    electric("uA", 1.0, 1e6, CURRENT),
    electric("µA", 1.0, 1e6, CURRENT),
    electric("mA", 1.0, 1000.0, CURRENT),
    electric("kA", 1000.0, 1.0, CURRENT),
    electric("V", 1.0, 1.0, VOLTAGE),
    electric("uV", 1.0, 1e6, VOLTAGE),
    electric("µV", 1.0, 1e6, VOLTAGE),
    electric("mV", 1.0, 1000.0, VOLTAGE),
    electric("kV", 1000.0, 1.0, VOLTAGE),
    electric("ohm", 1.0, 1.0, RESISTANCE),
    electric("mohm", 1.0, 1000.0, RESISTANCE),
    electric("kohm", 1000.0, 1.0, RESISTANCE),
    electric("Mohm", 1e6, 1.0, RESISTANCE),
    electric("Ω", 1.0, 1.0, RESISTANCE),
    electric("mΩ", 1.0, 1000.0, RESISTANCE),
    electric("kΩ", 1000.0, 1.0, RESISTANCE),
    electric("MΩ", 1e6, 1.0, RESISTANCE),
    electric("S", 1.0, 1.0, CONDUCTANCE),
    electric("mS", 1.0, 1000.0, CONDUCTANCE),
    electric("H", 1.0, 1.0, INDUCTANCE),
    electric("uH", 1.0, 1e6, INDUCTANCE),
    electric("µH", 1.0, 1e6, INDUCTANCE),
    electric("mH", 1.0, 1000.0, INDUCTANCE),
    electric("F", 1.0, 1.0, CAPACITANCE),
    electric("pF", 1.0, 1e12, CAPACITANCE),
    electric("nF", 1.0, 1e9, CAPACITANCE),
    electric("uF", 1.0, 1e6, CAPACITANCE),
    electric("µF", 1.0, 1e6, CAPACITANCE),
    electric("mF", 1.0, 1000.0, CAPACITANCE),
    electric("C", 1.0, 1.0, CHARGE),
    electric("mC", 1.0, 1000.0, CHARGE),
    electric("Ah", 3600.0, 1.0, CHARGE),
    electric("mAh", 36.0, 10.0, CHARGE),
    electric("Wb", 1.0, 1.0, FLUX),
    electric("mWb", 1.0, 1000.0, FLUX),
    electric("T", 1.0, 1.0, FLUX_DENSITY),
    electric("mT", 1.0, 1000.0, FLUX_DENSITY),
];

/// The unit of this name; case counts. Omega and mu may be letters or signs of their own, which look alike.
pub(super) fn find_unit(name: &str) -> Option<&'static Unit> {
    let usual = |c: char| match c {
        '\u{2126}' => 'Ω',
        '\u{3bc}' => 'µ',
        other => other,
    };
    UNITS.iter().find(|unit| unit.name.chars().eq(name.chars().map(usual)))
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
    pub(super) const AREA: Self = quantity("area", [2, 0, 0, 0, 0], "100 mm^2");
    pub(super) const AREA_MOMENT: Self =
        quantity("second moment of area", [4, 0, 0, 0, 0], "200 mm^4");
    pub(super) const MODULUS: Self = quantity("modulus", [-2, 0, 0, 0, 1], "210 GPa");
    pub(super) const BENDING: Self = quantity("stiffness of bending", [2, 0, 0, 0, 1], "40 N m^2");
    pub(super) const LINE_MASS: Self = quantity("mass per length", [-1, 1, 0, 0, 0], "0.8 kg/m");
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

    /// Dimension of the quantity.
    pub(super) fn dimension(self) -> Dimension {
        let [length, mass, time, _, force] = self.exponents;
        Dimension::new(length + force, mass + force, time - 2 * force)
    }

    /// True of an angle, and of an angle per time.
    pub(super) fn is_rotation(self) -> bool {
        matches!(self.exponents, [0, 0, 0 | -1, 1, 0])
    }

    /// True if an angle is in it.
    pub(super) fn is_turning(self) -> bool {
        self.exponents[3] != 0
    }

    /// True if it is an angle, so that a bare number may be degrees.
    pub(super) fn is_angle(self) -> bool {
        self.exponents == Self::ANGLE.exponents
    }
}

/// The units of bare numbers in one file.
#[derive(Clone, Debug)]
pub(super) struct FileUnits {
    /// Scales of length, mass, time, angle and force.
    scales: [Scale; 5],
    /// Names of these units.
    names: [&'static str; 5],
    /// True if the author stated the unit of length.
    pub(super) length_stated: bool,
    /// True if the author stated the unit of angle.
    pub(super) angle_stated: bool,
}

impl Default for FileUnits {
    /// SI and radians.
    fn default() -> Self {
        let names = Self::SI;
        Self { scales: [Scale::ONE; 5], names, length_stated: false, angle_stated: false }
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

    /// SI units by key, and the radian.
    const SI: [&'static str; 5] = ["m", "kg", "s", "rad", "N"];

    /// A unit of SI with those of the file in place of them: `mm/s` for `m/s`.
    pub(super) fn in_place_of(&self, unit: &str) -> String {
        let own = |word: &str| {
            let known = Self::SI.iter().position(|si| *si == word);
            known.map_or(word, |k| self.names[k]).to_owned()
        };
        let is_letter = |c: char| c.is_alphabetic();
        let (mut text, mut rest) = (String::new(), unit);
        while let Some(first) = rest.chars().next() {
            let is_word = is_letter(first);
            let end = rest.find(|c| is_letter(c) != is_word).unwrap_or(rest.len());
            let (part, others) = rest.split_at(end);
            text.push_str(&if is_word { own(part) } else { part.to_owned() });
            rest = others;
        }
        text
    }

    /// Sets the unit of the key with this index.
    pub(super) fn set(&mut self, key_idx: usize, unit: &Unit) {
        self.scales[key_idx] = unit.scale;
        self.names[key_idx] = unit.name;
        self.length_stated |= key_idx == 0;
        self.angle_stated |= key_idx == 3;
    }

    /// True if every bare number is SI.
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
    /// that name where there is one (a force in the file's force unit), else base by base. Electrical ones
    /// are SI in every file: a volt holds no millimetres.
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
        if dimension.is_electrical() {
            return Scale::ONE;
        }
        if let Some(quantity) = KNOWN.iter().find(|q| q.dimension() == dimension) {
            return self.scale(*quantity);
        }
        let [length, mass, time, ..] = self.scales;
        [length, mass, time]
            .iter()
            .zip(dimension.mechanical())
            .fold(Scale::ONE, |product, (scale, exponent)| product.times(scale.powi(exponent)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::codes;
    use super::super::dimension::NOUNS;
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
    fn electrical_units_multiply_to_mechanical_ones() {
        let of = |name: &str| find_unit(name).expect("a unit").dimension;
        assert_eq!(of("V").times(of("A")), of("W"));
        assert_eq!(of("V").over(of("A")), of("ohm"));
        assert_eq!(of("V").times(of("A")).times(of("s")), of("Wh"));
        assert_eq!(of("V").times(of("s")).over(of("A")), of("H"));
        assert_eq!(of("ohm").times(of("S")), Dimension::NONE);
        assert_eq!(of("C").over(of("V")), of("F"));
        assert_eq!(of("V").times(of("s")), of("N").times(of("m")).over(of("A")));
        assert_eq!(of("T").times(of("m")).times(of("m")), of("Wb"));
        // A tesla is a newton per ampere and metre.
        assert_eq!(of("T").times(of("A")).times(of("m")), of("N"));
        for (one, same) in [("Ω", "ohm"), ("k\u{2126}", "kohm"), ("µH", "uH"), ("\u{3bc}m", "um")]
        {
            let [one, same] = [one, same].map(|name| find_unit(name).expect("a unit"));
            assert_eq!((one.scale, one.dimension), (same.scale, same.dimension));
        }
    }

    #[test]
    fn electrical_units_have_their_factors() {
        let factors = [
            ("mA", 1e-3),
            ("kV", 1e3),
            ("mohm", 1e-3),
            ("Mohm", 1e6),
            ("uH", 1e-6),
            ("nF", 1e-9),
            ("pF", 1e-12),
            ("Ah", 3600.0),
            ("mAh", 3.6),
            ("kWh", 3.6e6),
        ];
        for (name, expected) in factors {
            assert_eq!(find_unit(name).expect("a unit").scale.apply(1.0), expected, "{name}");
        }
    }

    #[test]
    fn electrical_quantities_are_si_beside_millimetres() {
        let mut units = FileUnits::default();
        for (key_idx, name) in [(0, "mm"), (1, "g"), (2, "ms"), (4, "kN")] {
            units.set(key_idx, find_unit(name).expect("a unit"));
        }
        for unit in UNITS.iter().filter(|unit| unit.dimension.is_electrical()) {
            assert_eq!(units.scale_of(unit.dimension), Scale::ONE, "{}", unit.name);
        }
        // A power is mechanical as well.
        assert_ne!(units.scale_of(find_unit("W").expect("a unit").dimension), Scale::ONE);
    }

    #[test]
    fn every_unit_of_a_dimension_is_read_as_that_dimension() {
        use super::super::written_unit::WrittenUnit;
        for (dimension, noun, unit) in NOUNS.iter().filter(|(.., unit)| !unit.is_empty()) {
            let read =
                unit.strip_prefix("1/").map_or((*unit).to_owned(), |rest| format!("rad/{rest}"));
            let read = WrittenUnit::parse(&read).expect("a unit");
            assert_eq!((read.dimension, read.scale), (*dimension, Scale::ONE), "{noun}");
        }
        let inductance = electrical(INDUCTANCE);
        for power in [
            inductance.times(inductance),
            electrical(VOLTAGE).over(inductance),
            electrical(FLUX_DENSITY).over(electrical(CHARGE)),
        ] {
            let read = WrittenUnit::parse(&power.to_string()).expect("a unit");
            assert_eq!((read.dimension, read.scale), (power, Scale::ONE), "{power}");
        }
    }

    #[test]
    fn dimensions_print_as_units() {
        let of = |name: &str| find_unit(name).expect("a unit").dimension;
        let per_second = |name: &str| of(name).over(of("s")).to_string();
        assert_eq!(["A", "V", "ohm"].map(per_second), ["A/s", "V/s", "V/(A s)"]);
        assert_eq!(of("V").over(of("m")).to_string(), "V/m");
        assert_eq!(of("A").over(of("m")).to_string(), "A/m");
        assert_eq!(of("Wb").to_string(), "N m/A");
        assert_eq!(of("V").power(0.5).map(|root| root.to_string()), Some("V^0.5".to_owned()));
        assert_eq!(Quantity::TORQUE.dimension().to_string(), "N m");
        assert_eq!(Dimension::new(2, 0, -3).to_string(), "m^2/s^3");
        let root = Dimension::new(1, 0, 0).power(0.5).expect("twelfths");
        assert_eq!(root.to_string(), "m^0.5");
        assert_eq!(root.times(root), Dimension::new(1, 0, 0));
    }
}
