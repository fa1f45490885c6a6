//! Belts and chains around any number of wheels: against a reference, hand statics and the belt of two wheels.

use crate::support::{Within, at, close, coordinate, derive, model, path, signal, solve};
use bksim::Mechanism;
use serde_json::Value;

/// A belt of 1.608 m over two pulleys, whose centres go from 0.5 m to 0.52 m apart, and an idler on a slide.
const IDLER: &str = r#"
[ground]
points = { O = [0, 0], S = ["0.25 m", 0] }
[bodies.small]
mass = "1 kg"
inertia = "1e-3 kg m^2"
[bodies.carriage]
mass = "1 kg"
points = { P = [0, 0] }
[bodies.large]
mass = "2 kg"
inertia = "1e-2 kg m^2"
[bodies.slide]
mass = "0.2 kg"
points = { P = [0, 0] }
[bodies.roller]
mass = "0.3 kg"
inertia = "1e-4 kg m^2"
[joints.A]
type = "revolute"
between = ["ground.O", "small"]
[joints.way]
type = "prismatic"
between = ["ground.O", "carriage.P"]
axis = [1, 0]
[joints.B]
type = "revolute"
between = ["carriage.P", "large"]
[joints.guide]
type = "prismatic"
between = ["ground.S", "slide.P"]
axis = [0, 1]
[joints.I]
type = "revolute"
between = ["slide.P", "roller"]
[couplings.belt]
type = "belt"
between = ["A", "B", "I"]
radii = ["50 mm", "120 mm", "30 mm"]
turns = ["left", "left", "right"]
length = "1.608 m"
[drives.apart]
joint = "way"
motion = "0.5 m + 0.02 m/s*t"
[initial]
guide = { guess = { position = "-10 mm" } }
[solve]
t_end = "1 s"
every = "0.05 s"
rtol = 1e-11
atol = 1e-13
"#;

#[test]
fn a_belt_with_an_idler_lies_as_the_reference_says() {
    let file = path("tests/data/elements/belt_idler.json");
    let text = std::fs::read_to_string(file).expect("a reference");
    let reference: Value = serde_json::from_str(&text).expect("a reference is JSON");
    let mechanism = derive(model(IDLER));
    // Where the wheels stand in their turn is nobody's guess.
    let start = mechanism.start().unwrap_or_else(|e| panic!("{e}"));
    assert!(start.rivals.is_empty(), "{:?}", start.rivals);
    let motion = solve(&mechanism);
    let within = Within { relative: 1e-12, absolute: 1e-12 };
    for (k, row) in reference["rows"].as_array().expect("rows").iter().enumerate() {
        let number = |column: usize| row[column].as_f64().expect("a number");
        #[expect(clippy::cast_precision_loss, reason = "there are 21 rows")]
        let t = 0.05 * k as f64;
        let guide = at(&motion, t).q[coordinate(&mechanism, "guide_position")];
        close(&format!("y at {t} s"), guide, number(1), within);
        let columns = [
            "belt_wrap_A",
            "belt_wrap_B",
            "belt_wrap_I",
            "belt_strand_A_B",
            "belt_strand_I_A",
            "belt_strand_B_I",
        ];
        for (idx, name) in columns.iter().enumerate() {
            let found = signal(&mechanism, at(&motion, t), name);
            close(&format!("{name} at {t} s"), found, number(idx + 2), within);
        }
        let length = signal(&mechanism, at(&motion, t), "belt_length");
        close("the length", length, 1.608, Within { relative: 1e-13, absolute: 0.0 });
    }
}

/// Two pulleys of 60 mm, 500 mm apart, and a roller of 30 mm in the middle of the upper strand that a weight
/// presses down. `idler` says more of the belt.
fn pressed(belt: &str, more: &str) -> String {
    format!(
        r#"
[ground]
points = {{ O = [0, 0], S = ["0.25 m", 0], P = ["0.5 m", 0] }}
[bodies.first]
mass = "1 kg"
inertia = "2e-3 kg m^2"
[bodies.second]
mass = "1 kg"
inertia = "5e-3 kg m^2"
[bodies.slide]
mass = "4 kg"
points = {{ P = [0, 0] }}
[bodies.roller]
mass = "1 kg"
inertia = "1e-4 kg m^2"
[joints.A]
type = "revolute"
between = ["ground.O", "first"]
[joints.B]
type = "revolute"
between = ["ground.P", "second"]
[joints.guide]
type = "prismatic"
between = ["ground.S", "slide.P"]
axis = [0, 1]
[joints.I]
type = "revolute"
between = ["slide.P", "roller"]
[couplings.belt]
type = "belt"
between = ["A", "B", "I"]
radii = ["60 mm", "60 mm", "30 mm"]
turns = ["left", "left", "right"]
{belt}
[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]
{more}
[initial]
guide = {{ guess = {{ position = "50 mm" }} }}
[solve]
t_end = "1 s"
rtol = 1e-11
atol = 1e-12
"#
    )
}

/// Inclination of the strands to the roller whose centre is at the height y: half of its wrap.
fn inclination(y: f64) -> f64 {
    let distance = 0.25_f64.hypot(y);
    (0.09 / distance).asin() - (y / 0.25).atan()
}

#[test]
fn a_weight_on_the_belt_gives_the_tension_of_the_triangle_of_forces() {
    let mechanism = derive(model(&pressed("length = \"1.39 m\"", "")));
    let motion = solve(&mechanism);
    let last = motion.samples.last().expect("samples");
    let y = last.q[coordinate(&mechanism, "guide_position")];
    let angle = inclination(y);
    let wrap = signal(&mechanism, at(&motion, 1.0), "belt_wrap_I");
    let within = Within { relative: 1e-9, absolute: 0.0 };
    close("the wrap", wrap, 2.0 * angle, within);
    let tension = 5.0 * 9.81 / (2.0 * angle.sin());
    let multipliers = mechanism.system.constraints.iter().zip(&last.lambda);
    let tensions: Vec<f64> =
        multipliers.filter(|(row, _)| row.direction == "coupling").map(|(_, l)| *l).collect();
    assert_eq!(tensions.len(), 3);
    for (k, found) in tensions.into_iter().enumerate() {
        close(&format!("tension {k}"), found, tension, within);
    }
}

#[test]
fn strands_bear_what_the_wheels_after_them_take() {
    // The roller is held, so that the belt is as long as its way; nothing fixes its first tension.
    let held = "[drives.hold]\njoint = \"guide\"\nmotion = \"50 mm\"\n\
                [loads.motor]\ntype = \"torque\"\njoint = \"A\"\nvalue = \"-3 N m\"";
    let text =
        pressed("", held).replace("[initial]\nguide = { guess = { position = \"50 mm\" } }", "");
    // Its centre must not move as far as the belt can know.
    let text =
        text.replace("[joints.guide]\ntype = \"prismatic\"", "[joints.guide]\ntype = \"weld\"");
    let text = text
        .replace("axis = [0, 1]\n", "")
        .replace("[drives.hold]\njoint = \"guide\"\nmotion = \"50 mm\"\n", "");
    let text = text.replace("S = [\"0.25 m\", 0]", "S = [\"0.25 m\", \"50 mm\"]");
    let mechanism = derive(model(&text));
    let motion = solve(&mechanism);
    let sample = at(&motion, 0.5);
    let (r, roller) = (0.06_f64, 0.03_f64);
    let inertia = 2e-3 / (r * r) + 5e-3 / (r * r) + 1e-4 / (roller * roller);
    let belt = -3.0 / r / inertia;
    let within = Within { relative: 1e-10, absolute: 1e-10 };
    for (name, radius) in [("A_angle", r), ("B_angle", r), ("I_angle", -roller)] {
        let found = sample.a[coordinate(&mechanism, name)];
        close(name, found, belt / radius, within);
    }
    // Against the last strand, which leads from the roller to A.
    let couplings = mechanism.system.constraints.iter().zip(&sample.lambda);
    let tensions: Vec<f64> =
        couplings.filter(|(row, _)| row.direction == "coupling").map(|(_, l)| *l).collect();
    let after_b = -1e-4 / (roller * roller) * belt;
    let expected = [after_b - 5e-3 / (r * r) * belt, after_b];
    assert_eq!(tensions.len(), 2, "{tensions:?}");
    for (k, (found, expected)) in tensions.into_iter().zip(expected).enumerate() {
        close(&format!("tension {k}"), found, expected, within);
    }
}

#[test]
fn a_belt_that_stretches_swings_with_the_frequency_of_its_strands() {
    let text = r#"
[ground]
points = { O = [0, 0], P = ["0.5 m", 0] }
[bodies.first]
mass = "1 kg"
inertia = "2e-3 kg m^2"
[bodies.second]
mass = "1 kg"
inertia = "5e-3 kg m^2"
[joints.A]
type = "revolute"
between = ["ground.O", "first"]
[joints.B]
type = "revolute"
between = ["ground.P", "second"]
[parameters]
pi_length = "2*0.5 m*sqrt(1 - 0.0256*0.25) + (0.05 m + 0.09 m)*pi + 2*0.04 m*asin(0.08)"
[couplings.belt]
type = "belt"
between = ["A", "B"]
radii = ["50 mm", "90 mm"]
length = "pi_length - 2 mm"
stiffness = "2e4 N/m"
[initial]
A = { angle = 0, rate = "1 rad/s" }
B = { angle = 0, rate = 0 }
[solve]
t_end = "0.5 s"
rtol = 1e-11
atol = 1e-12
"#;
    let mechanism = derive(model(text));
    let motion = solve(&mechanism);
    let (a, b) = (coordinate(&mechanism, "A_angle"), coordinate(&mechanism, "B_angle"));
    let stiffness = 2.0 * 2e4;
    let omega = (stiffness * (0.05_f64.powi(2) / 2e-3 + 0.09_f64.powi(2) / 5e-3)).sqrt();
    for sample in &motion.samples {
        let slip = 0.05 * sample.q[a] - 0.09 * sample.q[b];
        let expected = 0.05 / omega * (omega * sample.t).sin();
        close(
            &format!("slip at {} s", sample.t),
            slip,
            expected,
            Within { relative: 0.0, absolute: 1e-10 },
        );
    }
    // The free length is 2 mm less than the way: one millimetre a strand, and what the wheels add.
    let sum = ["belt_tension_A_B", "belt_tension_B_A"]
        .map(|name| signal(&mechanism, at(&motion, 0.25), name));
    let way = signal(&mechanism, at(&motion, 0.25), "belt_length");
    let free = way - (sum[0] + sum[1]) / 2e4;
    let expected = 2.0 * 0.5 * (1.0_f64 - 0.0064).sqrt()
        + 0.14 * std::f64::consts::PI
        + 0.08 * 0.08_f64.asin()
        - 0.002;
    close("the length without load", free, expected, Within { relative: 1e-12, absolute: 0.0 });
}

/// A belt of two wheels by its strands moves as the belt of two wheels does.
#[test]
fn strands_of_two_wheels_are_the_belt_of_two_wheels() {
    let text = |belt: &str| {
        format!(
            r#"
[ground]
points = {{ O = [0, 0], P = ["0.5 m", "0.1 m"] }}
[bodies.first]
mass = "1 kg"
inertia = "2e-3 kg m^2"
[bodies.second]
mass = "1 kg"
inertia = "5e-3 kg m^2"
com = ["20 mm", 0]
[joints.A]
type = "revolute"
between = ["ground.O", "first"]
[joints.B]
type = "revolute"
between = ["ground.P", "second"]
[couplings.belt]
type = "belt"
between = ["A", "B"]
radii = ["50 mm", "90 mm"]
{belt}
[loads.gravity]
type = "gravity"
acceleration = [0, "-9.81 m/s^2"]
[solve]
t_end = "2 s"
rtol = 1e-10
atol = 1e-10
"#
        )
    };
    for [strands, pair] in
        [["turns = [\"left\", \"left\"]", ""], ["turns = [\"left\", \"right\"]", "crossed = true"]]
    {
        let mechanisms = [strands, pair].map(|belt| derive(model(&text(belt))));
        let motions = [&mechanisms[0], &mechanisms[1]].map(solve);
        for t in [0.5, 1.0, 2.0] {
            let angles =
                [0, 1].map(|k: usize| at(&motions[k], t).q[coordinate(&mechanisms[k], "B_angle")]);
            close(
                &format!("B at {t} s"),
                angles[0],
                angles[1],
                Within { relative: 1e-8, absolute: 1e-8 },
            );
        }
    }
}

#[test]
fn a_belt_that_does_not_fit_is_refused_with_what_would() {
    let refused = |text: &str| {
        let error = Mechanism::derive(model(text), Vec::new()).expect_err("a fault");
        let line = |d: &bksim::model::diagnostic::Diagnostic| {
            format!("[{}] {}; {}", d.code.0, d.message, d.help.as_deref().unwrap_or_default())
        };
        error.0.iter().map(line).collect::<Vec<_>>().join("; ")
    };
    let moves = refused(&pressed("", ""));
    assert!(moves.starts_with("[S024] belt `belt` has no length, but its wheels move"), "{moves}");
    // What it suggests is the way at the start.
    let (_, suggested) = moves.split_once("length = \"").expect("a length");
    let (suggested, _) = suggested.split_once(" m\"").expect("in metres");
    let motion = solve(&derive(model(&pressed(&format!("length = \"{suggested} m\""), ""))));
    close("y", motion.samples[0].q[2], 0.05, Within { relative: 1e-9, absolute: 0.0 });

    let near = refused(
        &pressed("length = \"1 m\"", "")
            .replace("P = [\"0.5 m\", 0]", "P = [\"0.26 m\", \"10 mm\"]"),
    );
    assert!(
        near.starts_with("[S024] belt `belt` has no way from the wheel of `B` to that of `I`"),
        "{near}"
    );
    let spatial = format!("space = \"spatial\"\n{}", pressed("length = \"1.4 m\"", ""));
    let spatial = refused(&spatial);
    assert!(spatial.starts_with("[S024] belt `belt` goes around its wheels in space"), "{spatial}");
    let winds = refused(
        &pressed("length = \"1 m\"", "")
            .replace("[\"left\", \"left\", \"right\"]", "[\"right\", \"right\", \"right\"]"),
    );
    assert!(winds.starts_with("[S024] belt `belt` winds"), "{winds}");
}
