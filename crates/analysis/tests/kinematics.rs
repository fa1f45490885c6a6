//! Positions, velocities and accelerations over a range against references of 15 digits.

mod support;

use bksim_analysis::{Drive, Prescribed, kinematics};
use support::{Problem, compare};

/// Follows the crank over the angles of the reference, with its rate and acceleration.
fn follows(name: &str, tolerance: f64) {
    let problem = Problem::load(name);
    let rows = problem.rows();
    let model = problem.model();
    let values = format!("{}:{}:{}", rows[0][0], rows[rows.len() - 1][0], rows.len());
    let mut drive = Drive::parse(&model, "crank.angle", &values).expect("a drive");
    (drive.rate, drive.acceleration) = (3.7, -2.1);
    let prescribed = Prescribed::Drives { drives: vec![drive], through: false };
    let found = kinematics(model, &prescribed).expect("the range is followed");
    assert_eq!(found.stopped, None, "{name}: {} rows", found.table.rows.len());
    compare(&found.table, &problem.columns(), &rows, tolerance);
}

#[test]
fn crank_rocker() {
    follows("kin-crank-rocker", 1e-10);
}

#[test]
fn double_rocker_within_its_range() {
    follows("kin-double-rocker", 1e-10);
}

#[test]
fn drag_link() {
    follows("kin-drag-link", 1e-10);
}

#[test]
fn quick_return_with_a_slot() {
    follows("kin-whitworth", 1e-10);
}

#[test]
fn six_bar() {
    follows("kin-stephenson", 1e-10);
}

#[test]
fn crossed_parallelogram_between_its_change_points() {
    follows("kin-antiparallelogram", 1e-9);
}
