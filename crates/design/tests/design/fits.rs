//! Fits to printed data against their least-squares optima in many digits.

use std::fmt::Write;

use bksim_design::{DataFile, Fit, FitWish, Source, Unknown, Watch, fit};
use serde_json::Value;

fn fixture(text: &str) -> Value {
    serde_json::from_str(text).expect("a fixture")
}

/// Rows of a fixture as comma-separated values.
fn data(fixture: &Value) -> DataFile {
    let mut text = String::new();
    let names: Vec<&str> =
        fixture["columns"].as_array().expect("columns").iter().filter_map(Value::as_str).collect();
    let _ = writeln!(text, "{}", names.join(","));
    for row in fixture["rows"].as_array().expect("rows") {
        let cells: Vec<String> =
            row.as_array().expect("a row").iter().map(Value::to_string).collect();
        let _ = writeln!(text, "{}", cells.join(","));
    }
    DataFile { name: "run.csv".to_owned(), text, ..DataFile::default() }
}

fn solved(text: &str, data: &[DataFile]) -> Fit {
    let source = Source { text: text.to_owned(), name: "model".to_owned(), ..Source::default() };
    let wish = FitWish::of_model(text).expect("a question");
    fit(&source, data, &wish, Watch::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn of<'f>(found: &'f Fit, name: &str) -> &'f Unknown {
    found.unknowns.iter().find(|u| u.name == name).expect("an unknown")
}

/// Estimates within a part of their standard errors, and these to some digits.
#[track_caller]
fn agrees(found: &Fit, fixture: &Value, names: &[&str], [off, of_error]: [f64; 2]) {
    assert!(found.converged, "{found:?}");
    let order = fixture["values"]["order"].as_array().expect("an order");
    for (k, name) in order.iter().filter_map(Value::as_str).enumerate() {
        let number = |key: &str| fixture["values"][key][k].as_f64().expect("a number");
        let (estimate, error) = (number("estimate"), number("standard_error"));
        let unknown = of(found, names[k]);
        let distance = (unknown.estimate - estimate).abs() / error;
        assert!(
            distance < off,
            "{name}: {} for {estimate}, {distance:e} standard errors",
            unknown.estimate
        );
        let own = unknown.standard_error.expect("a standard error");
        assert!((own - error).abs() < of_error * error, "{name}: standard error {own} for {error}");
    }
}

const PENDULUM: &str = r#"
[parameters]
kappa = 9.0
delta = 0.1
[bodies.bob]
mass = "1 kg"
inertia = 0
com = [0, "-1 m"]
[joints.A]
type = "revolute"
between = ["ground", "bob"]
[loads.weight]
type = "torque"
joint = "A"
value = "-kappa*sin(A.angle)*1 N m - delta*A.rate*1 N m s"
[initial]
A = { angle = "1 rad", rate = "0.05 rad/s" }
[solve]
t_end = "1 s"
[fit]
vary = ["kappa", "delta", "A.angle", "A.rate"]
compare = { theta_measured = "A.angle" }
sigma = { theta_measured = 0.004 }
"#;

#[test]
fn a_decaying_swing_gives_constant_and_damping() {
    let fixture = fixture(include_str!("../fixtures/id_pendulum.json"));
    let found = solved(PENDULUM, &[data(&fixture)]);
    agrees(&found, &fixture, &["kappa", "delta", "A.angle", "A.rate"], [1e-6, 1e-5]);
    assert!(found.open.null_vectors.is_empty(), "{:?}", found.open);
    let s2 = fixture["values"]["s2_over_sigma2"].as_f64().expect("a number");
    assert!((found.s2 - s2).abs() < 1e-6 * s2, "{} for {s2}", found.s2);
}

#[test]
fn what_the_swing_cannot_tell_apart_is_named() {
    let fixture = fixture(include_str!("../fixtures/id_pendulum.json"));
    let text = PENDULUM
        .replace("kappa = 9.0\ndelta = 0.1", "m = 1.0\nI = 1.0\nl = 0.9\nc = 0.1\nidle = 1.0")
        .replace("-kappa*", "-m*9.81*l/I*")
        .replace("- delta*", "- c/I*")
        .replace(r#"["kappa", "delta", "#, r#"["m", "I", "l", "c", "idle", "#);
    let found = solved(&text, &[data(&fixture)]);
    assert_eq!(found.open.without_effect, ["idle"]);
    assert_eq!(found.open.rank, 4, "{:?}", found.open);
    assert_eq!(found.open.null_vectors.len(), 2);
    assert_eq!(found.open.unidentifiable_together, [["m", "I", "l", "c"]]);
    assert_eq!(of(&found, "idle").estimate, 1.0, "what has no effect stays");
    for name in ["m", "I", "l", "c", "idle"] {
        assert_eq!(of(&found, name).standard_error, None, "{name}");
    }
    let kappa =
        of(&found, "m").estimate * 9.81 * of(&found, "l").estimate / of(&found, "I").estimate;
    assert!((kappa - 9.19692752819727).abs() < 1e-5, "{kappa}");
}

#[test]
fn a_sensor_that_comes_late_has_its_delay() {
    // Exact data from a run of the pendulum's own, 37 ms late and 20 mrad off.
    let instants: Vec<f64> = (0..60).map(|k| 0.1 + 0.05 * f64::from(k)).collect();
    let mut text = String::from("t [s], psi [rad]\n");
    let simulation = bksim::Mechanism::from_toml(
        &PENDULUM.replace(
            "t_end = \"1 s\"",
            "t_end = \"4 s\"\nevery = \"1 ms\"\nrtol = 1e-11\natol = 1e-13",
        ),
        "pendulum",
    )
    .and_then(|mechanism| mechanism.solve())
    .expect("a motion");
    for t in &instants {
        let late = t - 0.037;
        let sample =
            simulation.samples.iter().find(|s| (s.t - late).abs() < 1e-9).expect("a sample");
        let _ = writeln!(text, "{t},{}", sample.q[0] + 0.02);
    }
    let file = DataFile { name: "late.csv".to_owned(), text, ..DataFile::default() };
    let question = PENDULUM
        .replace(
            r#"vary = ["kappa", "delta", "A.angle", "A.rate"]"#,
            "vary = { kappa = 8.8 }\nunknowns = { late = \"0.03 s\", off = 0 }",
        )
        .replace(
            r#"compare = { theta_measured = "A.angle" }"#,
            "compare = { psi = \"A.angle + off\" }\ndelay = { psi = \"late\" }",
        )
        .replace("sigma = { theta_measured = 0.004 }\n", "");
    let found = solved(&question, &[file]);
    for (name, exact) in [("kappa", 9.0), ("late", 0.037), ("off", 0.02)] {
        let estimate = of(&found, name).estimate;
        assert!((estimate - exact).abs() < 1e-6, "{name}: {estimate} for {exact}");
    }
}

#[test]
fn measured_angles_give_the_lengths_of_a_four_bar_but_no_scale() {
    let fixture = fixture(include_str!("../fixtures/id_four_bar_lengths.json"));
    let model = |vary: &str| {
        format!(
            r#"
[parameters]
a = "0.05 m"
b = "0.135 m"
c = "0.085 m"
d = "0.16 m"
[ground]
points = {{ A = [0, 0], D = ["d", 0] }}
[bodies.crank]
points = {{ A = [0, 0], B = ["a", 0] }}
[bodies.coupler]
points = {{ B = [0, 0], C = ["b", 0] }}
[bodies.rocker]
points = {{ D = [0, 0], C = ["c", 0] }}
[joints.A]
type = "revolute"
between = ["ground.A", "crank.A"]
[joints.B]
type = "revolute"
between = ["crank.B", "coupler.B"]
[joints.C]
type = "revolute"
between = ["coupler.C", "rocker.C"]
[joints.D]
type = "revolute"
between = ["ground.D", "rocker.D"]
[initial]
A = {{ angle = "60 deg" }}
D = {{ guess = {{ angle = "100 deg" }} }}
[fit]
vary = {vary}
unknowns = {{ o1 = 0, o2 = 0 }}
drive = {{ "A.angle" = "phi + o1" }}
compare = {{ psi_measured = "D.angle - o2" }}
sigma = {{ psi_measured = 0.001 }}
"#
        )
    };
    let found = solved(&model(r#"["a", "b", "c"]"#), &[data(&fixture)]);
    agrees(&found, &fixture, &["a", "b", "c", "o1", "o2"], [1e-6, 1e-6]);

    // With the ground as well only ratios are seen.
    let found = solved(&model(r#"["a", "b", "c", "d"]"#), &[data(&fixture)]);
    assert_eq!(found.open.rank, 5);
    assert_eq!(found.open.unidentifiable_together, [["a", "b", "c", "d"]]);
    let null = &found.open.null_vectors[0];
    for (name, length) in null {
        let part = length / of(&found, name).estimate;
        let first = null["a"] / of(&found, "a").estimate;
        assert!((part - first).abs() < 1e-6 * first.abs(), "{name}: one common factor, {null:?}");
    }
}

#[test]
fn a_formula_of_columns_is_fitted_without_a_motion() {
    let fixture = fixture(include_str!("../fixtures/id_drive.json"));
    let text = r#"
[parameters]
m = "1 kg"
c = "1 N*s/m"
k = "10 N/m"
Fc = "1 N"
F0 = "0 N"
[bodies.slide]
mass = "m"
[joints.S]
type = "prismatic"
between = ["ground", "slide"]
axis = [1, 0]
[fit]
vary = ["m", "c", "k", "Fc", "F0"]
compare = { F = "m*a + c*v + k*x + Fc*sign(v) + F0" }
sigma = { F = "0.15 N" }
"#;
    let found = solved(text, &[data(&fixture)]);
    agrees(&found, &fixture, &["m", "c", "k", "Fc", "F0"], [1e-7, 1e-8]);
    let s2 = fixture["values"]["s2"].as_f64().expect("a number") / 0.15 / 0.15;
    assert!((found.s2 - s2).abs() < 1e-8 * s2, "{} for {s2}", found.s2);
}

#[test]
fn bands_hold_what_is_measured_again() {
    // y = m·x + b with known noise: the classical variance of the fitted line.
    let text = "[parameters]\nm = 1.0\n[bodies.unused]\nmass = 1\n[joints.J]\ntype = \"revolute\"\nbetween = [\"ground\", \"unused\"]\n\
        [fit]\nvary = [\"m\"]\nunknowns = { b = 0 }\ncompare = { y = \"m*x + b\" }\nsigma = { y = 0.2 }\n";
    let xs: Vec<f64> = (0..21).map(f64::from).collect();
    let rows = xs.iter().map(|x| format!("{x},{}\n", 2.0 * x + 1.0 + 0.2 * (7.0 * x).sin()));
    let table = format!("x,y\n{}", rows.collect::<String>());
    let file = DataFile { name: "line.csv".to_owned(), text: table, ..DataFile::default() };
    let found = solved(text, &[file]);
    let curve = &found.curves[0];
    // σ² (1/n + (x − x̄)²/Sxx); another measurement has σ² more.
    let sxx: f64 = xs.iter().map(|x| (x - 10.0).powi(2)).sum();
    for (k, x) in xs.iter().enumerate() {
        let variance = 0.04 * (1.0 / 21.0 + (x - 10.0).powi(2) / sxx);
        let [fitted, another] = [curve.standard_error[k], curve.prediction_error[k]];
        assert!((fitted - variance.sqrt()).abs() < 1e-9, "{fitted} at {x}");
        assert!((another - (variance + 0.04).sqrt()).abs() < 1e-9, "{another} at {x}");
    }
}

#[test]
fn true_values_are_within_their_errors_as_often_as_stated() {
    use rand::{RngExt, SeedableRng};
    let text = "[parameters]\nm = 1.0\nc = 1.0\nFc = 0.1\n[bodies.unused]\nmass = 1\n[joints.J]\ntype = \"revolute\"\nbetween = [\"ground\", \"unused\"]\n\
        [fit]\nvary = [\"m\", \"c\", \"Fc\"]\nunknowns = { off = 0 }\ncompare = { F = \"m*a + c*v + Fc*tanh(20*v) + off\" }\n";
    let truth = [("m", 1.7), ("c", 0.6), ("Fc", 0.35), ("off", -0.2)];
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(7);
    let mut normal = || {
        let (u, v) = (1.0 - rng.random::<f64>(), rng.random::<f64>());
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    };
    let mut n_within = [0; 4];
    for _ in 0..200 {
        let row = |t: f64, noise: f64| {
            let (v, a) = ((1.3 * t).sin() + 0.4 * (2.9 * t).cos(), 1.3 * (1.3 * t).cos());
            let force = 1.7 * a + 0.6 * v + 0.35 * (20.0 * v).tanh() - 0.2 + 0.3 * noise;
            format!("{v},{a},{force}\n")
        };
        let rows: String = (0..40).map(|k| row(0.2 * f64::from(k), normal())).collect();
        let text_of = format!("v,a,F\n{rows}");
        let file = DataFile { name: "run.csv".to_owned(), text: text_of, ..DataFile::default() };
        let found = solved(text, &[file]);
        for (n, (name, exact)) in n_within.iter_mut().zip(truth) {
            let unknown = of(&found, name);
            let error = unknown.standard_error.expect("found");
            // Student's 95 % for 36 degrees of freedom.
            *n += i32::from((unknown.estimate - exact).abs() < 2.028 * error);
        }
    }
    // 190 of 200 by three of their standard deviations.
    assert!(n_within.iter().all(|n| (180..=199).contains(n)), "{n_within:?}");
}

/// A pendulum measured in degrees: with the unit in the heading, without it, and with radians as they are.
#[test]
fn columns_of_degrees_without_unit_are_warned_of() {
    let warnings = |heading: &str, size: f64| {
        let mut text = format!("t [s], {heading}\n");
        for k in 0..20 {
            let t = 0.05 * f64::from(k);
            let _ = writeln!(text, "{t}, {}", size * (3.0 * t).cos());
        }
        let file = DataFile { name: "swing.csv".to_owned(), text, ..DataFile::default() };
        let found = solved(&PENDULUM.replace("1 rad\"", "0.3 rad\""), &[file]);
        found.warnings.iter().map(|w| (w.code.0, w.message.clone())).collect::<Vec<_>>()
    };
    let said = "`theta_measured` of `swing.csv` goes as far as 20 rad = 3.2 turns";
    assert_eq!(warnings("theta_measured", 20.0), [("M034", said.to_owned())]);
    for (heading, size) in
        [("theta_measured [deg]", 20.0), ("theta_measured [rad]", 20.0), ("theta_measured", 0.35)]
    {
        assert_eq!(warnings(heading, size), [], "{heading}");
    }
}
