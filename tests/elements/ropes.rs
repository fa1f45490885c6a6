//! Ropes over pulleys, drums and posts against reference motions: taut, elastic, and slack at times.

use crate::support::elements::{check_outputs, touch_text};
use crate::support::{Within, at, close, derive, model, signal, solve, with_method};
use bksim::sim::hybrid::ChangeKind;
use serde_json::Value;

/// Compares all rows of a reference.
fn check(fixture: &str, data: &str, columns: &[&str]) {
    check_outputs(&touch_text(fixture), data, &|_| true, columns);
}

#[test]
fn a_string_that_winds_on_a_post_moves_as_the_reference_does() {
    check("post", "post_pendulum", &["x", "y", "vx", "vy", "T"]);
}

#[test]
fn a_pulley_that_hangs_on_a_spring_bears_both_pulls() {
    let columns = ["z", "x1", "vz", "w", "T1", "T2", "rope_on_axle"];
    check("hung-pulley", "atwood_hung", &columns);
}

#[test]
fn every_strand_of_a_tackle_has_its_pull() {
    for n in [2_u8, 3, 4] {
        let strands: Vec<String> = (1..=n).map(|k| format!("T{k}")).collect();
        let mut columns = vec!["y", "v", "a", "w_last", "F"];
        columns.extend(strands.iter().map(String::as_str));
        let is_meant = |row: &Value| row[0].as_u64() == Some(u64::from(n));
        check_outputs(&touch_text(&format!("tackle-{n}")), "tackle", &is_meant, &columns);
    }
}

#[test]
fn a_rope_that_jerks_taut_lifts_the_mass_again() {
    check("rope-jerks", "atwood_jerk", &["x1", "x2", "v1", "v2", "T"]);
}

#[test]
fn a_hoist_that_stops_too_fast_drops_its_load_into_the_rope() {
    // At 0.5 s the pull jumps.
    check("hoist", "hoist_slack", &["x", "v"]);
    let is_meant = |row: &Value| row[0].as_f64() != Some(0.5);
    check_outputs(&touch_text("hoist"), "hoist_slack", &is_meant, &["T"]);
}

#[test]
fn a_rope_that_is_wound_up_gets_stiffer() {
    check("winding", "rope_winding_elastic", &["y", "v", "T"]);
}

#[test]
fn a_rope_slips_on_a_turning_drum_grips_and_slips_again() {
    // At 1.6173 s the rope comes to rest on the drum, which stands: it grips, as 117.72 N/98.1 N is below exp(mu pi). The
    // rows after that go on as if it still slipped forward.
    let columns = ["x", "v", "phi", "w", "T1", "T2", "slip"];
    let is_meant = |row: &Value| row[0].as_f64() <= Some(1.6);
    check_outputs(&touch_text("capstan"), "capstan_drum", &is_meant, &columns);
    let mechanism = derive(model(&touch_text("capstan")));
    let motion = solve(&mechanism);
    for (output, expected) in [("v", 0.0), ("slip", 0.0), ("T1", 12.0 * 9.81), ("T2", 98.1)] {
        let found = signal(&mechanism, at(&motion, 1.8), output);
        assert!((found - expected).abs() < 1e-9, "{output}: {found}");
    }
    let expected = (1.2_f64).ln() / (0.15 * std::f64::consts::PI);
    let grip = signal(&mechanism, at(&motion, 1.8), "rope_1_grip");
    assert!((grip - expected).abs() < 1e-12, "{grip} for {expected}");
    // Grips, slips again, the drum stands, and the rope on it.
    let reference = crate::support::elements::reference("touch/capstan_drum");
    let times = ["t_grip", "t_slip_again", "t_drum_stands"];
    let changes = motion.summary.changes.iter();
    let changes = changes.filter(|change| !matches!(change.kind, ChangeKind::Kink(_)));
    for (name, change) in times.into_iter().zip(changes) {
        let expected = reference["values"][name].as_f64().expect("a time");
        assert!((change.t - expected).abs() < 1e-9, "{name}: {} for {expected}", change.t);
    }
}

/// Two masses on a rope without friction over a post, as a constraint, as a stiff spring and by hand.
const MASSES: &str = r#"
[ground]
points = { P = [0, "2 m"], A = ["-0.1 m", 0], B = ["0.1 m", 0] }
[bodies.m1]
mass = "3 kg"
points = { hook = [0, 0] }
[bodies.m2]
mass = "2 kg"
points = { hook = [0, 0] }
[joints.guide1]
type = "prismatic"
between = ["ground.A", "m1.hook"]
axis = [0, 1]
[joints.guide2]
type = "prismatic"
between = ["ground.B", "m2.hook"]
axis = [0, 1]
[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]
[couplings.rope]
type = "rope"
over = ["m1.hook", { pulley = "ground.P", radius = "0.1 m", turn = "right" }, "m2.hook"]
[initial]
guide1 = { position = 0, velocity = 0 }
[solve]
t_end = "0.5 s"
every = "0.1 s"
rtol = 1e-10
"#;

#[test]
fn a_rope_is_the_same_as_constraint_as_spring_and_by_hand() {
    let (g, pull) = (9.81, 2.0 * 3.0 * 2.0 * 9.81 / 5.0);
    let within = Within { relative: 1e-9, absolute: 1e-11 };
    for method in ["explicit", "radau"] {
        let mechanism = derive(model(&with_method(MASSES, method)));
        let motion = solve(&mechanism);
        let end = at(&motion, 0.5);
        close("fall", end.q[0], -0.5 * g / 5.0 * 0.25, within);
        let row = mechanism.system.constraints.len() - 1;
        close("pull", end.lambda[row], pull, within);
    }
    // Sliding over the post, the rope presses with twice its pull and nothing turns.
    let elastic = MASSES.replace(
        "type = \"rope\"",
        "type = \"rope\"\nEA = \"1000 MN\"\ndamping = \"40 kN s/m\"\nlength = \"(4 + 0.1*pi) m\"",
    );
    let elastic = elastic
        .replace("velocity = 0 }", "velocity = 0 }\nguide2 = { position = 0, velocity = 0 }");
    let mechanism = derive(model(&with_method(&elastic, "radau")));
    let motion = solve(&mechanism);
    let loose = Within { relative: 1e-4, absolute: 0.0 };
    close("fall on a stiff rope", at(&motion, 0.5).q[0], -0.5 * g / 5.0 * 0.25, loose);
    close("pull of a stiff rope", signal(&mechanism, at(&motion, 0.5), "rope_pull"), pull, loose);
}
