//! Efforts and reactions of given motions against references of 15 digits.

mod support;

use bksim_analysis::{Range, inverse};
use support::{Problem, difference, model};

/// Compares both tables of a reference: the drive of the model over the times at which the crank is where the
/// rows say, at a constant rate and along a polynomial.
fn needs_these(name: &str, t_end: f64) {
    let problem = Problem::load(name);
    let rows = problem.rows();
    let (first, last) = (&rows[0], &rows[rows.len() - 1]);
    let times = Range { from: 0.0, to: (last[0] - first[0]) / first[1], n: rows.len() };
    check(&problem, problem.model(), &times, &rows);
    let polynomial = problem.0["model"]["toml_polynomial"].as_str().expect("a model");
    let rows = problem.rows_of("rows_polynomial");
    let times = Range { from: 0.0, to: t_end, n: rows.len() };
    check(&problem, model(polynomial), &times, &rows);
}

fn check(problem: &Problem, model: bksim_model::Model, times: &Range, rows: &[Vec<f64>]) {
    let found = inverse(model, &[], times).expect("efforts");
    for (k, column) in problem.columns().iter().enumerate() {
        let name = match column.as_str() {
            "crank.angle" => "on_A.angle".to_owned(),
            "crank.rate" => "on_A.rate".to_owned(),
            "crank.acceleration" => "on_A.acceleration".to_owned(),
            "drive on A" => "on_A.effort".to_owned(),
            name => name.replace(".F", ".f").replace(".M", ".m"),
        };
        let expected: Vec<f64> = rows.iter().map(|row| row[k]).collect();
        let values = found.table.column(&name).unwrap_or_else(|| panic!("no column {name}"));
        let off = difference(&values, &expected, column.rsplit('.').next() == Some("angle"));
        assert!(off < 1e-10, "{column} differs by {off:e}");
    }
}

#[test]
fn four_bar() {
    needs_these("inv-four-bar", 0.8);
}

#[test]
fn six_bar() {
    needs_these("inv-watt", 0.9);
}

#[test]
fn walking_leg() {
    needs_these("inv-jansen", 1.25);
}

#[test]
fn efforts_follow_the_branches_of_loads_along_the_motion() {
    // A ram that is driven outwards meets a piece beyond 1 m, and a spring by a table.
    let ram = model(
        r#"
        [tables.spring]
        points = [[0, 0], [1, 30], [2, 100]]
        units = ["m", "N"]
        interpolation = "linear"
        [bodies.ram]
        mass = 2
        inertia = 0
        [joints.guide]
        type = "prismatic"
        between = ["ground", "ram"]
        axis = [1, 0]
        coordinate = "x"
        [loads]
        piece = { type = "force", on = "ram", vector = ["if(x > 1 and ram.vx > 0, -7, 0)", 0] }
        table = { type = "force", on = "ram", vector = ["-spring(x)", 0] }
        [drives.motor]
        joint = "guide"
        motion = "1 m/s*t"
        "#,
    );
    let times = Range { from: 0.1, to: 1.9, n: 10 };
    let found = inverse(ram, &[], &times).expect("efforts").table;
    let effort = found.column("motor.effort").expect("the drive's force");
    let reaction = found.column("guide.fy").expect("the guide's force");
    for (k, x) in times.values().into_iter().enumerate() {
        let expected = if x > 1.0 { 7.0 + 30.0 + 70.0 * (x - 1.0) } else { 30.0 * x };
        assert!((effort[k] - expected).abs() < 1e-12, "{x} m: {} N, not {expected}", effort[k]);
        assert!(reaction[k].abs() < 1e-12);
    }
}
