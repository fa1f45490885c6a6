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

/// A pendulum on a string of 1 m, with what the string meets below its fixed end.
fn pendulum(node: &str, keys: &str, x: f64, t_end: f64) -> String {
    format!(
        "[ground]\npoints = {{ O = [0, 0], P = [0, -0.5] }}\n\
         [bodies.bob]\nmass = 2\nfree = true\npoints = {{ C = [0, 0] }}\n\
         [couplings.string]\ntype = \"rope\"\nover = [\"ground.O\", {{ pulley = \"ground.P\", {node} }}, \"bob.C\"]\n\
         {keys}\n[loads.gravity]\ntype = \"gravity\"\nacceleration = [0, -9.81]\n\
         [initial]\nbob = {{ x = {x}, y = {}, vx = 0, vy = 0 }}\n\
         [outputs]\nx = \"bob.x\"\ny = \"bob.y\"\npull = \"couplings.string\"\n\
         [solve]\nt_end = {t_end}\nevery = {}\nrtol = 1e-11\natol = 1e-12\n",
        -(1.0 - x * x).sqrt(),
        t_end / 100.0
    )
}

/// Period of a pendulum that swings to this angle, s, by the arithmetic-geometric mean.
fn period(length: f64, angle: f64) -> f64 {
    let (mut a, mut b) = (1.0, (angle / 2.0).cos());
    for _ in 0..20 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    std::f64::consts::TAU * (length / 9.81).sqrt() / a
}

/// Galileo's pendulum: its string meets a peg, swings on at half its length to the same height, and comes back; from above
/// the peg it turns by more than half a turn.
#[test]
fn a_string_meets_a_peg_and_leaves_it_again() {
    let eye = "radius = 0, turn = \"left\", leaves = true";
    let within = Within { relative: 0.0, absolute: 2e-8 };
    for (degrees, keys) in [(40.0_f64, ""), (40.0, "slack = true"), (63.0, "")] {
        let angle = degrees.to_radians();
        let rise = 1.0 - angle.cos();
        let above = (1.0 - 2.0 * rise).acos();
        let whole = 0.5 * (period(1.0, angle) + period(0.5, above));
        let mechanism = derive(model(&pendulum(eye, keys, -angle.sin(), whole)));
        let motion = solve(&mechanism);
        let end = motion.samples.last().expect("a sample");
        close("x", signal(&mechanism, end, "x"), -angle.sin(), within);
        close("y", signal(&mechanism, end, "y"), -angle.cos(), within);
        // From side to side it takes half of both periods.
        let there = pendulum(eye, keys, -angle.sin(), 0.5 * whole);
        let mechanism = derive(model(&there));
        let motion = solve(&mechanism);
        let end = motion.samples.last().expect("a sample");
        close("x", signal(&mechanism, end, "x"), 0.5 * above.sin(), within);
        close("y", signal(&mechanism, end, "y"), -0.5 - 0.5 * above.cos(), within);
        close("pull", signal(&mechanism, end, "pull"), 2.0 * 9.81 * above.cos(), within);
        assert!(motion.summary.energy.worst_error < 1e-9, "{}", motion.summary.energy.worst_error);
    }
}

/// Around a post of some size: as long as it is wound on as the string that is held to it, beside it straight.
#[test]
fn a_string_leaves_a_round_post_where_it_is_straight() {
    for (turn, x) in [("left", 0.6), ("right", -0.6)] {
        let post = |leaves: &str| {
            let node = format!("radius = 0.02, turn = \"{turn}\"{leaves}");
            let mechanism = derive(model(&pendulum(&node, "", x, 2.0)));
            let motion = solve(&mechanism);
            let all: Vec<[f64; 2]> = (motion.samples.iter())
                .map(|sample| ["x", "y"].map(|name| signal(&mechanism, sample, name)))
                .collect();
            (all, motion.summary.left.map(|(t, _)| t))
        };
        let (held, left) = post("");
        let (free, none) = post(", leaves = true");
        let left = left.expect("it would leave");
        assert_eq!(none, None);
        // Straight from the eye to the bob it is as long as the tangents and the arc were at the start.
        let sine: f64 = 0.02 / 0.5;
        let [dx, dy] = [0.6, 0.5 - 0.8];
        let far = f64::hypot(dx, dy);
        let directions = [sine.asin(), (dx / -dy).atan() + (0.02_f64 / far).asin()];
        let length = (0.25_f64 - 0.0004).sqrt()
            + (far * far - 0.0004).sqrt()
            + 0.02 * (directions[1] + directions[0]);
        let (mut around, mut beside) = (0, 0);
        for (k, ([hx, hy], [x, y])) in held.iter().zip(&free).enumerate() {
            let t = 0.02 * f64::from(u8::try_from(k).expect("100 samples"));
            if t < left - 0.02 {
                close("as held", *x, *hx, Within { relative: 0.0, absolute: 1e-8 });
                close("as held", *y, *hy, Within { relative: 0.0, absolute: 1e-8 });
                around += 1;
            } else if t > left + 0.02 && t < left + 0.5 {
                close("straight", x.hypot(*y), length, Within { relative: 0.0, absolute: 1e-8 });
                beside += 1;
            }
        }
        assert!(around > 10 && beside > 10, "{around}, {beside}");
    }
}
