//! Machine elements against reference motions: fixtures, tables of columns, and their comparison.

use bksim::Mechanism;
use bksim::sim::run::Sample;
use serde_json::Value;

use super::{Measures, at, coordinate, derive, model, path, reaction, signal, solve};

/// Largest difference over the largest value of a column, of coordinates and rates.
const WITHIN: f64 = 1e-9;
/// Of accelerations and forces.
const FORCES_WITHIN: f64 = 1e-8;

/// The text of a fixture.
pub(crate) fn text(name: &str) -> String {
    read(&format!("tests/fixtures/elements/{name}.toml"))
}

/// A reference, `elements/wedge` for instance.
pub(crate) fn reference(name: &str) -> Value {
    serde_json::from_str(&read(&format!("tests/data/{name}.json"))).expect("a reference is JSON")
}

fn read(file: &str) -> String {
    let file = path(file);
    std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()))
}

/// A quantity of a sample that a column holds, with the factor that turns ours into it.
#[derive(Clone, Copy)]
pub(crate) enum Quantity<'a> {
    /// An expression of positions and velocities.
    Measure(&'a str, f64),
    /// That of a coordinate.
    Position(&'a str, f64),
    /// Acceleration that is compared.
    Acceleration(&'a str, f64),
    /// Velocity that is compared; the velocity of an integral is its state.
    Velocity(&'a str, f64),
    /// That of this index.
    Signal(usize),
    /// A signal or output of this name.
    Named(&'a str),
    /// The multiplier of a coupling.
    Coupling(&'a str, f64),
    /// A component of the reaction of a joint.
    Reaction(&'a str, usize, f64),
}

impl Quantity<'_> {
    fn of(self, mechanism: &Mechanism, sample: &Sample) -> f64 {
        match self {
            Self::Measure(name, factor) => factor * Measures::new(mechanism, &[name]).at(sample)[0],
            Self::Position(name, factor) => factor * sample.q[coordinate(mechanism, name)],
            Self::Acceleration(name, factor) => factor * sample.a[coordinate(mechanism, name)],
            Self::Velocity(name, factor) => factor * sample.v[coordinate(mechanism, name)],
            Self::Signal(idx) => sample.signals[idx],
            Self::Named(name) => signal(mechanism, sample, name),
            Self::Coupling(name, factor) => factor * effort(mechanism, sample, name),
            Self::Reaction(joint, axis, factor) => {
                factor * reaction(mechanism, sample, joint)[axis]
            }
        }
    }

    fn within(self) -> f64 {
        match self {
            Self::Measure(..)
            | Self::Position(..)
            | Self::Velocity(..)
            | Self::Signal(_)
            | Self::Named(_) => WITHIN,
            _ => FORCES_WITHIN,
        }
    }
}

/// The multiplier of a coupling.
pub(crate) fn effort(mechanism: &Mechanism, sample: &Sample, name: &str) -> f64 {
    let description = format!("coupling `{name}`");
    let row = mechanism.compiled.multipliers.iter().position(|m| m.description == description);
    sample.lambda[row.unwrap_or_else(|| panic!("no {description}"))]
}

/// The place of a column.
pub(crate) fn column(data: &Value, name: &str) -> usize {
    let names = data["columns"].as_array().expect("columns").iter();
    let place = names.filter_map(Value::as_str).position(|known| known == name);
    place.unwrap_or_else(|| panic!("no column `{name}`"))
}

/// A number of a row.
pub(crate) fn number(row: &Value, place: usize) -> f64 {
    row[place].as_f64().expect("a number")
}

/// Runs a model and compares columns of a reference.
#[track_caller]
pub(crate) fn check(text: &str, data: &str, columns: &[(&str, Quantity<'_>)]) {
    check_rows(text, data, &|_| true, columns);
}

/// Checks ([`check`]) the rows that `applies` says.
#[track_caller]
pub(crate) fn check_rows(
    text: &str,
    data: &str,
    applies: &dyn Fn(&Value) -> bool,
    columns: &[(&str, Quantity<'_>)],
) {
    let reference = reference(data);
    let mechanism = derive(model(text));
    let motion = solve(&mechanism);
    let rows = reference["rows"].as_array().expect("rows").iter();
    let rows: Vec<&Value> = rows.filter(|row| applies(row)).collect();
    assert!(!rows.is_empty(), "{data}: no row applies");
    let time = column(&reference, "t");
    for &(name, quantity) in columns {
        let place = column(&reference, name);
        let scale = rows.iter().map(|row| number(row, place).abs()).fold(0.0, f64::max);
        for row in &rows {
            let (t, expected) = (number(row, time), number(row, place));
            let found = quantity.of(&mechanism, at(&motion, t));
            assert!(
                (found - expected).abs() <= quantity.within() * scale,
                "{data}, {name} at {t} s: {found:.15e} for {expected:.15e}, off by {:.1e}",
                (found - expected).abs() / scale
            );
        }
    }
}

/// The text of a fixture of ropes, wheels and blades.
pub(crate) fn touch_text(fixture: &str) -> String {
    read(&format!("tests/fixtures/touch/{fixture}.toml"))
}

/// Runs a model and compares its outputs with columns of the same names, of those rows that `applies` says.
#[track_caller]
pub(crate) fn check_outputs(
    text: &str,
    data: &str,
    applies: &dyn Fn(&Value) -> bool,
    columns: &[&str],
) {
    let columns: Vec<(&str, Quantity<'_>)> =
        columns.iter().map(|&name| (name, Quantity::Named(name))).collect();
    check_rows(text, &format!("touch/{data}"), applies, &columns);
}
