//! Sensitivities of motions: a closed form, differences of tight runs, and what does not exist.

use crate::support::{
    Within, all_close, brief, coordinate, derive, example_text, fitted_order, model, weighted_error,
};
use bksim::log::{Log, Outcome};
use bksim::model::{Formulation, Method};
use bksim::record::{Contents, Recorder};
use bksim::sim::sensitivity::StateSensitivity;
use bksim::{Mechanism, Rejected, SensitivityMotion};

/// Tolerance, end and form of a run.
#[derive(Clone, Copy)]
struct Setting {
    rtol: f64,
    t_end: f64,
    every: f64,
    formulation: Formulation,
}

const TIGHT: Setting =
    Setting { rtol: 1e-11, t_end: 1.0, every: 0.1, formulation: Formulation::Ggl };

fn mechanism(text: &str, set: Setting) -> Mechanism {
    let mut model = model(text);
    let solve = &mut model.solve;
    (solve.rtol, solve.atol) = (set.rtol, set.rtol);
    (solve.t_end, solve.every) = (set.t_end, Some(set.every));
    (solve.method, solve.formulation) = (Method::Radau, set.formulation);
    derive(model)
}

fn sensitivities(text: &str, names: &[&str], set: Setting) -> Result<SensitivityMotion, Rejected> {
    let mechanism = mechanism(text, set);
    let by: Result<Vec<_>, _> = names.iter().map(|name| mechanism.sensitive(name)).collect();
    mechanism.simulation().expect("a simulation").sensitivities(&by?)
}

fn found(text: &str, names: &[&str], set: Setting) -> SensitivityMotion {
    sensitivities(text, names, set).unwrap_or_else(|e| panic!("{names:?}: {e}"))
}

/// A line of a model, and how it reads at a value.
struct Line {
    written: &'static str,
    at: fn(f64) -> String,
    value: f64,
    /// Half the distance of the two runs.
    h: f64,
}

/// q, v, a, λ at every output by central differences of two runs.
fn differences(text: &str, line: &Line, set: Setting) -> Vec<[Vec<f64>; 4]> {
    assert_eq!(text.matches(line.written).count(), 1, "{}", line.written);
    let run = |value: f64| {
        let text = text.replace(line.written, &(line.at)(value));
        let mechanism = mechanism(&text, set);
        let motion = mechanism.solve().unwrap_or_else(|e| panic!("{}: {e}", line.written));
        motion.samples.into_iter().map(|s| [s.q, s.v, s.a, s.lambda])
    };
    let slope = |(up, down): (&f64, &f64)| (up - down) / (2.0 * line.h);
    run(line.value + line.h)
        .zip(run(line.value - line.h))
        .map(|(up, down)| {
            std::array::from_fn(|k| up[k].iter().zip(&down[k]).map(slope).collect::<Vec<_>>())
        })
        .collect()
}

fn parts(s: &StateSensitivity) -> [&[f64]; 4] {
    [&s.q, &s.v, &s.a, &s.lambda]
}

/// Compares a sensitivity with differences: q, v to `relative` of the largest derivative of the run,
/// a and λ of theirs.
fn agree(text: &str, name: &str, line: &Line, set: Setting, relative: f64) {
    let motion = found(text, &[name], set);
    let expected = differences(text, line, set);
    assert_eq!(motion.sensitivities.len(), expected.len(), "{name}");
    for (k, what) in ["q", "v", "a", "lambda"].into_iter().enumerate() {
        let sizes = expected.iter().flat_map(|at| &at[k]).map(|value| value.abs());
        let size = sizes.fold(0.0, f64::max);
        assert!(k == 3 || size > 1e-3, "{name}: {what} does not depend on it");
        let within = Within { relative: 0.0, absolute: relative * size + 1e-9 };
        for (i, (by, expected)) in motion.sensitivities.iter().zip(&expected).enumerate() {
            let t = motion.motion.samples[i].t;
            let what = format!("{what} by {name} at t = {t}");
            all_close(&what, parts(&by[0])[k], &expected[k], within);
        }
    }
}

const PENDULUM: &str = include_str!("../fixtures/small-swing.toml");

/// φ = φ₀ cos ωt + φ̇₀/ω sin ωt with ω² = g/l, so ∂ω/∂l = −ω/(2l); exact up to φ₀².
#[test]
fn a_small_swing_has_the_sensitivities_of_its_closed_form() {
    let by = found(PENDULUM, &["l", "start", "A.angle", "A.rate"], TIGHT);
    let (l, start) = (0.7, 1e-4);
    let omega = (9.81f64 / l).sqrt();
    for (sample, by) in by.motion.samples.iter().zip(&by.sensitivities) {
        let (t, (sine, cosine)) = (sample.t, (omega * sample.t).sin_cos());
        let slope = start * omega / (2.0 * l);
        let expected = [
            [slope * t * sine, slope * (sine + omega * t * cosine)],
            [cosine, -omega * sine],
            [cosine, -omega * sine],
            [sine / omega, cosine],
        ];
        let sizes = [slope * omega * TIGHT.t_end, omega, omega, 1.0];
        for ((by, expected), size) in by.iter().zip(expected).zip(sizes) {
            let within = Within { relative: 0.0, absolute: 1e-7 * size };
            all_close("phi, rate", &[by.q[0], by.v[0]], &expected, within);
        }
    }
}

const LENGTH: Line = Line {
    written: "l1 = \"1 m\"",
    at: |value| format!("l1 = \"{value:?} m\""),
    value: 1.0,
    h: 1e-5,
};

const MASS: Line = Line {
    written: "m3 = \"20 kg\"",
    at: |value| format!("m3 = \"{value:?} kg\""),
    value: 20.0,
    h: 1e-3,
};

const RATE: Line = Line {
    written: "A = { angle = 0, rate = 0 }",
    at: |value| format!("A = {{ angle = 0, rate = \"{value:?} rad/s\" }}"),
    value: 0.0,
    h: 1e-5,
};

#[test]
fn the_slider_crank_agrees_with_differences_of_tight_runs() {
    let text = example_text("slider-crank");
    for (name, line) in [("l1", &LENGTH), ("m3", &MASS), ("A.rate", &RATE)] {
        agree(&text, name, line, TIGHT, 1e-6);
    }
}

/// A pendulum on a ball joint, which turns by a quaternion.
const BALL: &str = "space = \"spatial\"\n[parameters]\nm = \"1 kg\"\nlean = \"0.3 rad\"\n\
    [bodies.bob]\nmass = \"m\"\ninertia = [0.02, 0.03, 0.04]\ncom = [0, 0, -0.5]\n\
    [joints.ball]\ntype = \"spherical\"\nbetween = [\"ground\", \"bob\"]\n\
    [loads.g]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n\
    [initial]\nbob = { rpy = [\"lean\", 0.1, 0], wx_body = 0.4, wy_body = 5, wz_body = 0.2 }\n";

#[test]
fn a_quaternion_has_the_sensitivities_of_differences() {
    let mass =
        Line { written: "m = \"1 kg\"", at: |m| format!("m = \"{m:?} kg\""), value: 1.0, h: 1e-4 };
    let lean = Line {
        written: "lean = \"0.3 rad\"",
        at: |lean| format!("lean = \"{lean:?} rad\""),
        value: 0.3,
        h: 1e-5,
    };
    let spin = Line {
        written: "wy_body = 5",
        at: |spin| format!("wy_body = {spin:?}"),
        value: 5.0,
        h: 1e-4,
    };
    for (name, line) in [("m", &mass), ("lean", &lean), ("bob.wy_body", &spin)] {
        agree(BALL, name, line, TIGHT, 1e-6);
    }
}

#[test]
fn every_formulation_gives_the_same_sensitivities() {
    let text = example_text("slider-crank");
    for formulation in [Formulation::Index2, Formulation::Index3, Formulation::Index1] {
        let set = Setting { formulation, rtol: 1e-10, t_end: 0.5, ..TIGHT };
        agree(&text, "l1", &LENGTH, set, 1e-5);
    }
}

#[test]
fn the_driven_four_bar_agrees_with_differences_of_tight_runs() {
    let text = example_text("four-bar");
    let rocker = Line {
        written: "c = \"0.25 m\"",
        at: |value| format!("c = \"{value:?} m\""),
        value: 0.25,
        h: 1e-6,
    };
    let speed = Line {
        written: "speed = \"60 rpm\"",
        at: |value| format!("speed = \"{value:?} rad/s\""),
        value: 2.0 * std::f64::consts::PI,
        h: 1e-5,
    };
    for (name, line) in [("c", &rocker), ("speed", &speed)] {
        agree(&text, name, line, TIGHT, 1e-6);
    }
}

/// The third crank repeats what the first two impose; with common lengths all move together.
#[test]
fn redundant_joints_have_sensitivities_where_lengths_agree() {
    let text = example_text("parallelogram");
    let length = Line {
        written: "\nl = \"0.4 m\"",
        at: |value| format!("\nl = \"{value:?} m\""),
        value: 0.4,
        h: 1e-6,
    };
    let rate = Line {
        written: "A = { angle = \"-30 deg\", rate = 0 }",
        at: |value| format!("A = {{ angle = \"-30 deg\", rate = \"{value:?} rad/s\" }}"),
        value: 0.0,
        h: 1e-5,
    };
    let set = Setting { t_end: 0.2, every: 0.05, ..TIGHT };
    agree(&text, "l", &length, set, 1e-6);
    agree(&text, "A.rate", &rate, set, 1e-6);
}

/// Two pendulums in a chain; one number is stated about two rates.
const CHAIN: &str = include_str!("../fixtures/pendulum-chain.toml");

/// Velocities are the nearest to the guessed ones, and change as these do; l₂ follows l₁.
#[test]
fn open_velocities_change_as_the_nearest_ones() {
    let speed = Line {
        written: "vx = \"0.4 m/s\"",
        at: |value| format!("vx = \"{value:?} m/s\""),
        value: 0.4,
        h: 1e-5,
    };
    agree(CHAIN, "l1", &LENGTH, TIGHT, 1e-6);
    agree(CHAIN, "lower.vx", &speed, TIGHT, 1e-6);
}

/// A chain of equal links falls the same way whatever their mass: what is left of its derivatives is rounding, and costs
/// no more steps than others.
#[test]
fn what_moves_nothing_has_no_sensitivity() {
    let bodies = (0..3).map(|k| {
        format!(
            "[bodies.b{k}]\nmass = \"m\"\ninertia = \"m*l^2/12\"\ncom = [\"l/2\", 0]\npoints.B = [\"l\", 0]\n\
             [joints.j{k}]\ntype = \"revolute\"\nbetween = [\"{}\", \"b{k}\"]\n",
            if k == 0 { "ground".to_owned() } else { format!("b{}.B", k - 1) }
        )
    });
    let text = "[parameters]\nl = \"0.2 m\"\nm = \"0.1 kg\"\n[loads.gravity]\ntype = \"gravity\"\n\
                acceleration = [0, \"-9.81 m/s^2\"]\n"
        .to_owned()
        + &bodies.collect::<String>();
    for rtol in [1e-6, 1e-9] {
        let mut model = model(&text);
        (model.solve.rtol, model.solve.atol, model.solve.t_end) = (rtol, rtol, 0.5);
        let mechanism = derive(model);
        let by = [mechanism.sensitive("m").expect("a parameter")];
        let motion = mechanism.simulation().expect("a simulation").sensitivities(&by);
        let motion = motion.expect("a motion");
        let largest = motion.sensitivities.iter().flat_map(|by| &by[0].q);
        let largest = largest.fold(0.0, |largest: f64, x| largest.max(x.abs()));
        assert!(largest < 1e-9, "{largest:e} rad/kg at {rtol:e}");
    }
}

/// At every output the derivatives satisfy those of x₃ = l cos θ + √(L² − l² sin² θ), L = 3 m, and of
/// its rate, to rounding, whatever the tolerance.
#[test]
fn outputs_lie_on_the_linearised_constraints() {
    let set = Setting { rtol: 1e-4, t_end: 3.0, ..TIGHT };
    let text = example_text("slider-crank");
    let motion = found(&text, &["l1"], set);
    let mechanism = mechanism(&text, set);
    let [theta, slider] = ["theta1", "x3"].map(|name| coordinate(&mechanism, name));
    let (l, rod) = (1.0, 3.0);
    for (sample, by) in motion.motion.samples.iter().zip(&motion.sensitivities) {
        let (s, c) = sample.q[theta].sin_cos();
        let (rate, root) = (sample.v[theta], f64::sqrt(rod * rod - l * l * s * s));
        let by_theta = -l * s - l * l * s * c / root;
        let by_length = c - l * s * s / root;
        let by_both = -s - 2.0 * l * s * c / root - (l * s).powi(3) * c / root.powi(3);
        let twice =
            -l * c - l * l * (c * c - s * s) / root - (l * l * s * c).powi(2) / root.powi(3);
        let (dq, dv) = (by[0].q[theta], by[0].v[theta]);
        let expected = [by_theta * dq + by_length, (twice * dq + by_both) * rate + by_theta * dv];
        let within = Within { relative: 1e-12, absolute: 1e-12 };
        all_close("x3, rate", &[by[0].q[slider], by[0].v[slider]], &expected, within);
    }
}

/// ∂q and ∂v of the slider-crank at the end of a run.
fn at_end(set: Setting, step: Option<f64>) -> Vec<f64> {
    let mut mechanism = mechanism(&example_text("slider-crank"), set);
    mechanism.model.solve.step = step;
    mechanism.model.solve.newton_tolerance = 1e-13;
    let by = ["l1", "A.rate"].map(|name| mechanism.sensitive(name).expect("it is there"));
    let motion = mechanism
        .simulation()
        .expect("a simulation")
        .sensitivities(&by)
        .unwrap_or_else(|e| panic!("{e}"));
    let last = motion.sensitivities.last().expect("an end");
    last.iter().flat_map(|by| [&by.q[..], &by.v].concat()).collect()
}

/// Derivatives of a discrete solution of order 5 have order 5.
#[test]
fn sensitivities_of_fixed_steps_have_order_five() {
    let set = Setting { rtol: 1e-12, every: 1.0, ..TIGHT };
    let exact = at_end(set, None);
    let steps = [1.0 / 10.0, 1.0 / 20.0, 1.0 / 40.0, 1.0 / 80.0];
    let errors = steps.map(|h| weighted_error(&at_end(set, Some(h)), &exact));
    let order = fitted_order(&steps, &errors);
    assert!((4.6..5.4).contains(&order), "order {order:.2} from errors {}", brief(&errors));
}

/// Errors fall with the tolerance, as those of the motion do.
#[test]
fn sensitivities_converge_with_the_tolerance() {
    let set = Setting { t_end: 4.0, every: 4.0, ..TIGHT };
    let exact = at_end(Setting { rtol: 1e-12, ..set }, None);
    let tolerances = [1e-4, 1e-5, 1e-6, 1e-7, 1e-8];
    let errors =
        tolerances.map(|rtol| weighted_error(&at_end(Setting { rtol, ..set }, None), &exact));
    for (tolerance, error) in tolerances.into_iter().zip(errors) {
        assert!(error < 100.0 * tolerance, "{tolerance:e}: {}", brief(&errors));
    }
    let order = fitted_order(&tolerances, &errors);
    assert!((0.7..1.4).contains(&order), "order {order:.2} from errors {}", brief(&errors));
}

#[test]
fn the_log_holds_a_channel_for_each_quantity() {
    let mut model = model(&example_text("slider-crank"));
    (model.solve.t_end, model.solve.every) = (0.1, Some(0.05));
    let mechanism = derive(model);
    let by = ["m3", "A.rate"].map(|name| mechanism.sensitive(name).expect("it is there"));
    let simulation = mechanism.simulation().expect("a simulation");
    let motion = simulation.sensitivities(&by).unwrap_or_else(|e| panic!("{e}"));
    let start = &motion.motion.start;
    let contents = Contents { sensitive: &by, ..Contents::default() };
    let mut log = Recorder::create_with(Vec::new(), &simulation, "", start, &contents)
        .expect("a vector can be written");
    for (sample, by) in motion.motion.samples.iter().zip(&motion.sensitivities) {
        log.write(sample).expect("a vector can be written");
        log.write_sensitivities(sample.t, by).expect("a vector can be written");
    }
    let summary = &motion.motion.summary;
    let bytes = log.finish(summary, Outcome::ReachedEnd, "").expect("a vector can be written");

    let log = Log::read(&bytes[..]).expect("it was just written");
    for (k, (channel, units)) in [
        ("/sensitivity/m3", ["rad/kg", "m/kg"]),
        ("/sensitivity/A/rate", ["rad/(rad/s)", "m/(rad/s)"]),
    ]
    .into_iter()
    .enumerate()
    {
        let topic = log.header.topic_id(channel).unwrap_or_else(|| panic!("no {channel}"));
        let known = log.header.topics.iter().find(|known| known.name == channel);
        let fields = &known.expect("it has a handle").fields;
        assert_eq!([&fields[0].name, &fields[1].name], ["theta1", "x3"]);
        assert_eq!([&fields[0].unit, &fields[1].unit], units);
        assert_eq!(fields[5].name, "theta1_dot");
        let read = &log.series(topic).columns[5];
        let expected: Vec<f64> = motion.sensitivities.iter().map(|by| by[k].v[0]).collect();
        assert_eq!(read, &expected, "{channel}");
    }
}

#[test]
fn what_has_no_sensitivity_says_why() {
    let rejected = |text: &str, name: &str| {
        let error = sensitivities(text, &[name], TIGHT).expect_err("has none");
        assert_eq!(error.0[0].code.0, "S012", "{error}");
        error.to_string()
    };
    let crank = example_text("slider-crank");
    assert!(rejected(&crank, "l9").contains("no parameter or stated initial value `l9`"));
    assert!(rejected(&crank, "D.position").contains("is a guess"));
    // One crank of three alone cannot be longer.
    let cranks = example_text("parallelogram");
    let alone = cranks.replace("R = [\"l\", 0]", "R = [\"l3\", 0]");
    let alone = alone.replace("\nw = ", "\nl3 = \"0.4 m\"\nw = ");
    assert!(rejected(&alone, "l3").contains("no motion exists for any other value of `l3`"));
}

/// With the crank upright no velocity depends on the rod: dG/dl = l/√(l² − r² sin²θ) later on.
#[test]
fn a_crank_that_starts_upright_has_slopes_by_its_rod() {
    let text = r#"
[parameters]
r = "60 mm"
l = "200 mm"
[bodies.crank]
mass = 0
points = { B = ["r", 0] }
[bodies.rod]
mass = 0
points = { C = ["l", 0] }
[bodies.slider]
mass = "2 kg"
[joints]
A = { type = "revolute", between = ["ground", "crank"] }
B = { type = "revolute", between = ["crank.B", "rod"] }
C = { type = "revolute", between = ["rod.C", "slider"] }
G = { type = "prismatic", between = ["ground", "slider"], axis = [1, 0] }
[drives.motor]
joint = "A"
motion = "90 deg + 2 rad/s*t"
[initial]
G = { guess = { position = "190 mm" } }
"#;
    let by = found(text, &["l"], TIGHT);
    let position = coordinate(&mechanism(text, TIGHT), "G_position");
    for (sample, by) in by.motion.samples.iter().zip(&by.sensitivities) {
        let height = 0.06 * (2.0 * sample.t).cos();
        let expected = 0.2 / (0.04 - height * height).sqrt();
        let found = by[0].q[position];
        assert!((found - expected).abs() < 1e-8, "{found} for {expected} at {}", sample.t);
    }
}
