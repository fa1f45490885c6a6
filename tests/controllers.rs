//! States and signals of controllers and motors against reference motions, and what must not see them.

mod support;

use bksim::Mechanism;
use bksim::sim::run::Sample;
use serde_json::Value;
use support::{Within, at, close, coordinate, derive, model, path, solve};

fn text(name: &str) -> String {
    let file = path("tests/fixtures/elements").join(format!("{name}.toml"));
    std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()))
}

fn reference(name: &str) -> Value {
    let file = path("tests/data/elements").join(format!("{name}.json"));
    let text = std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    serde_json::from_str(&text).expect("a reference is JSON")
}

/// A number of a sample that a column holds.
type Column<'a> = (&'a str, &'a dyn Fn(&Mechanism, &Sample) -> f64);

/// Compares columns of a reference, of those rows that begin with `mode` if there is one.
#[track_caller]
fn check(text: &str, data: &str, mode: Option<f64>, columns: &[Column<'_>]) {
    let reference = reference(data);
    let mechanism = derive(model(text));
    let motion = solve(&mechanism);
    let known: Vec<&str> = reference["columns"]
        .as_array()
        .expect("columns")
        .iter()
        .filter_map(Value::as_str)
        .collect();
    let number = |row: &Value, k: usize| row[k].as_f64().expect("a number");
    let rows = reference["rows"].as_array().expect("rows").iter();
    let rows: Vec<&Value> = rows.filter(|row| mode.is_none_or(|m| number(row, 0) == m)).collect();
    let time = usize::from(mode.is_some());
    for (name, value) in columns {
        let place = known.iter().position(|known| known == name).expect("a column of this name");
        let scale = rows.iter().map(|row| number(row, place).abs()).fold(0.0, f64::max);
        for row in &rows {
            let t = number(row, time);
            let what = format!("{data}, {name} at {t} s");
            let within = Within { relative: 0.0, absolute: 1e-9 * scale };
            close(&what, value(&mechanism, at(&motion, t)), number(row, place), within);
        }
    }
}

/// The value of a coordinate.
fn q(name: &'static str) -> impl Fn(&Mechanism, &Sample) -> f64 {
    move |mechanism, sample| sample.q[coordinate(mechanism, name)]
}

/// Its velocity.
fn v(name: &'static str) -> impl Fn(&Mechanism, &Sample) -> f64 {
    move |mechanism, sample| sample.v[coordinate(mechanism, name)]
}

/// The value of the named signal of this index.
fn signal(idx: usize) -> impl Fn(&Mechanism, &Sample) -> f64 {
    move |_, sample| sample.signals[idx]
}

#[test]
fn a_continuous_pid() {
    let columns: [Column<'_>; 4] = [
        ("x", &q("S_position")),
        ("v", &v("S_position")),
        ("e", &v("e_integral")),
        ("u", &signal(0)),
    ];
    check(&text("pid-continuous"), "pid_continuous", None, &columns);
}

#[test]
fn a_motor_with_inductance() {
    let columns: [Column<'_>; 3] =
        [("i", &v("i_integral")), ("w", &v("A_angle")), ("phi", &q("A_angle"))];
    let motor = text("dc-motor");
    check(&motor, "dc_motor", None, &columns);
    // The implicit method integrates states as well.
    check(&format!("{motor}method = \"radau\"\n"), "dc_motor", None, &columns);
}

#[test]
fn a_limited_torque_without_and_with_anti_windup() {
    let columns: [Column<'_>; 4] =
        [("w", &v("A_angle")), ("I", &v("I_integral")), ("v", &signal(0)), ("u", &signal(1))];
    let plain = text("antiwindup");
    check(&plain, "antiwindup", Some(0.0), &columns);
    check(&plain.replace("kb = 0", "kb = 4"), "antiwindup", Some(1.0), &columns);
}

#[test]
fn a_cart_and_pole_with_an_integral() {
    let columns: [Column<'_>; 5] = [
        ("x", &q("x")),
        ("v", &v("x")),
        ("th", &q("th")),
        ("w", &v("th")),
        ("e", &v("e_integral")),
    ];
    check(&text("cartpole-lqi"), "cartpole_lqi", None, &columns);
}

#[test]
fn a_state_is_neither_a_freedom_nor_energy() {
    let mechanism = derive(model(&text("pid-continuous")));
    let start = mechanism.start().expect("a start");
    assert_eq!(start.mobility, 1);
    let motion = solve(&mechanism);
    for sample in &motion.samples {
        // Of the mass alone; the power is that of the force.
        let speed = sample.v[0];
        close(
            "kinetic",
            sample.energy.kinetic,
            speed * speed,
            Within { relative: 1e-12, absolute: 1e-15 },
        );
    }
}
