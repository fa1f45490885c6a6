//! Units for bare numbers: in a drawing they would mean something else.

use toml_edit::{DocumentMut, Item};

use super::texts::{is_bare, words};

/// The units of bare numbers of the file.
#[derive(Clone, Debug)]
pub(super) struct FileUnits {
    length: String,
    mass: String,
    time: String,
    angle: String,
    force: String,
}

/// Keys of `[units]`, with the default of each.
pub(super) const KEYS: [(&str, &str); 5] =
    [("length", "m"), ("mass", "kg"), ("time", "s"), ("angle", "rad"), ("force", "N")];

/// Dimensions of values.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Dimension {
    /// A number, a name, or whatever the author says.
    Open,
    Length,
    Angle,
    Mass,
    Inertia,
    Density,
    Time,
    Speed,
    Rate,
    Force,
    Torque,
    Stiffness,
    Damping,
    TurningStiffness,
    TurningDamping,
}

impl FileUnits {
    pub(super) fn of(document: &DocumentMut) -> Self {
        let table = document.get("units").and_then(Item::as_table_like);
        let [length, mass, time, angle, force] = KEYS.map(|(key, default)| {
            table.and_then(|t| words(t, key)).unwrap_or_else(|| default.to_owned())
        });
        Self { length, mass, time, angle, force }
    }

    /// The unit of a dimension; empty for none.
    fn unit(&self, dimension: Dimension) -> String {
        let Self { length, mass, time, angle, force } = self;
        match dimension {
            Dimension::Open => String::new(),
            Dimension::Length => length.clone(),
            Dimension::Angle => angle.clone(),
            Dimension::Mass => mass.clone(),
            Dimension::Inertia => format!("{mass} {length}^2"),
            Dimension::Density => format!("{mass}/{length}^3"),
            Dimension::Time => time.clone(),
            Dimension::Speed => format!("{length}/{time}"),
            Dimension::Rate => format!("{angle}/{time}"),
            Dimension::Force => force.clone(),
            Dimension::Torque => format!("{force} {length}"),
            Dimension::Stiffness => format!("{force}/{length}"),
            Dimension::Damping => format!("{force} {time}/{length}"),
            Dimension::TurningStiffness => format!("{force} {length}/{angle}"),
            Dimension::TurningDamping => format!("{force} {length} {time}/{angle}"),
        }
    }

    /// A value with its unit, if it is a bare number.
    pub(super) fn complete(&self, words: String, dimension: Dimension) -> String {
        let unit = self.unit(dimension);
        if unit.is_empty() || !is_bare(&words) { words } else { format!("{words} {unit}") }
    }
}

/// The dimension of a key of a kind; `slides` where it depends on the joint.
pub(super) fn dimension(kind: &str, key: &str, slides: bool) -> Dimension {
    match (kind, key) {
        (_, "mass") => Dimension::Mass,
        (_, "inertia") => Dimension::Inertia,
        (_, "density") => Dimension::Density,
        ("cylinder", "min" | "max")
        | ("cam", "base_circle")
        | (_, "thickness" | "length" | "radius" | "position" | "x" | "y" | "module" | "lead") => {
            Dimension::Length
        }
        // That of a state has the unit that the state has.
        ("state", "rate") => Dimension::Open,
        (_, "rate" | "rate1" | "rate2") => Dimension::Rate,
        (_, "velocity" | "vx" | "vy") => Dimension::Speed,
        ("actuator" | "friction", "force") | ("actuator" | "force", "value") => Dimension::Force,
        ("friction", "static") if slides => Dimension::Force,
        ("torque", "value") | ("friction", "torque" | "static") => Dimension::Torque,
        ("torsion", "stiffness") => Dimension::TurningStiffness,
        ("torsion", "damping") => Dimension::TurningDamping,
        (_, "stiffness") => Dimension::Stiffness,
        (_, "damping") => Dimension::Damping,
        (_, "min" | "max" | "motion") if slides => Dimension::Length,
        ("line-on-curve", "direction")
        | ("friction", "pressure_angle")
        | (_, "min" | "max" | "motion" | "angle" | "angle1" | "angle2") => Dimension::Angle,
        (_, "t_start" | "t_end" | "every" | "step") | ("clock", "start") => Dimension::Time,
        _ => Dimension::Open,
    }
}
