//! Positions over a range of a drive, for tests against closed forms.

use bksim::analysis::{Drive, Kinematics, Prescribed, kinematics};
use bksim::model::Model;

/// Positions and rates over a range of a drive.
pub(crate) fn over(model: Model, name: &str, values: &str) -> Kinematics {
    let drive = Drive::parse(&model, name, values).expect("a drive");
    let prescribed = Prescribed::Drives { drives: vec![drive], through: false };
    kinematics(model, &prescribed).expect("positions")
}

/// The column of this name.
pub(crate) fn column(found: &Kinematics, name: &str) -> Vec<f64> {
    found.table.column(name).unwrap_or_else(|| panic!("no column {name}"))
}

/// Fails where a number is farther from another than the tolerance.
#[track_caller]
pub(crate) fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} is not {expected}");
}

/// Where two circles meet, to the left of the line from the first centre to the second.
pub(crate) fn meet(a: [f64; 2], ra: f64, b: [f64; 2], rb: f64) -> [f64; 2] {
    let d = [b[0] - a[0], b[1] - a[1]];
    let length = d[0].hypot(d[1]);
    let along = (ra * ra - rb * rb + length * length) / (2.0 * length);
    let across = (ra * ra - along * along).sqrt();
    [0, 1].map(|k| a[k] + (along * d[k] + across * [-d[1], d[0]][k]) / length)
}
