//! Gradients of one number of a run, against differences of runs.

use crate::support::model;
use bksim_analysis::{AnalysisError, GoalTake, GradientRequest, MotionGradient, Watch, gradient};
use bksim_model::Model;
use bksim_sim::Mechanism;
use bksim_sim::run::Sample;

const SLIDER_CRANK: &str = include_str!("../../../../examples/slider-crank/model.toml");

/// A second of it at a fine tolerance.
fn slider_crank(text: &str) -> Model {
    let mut model = model(text);
    let solve = &mut model.solve;
    (solve.rtol, solve.atol) = (1e-11, 1e-11);
    (solve.t_end, solve.every) = (1.0, Some(0.02));
    model
}

fn asked(
    model: Model,
    (of, take): (&str, GoalTake),
    by: &[&str],
) -> Result<MotionGradient, AnalysisError> {
    let by = by.iter().map(|&name| name.to_owned()).collect();
    let request = GradientRequest { of: of.to_owned(), take, by };
    Ok(gradient(model, &request, Watch::NONE)?.expect("nobody stops it"))
}

/// A quantity of a sample.
type Value = fn(&Mechanism, &Sample) -> f64;

/// The numbers of the run of a text.
fn numbers(text: &str, value: Value, takes: &[GoalTake]) -> Vec<f64> {
    let mechanism = Mechanism::derive(slider_crank(text), Vec::new()).expect("a mechanism");
    let samples = mechanism.solve().expect("a run").samples;
    let values: Vec<f64> = samples.iter().map(|sample| value(&mechanism, sample)).collect();
    let span = samples[samples.len() - 1].t - samples[0].t;
    let mean = |of: fn(f64) -> f64| {
        let pairs = samples.windows(2).zip(values.windows(2));
        let areas = pairs.map(|(s, h)| 0.5 * (s[1].t - s[0].t) * (of(h[0]) + of(h[1])));
        areas.sum::<f64>() / span
    };
    let number = |take: &GoalTake| match take {
        GoalTake::Last => values[values.len() - 1],
        GoalTake::Mean => mean(|h| h),
        GoalTake::Rms => mean(|h| h * h).sqrt(),
        GoalTake::Max => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        GoalTake::Min => values.iter().copied().fold(f64::INFINITY, f64::min),
    };
    takes.iter().map(number).collect()
}

/// A quantity: how it is written, its value, and how another value is written.
const VARIED: [(&str, &str, f64, &str); 3] = [
    ("l1", "l1 = \"1 m\"", 1.0, "l1 = \"# m\""),
    ("q1", "q1 = \"55 N m\"", 55.0, "q1 = \"# N m\""),
    ("A.rate", "A = { angle = 0, rate = 0 }", 0.0, "A = { angle = 0, rate = # }"),
];

/// Compares derivatives with differences of fourth order.
fn agree(of: &str, value: Value, takes: &[GoalTake]) {
    let plain = numbers(SLIDER_CRANK, value, takes);
    let slopes = VARIED.map(|(_, written, at, with)| {
        assert_eq!(SLIDER_CRANK.matches(written).count(), 1, "{written}");
        let h = 1e-3 * f64::max(at, 1.0);
        let run = |at: f64| {
            let line = with.replace('#', &format!("{at:?}"));
            numbers(&SLIDER_CRANK.replace(written, &line), value, takes)
        };
        let [a, b, c, d] = [at - 2.0 * h, at - h, at + h, at + 2.0 * h].map(run);
        let slope = |k: usize| (a[k] - 8.0 * b[k] + 8.0 * c[k] - d[k]) / (12.0 * h);
        (0..takes.len()).map(slope).collect::<Vec<f64>>()
    });
    for (k, &take) in takes.iter().enumerate() {
        let names = VARIED.map(|(name, ..)| name);
        let found = asked(slider_crank(SLIDER_CRANK), (of, take), &names).expect("a gradient");
        let size = plain[k].abs().max(1.0);
        assert!((found.value - plain[k]).abs() < 1e-12 * size, "{of} {take:?}: {}", found.value);
        assert!(found.left_out.is_empty() && found.n_steps > 0);
        for (((name, _, at, _), slopes), one) in VARIED.iter().zip(&slopes).zip(&found.by) {
            assert_eq!(one.by.name, *name);
            assert!((one.value - at).abs() < 1e-12, "{name} is {}", one.value);
            let (off, slope) = ((one.derivative - slopes[k]).abs(), slopes[k]);
            let within = 2e-6 * (slope.abs() + size / at.max(1.0));
            assert!(off < within, "{of} {take:?} by {name}: {} for {slope}", one.derivative);
        }
    }
}

fn coordinate(mechanism: &Mechanism, sample: &Sample, name: &str) -> f64 {
    let of = mechanism.compiled.coordinates.iter().position(|c| c.name == name);
    sample.q[of.expect("a coordinate")]
}

/// Of a crank that turns forward throughout, so that the first and the last sample are the smallest and the largest.
#[test]
fn coordinates_have_the_slopes_of_neighbouring_runs() {
    let all = [GoalTake::Last, GoalTake::Mean, GoalTake::Rms, GoalTake::Min];
    agree("x3", |m, sample| coordinate(m, sample, "x3"), &all);
    agree("state.theta1", |m, sample| coordinate(m, sample, "theta1"), &[GoalTake::Max]);
}

#[test]
fn energies_reactions_and_points_have_the_slopes_of_neighbouring_runs() {
    agree("energy.kinetic", |_, sample| sample.energy.kinetic, &[GoalTake::Last]);
    let reaction = |mechanism: &Mechanism, sample: &Sample| {
        let joint = mechanism.compiled.joints.iter().position(|name| name == "A");
        sample.reactions[joint.expect("the joint")][1]
    };
    agree("reactions.A.fy", reaction, &[GoalTake::Rms]);
    // What derivatives in a log have no column of.
    let force = |mechanism: &Mechanism, sample: &Sample| {
        let joint = mechanism.compiled.joints.iter().position(|name| name == "A");
        let [fx, fy, ..] = sample.reactions[joint.expect("the joint")];
        fx.hypot(fy)
    };
    agree("reactions.A.force", force, &[GoalTake::Mean]);
    let rate = |m: &Mechanism, sample: &Sample| {
        let of = m.compiled.coordinates.iter().position(|c| c.name == "theta1");
        sample.v[of.expect("a coordinate")]
    };
    agree("A.rate", rate, &[GoalTake::Last]);
    let point = |m: &Mechanism, sample: &Sample| {
        coordinate(m, sample, "y2") - 1.5 * coordinate(m, sample, "theta2").sin()
    };
    agree("rod.B.y", point, &[GoalTake::Mean]);
}

/// A block on two guides in one line, which part where `h` is not zero.
const GUIDES: &str = "[parameters]\nh = \"0 m\"\npush = \"3 N\"\n[ground.points]\nP = [0, \"h\"]\n\
    [bodies.block]\nmass = 2\ninertia = 1\n[joints]\n\
    S = { type = \"prismatic\", between = [\"ground\", \"block\"], axis = [1, 0] }\n\
    R = { type = \"prismatic\", between = [\"ground.P\", \"block\"], axis = [1, 0] }\n\
    [loads]\nf = { type = \"force\", on = \"block\", vector = [\"push\", 0] }\n\
    [initial]\nS = { velocity = \"4 m/s\" }\n[solve]\nt_end = 1\n";

/// T = (4 + 3 t/2)² at the end, of a mass of 2 kg.
#[test]
fn quantities_without_neighbours_are_left_out_unless_they_are_named() {
    let found = asked(model(GUIDES), ("energy.kinetic", GoalTake::Last), &[]).expect("a gradient");
    assert!((found.value - 30.25).abs() < 1e-6, "{}", found.value);
    let left_out: Vec<&str> = found.left_out.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(left_out, ["h"]);
    let by: Vec<(&str, &str)> =
        found.by.iter().map(|one| (one.by.name.as_str(), one.unit.as_str())).collect();
    assert_eq!(by, [("push", "J/N"), ("S.velocity", "J/(m/s)")]);
    for (one, expected) in found.by.iter().zip([5.5, 11.0]) {
        assert!((one.derivative - expected).abs() < 1e-5, "{one:?}");
    }
    let order: Vec<&str> = found.by_weight().iter().map(|one| one.by.name.as_str()).collect();
    assert_eq!(order, ["S.velocity", "push"], "44 J of the velocity, 16.5 J of the force");
    assert!(found.csv().starts_with("quantity,value,derivative,by_percent\npush,3,"));

    let refused = asked(model(GUIDES), ("energy.kinetic", GoalTake::Last), &["h"]);
    let fault = refused.expect_err("no neighbour").diagnostics().remove(0);
    assert_eq!(fault.code.0, "S012", "{fault:?}");
}

#[test]
fn names_and_numbers_without_a_derivative_are_refused() {
    let refuse = |of: &str, take: GoalTake| {
        let refused = asked(model(GUIDES), (of, take), &["push"]);
        let fault = refused.expect_err(of).diagnostics().remove(0);
        (fault.code.0, fault.help.unwrap_or_default())
    };
    let near = refuse("energy.kinetik", GoalTake::Last);
    assert_eq!(near, ("Q002", "did you mean `energy.kinetic`?".to_owned()));
    for unknown in ["energy.work", "solver.n_step", "S.nothing"] {
        assert_eq!(refuse(unknown, GoalTake::Mean).0, "Q002", "{unknown}");
    }
    assert_eq!(refuse("block_nothing", GoalTake::Rms).0, "Q002");
    // It has no potential: the root of the mean of its square is at its kink.
    assert_eq!(refuse("energy.potential", GoalTake::Rms).0, "S012");
}
