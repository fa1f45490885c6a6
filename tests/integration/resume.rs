//! A run that was stopped and goes on from its checkpoint equals the undisturbed one bit for bit.

use std::cell::Cell;

use crate::support::large::{Coordinates, windows};
use crate::support::{derive, model};
use bksim::Mechanism;
use bksim::dae::Control;
use bksim::model::{Formulation, Method, Outputs};
use bksim::sim::run::{Integrator, RunCheckpoint, Sample, Summary, Unfit, Unresumed};

/// A ball on a guide that falls onto a stop, a spring behind a gap, and a drive on the way.
const BOUNCING: &str = include_str!("../fixtures/bouncing-ball.toml");

/// The bits of everything that a sample says.
fn bits(sample: &Sample) -> Vec<u64> {
    let Sample { t, q, v, a, lambda, signals, reactions, energy, work, .. } = sample;
    let stats = sample.stats;
    let counters = [stats.n_step, stats.n_residual, stats.n_newton, stats.n_factor, stats.n_solve];
    let mut numbers = vec![*t, *work, sample.step_size, energy.kinetic, energy.potential];
    numbers.push(energy.power);
    for part in [q, v, a, lambda, signals] {
        numbers.extend(part);
    }
    numbers.extend(reactions.as_flattened());
    numbers.extend([sample.position_residual, sample.velocity_residual].concat());
    let numbers = numbers.into_iter().map(f64::to_bits);
    numbers.chain(counters.map(|n| n as u64)).collect()
}

/// A run, continued again and again as long as its observer stops it at every `period`th sample or
/// the caller after every `steps`th step; the samples that belong to it.
fn run_in_parts(
    mechanism: &Mechanism,
    period: usize,
    steps: usize,
) -> (Vec<Vec<u64>>, Summary, usize) {
    let simulation = mechanism.simulation().expect("equations");
    let start = mechanism.start().expect("a start");
    let mut samples: Vec<Vec<u64>> = Vec::new();
    let mut checkpoint: Option<RunCheckpoint> = None;
    let mut n_parts = 0;
    loop {
        n_parts += 1;
        let left = Cell::new(steps);
        let stop = || {
            left.set(left.get() - 1);
            left.get() == 0
        };
        let mut n_seen = 0;
        let mut keep = |sample: &Sample| {
            samples.push(bits(sample));
            n_seen += 1;
            if n_seen == period { Control::Stop } else { Control::Continue }
        };
        let summary = match &checkpoint {
            None => simulation.run(&start, &mut keep, &stop).expect("a run"),
            Some(from) => simulation.resume(&start, from, &mut keep, &stop).expect("a run"),
        };
        let Some(saved) = &summary.checkpoint else { return (samples, summary, n_parts) };
        assert!(!summary.reached_end);
        // Through bytes, as through a log.
        let read = RunCheckpoint::from_bytes(&saved.to_bytes()).expect("a checkpoint");
        assert_eq!(read.to_bytes(), saved.to_bytes());
        samples.truncate(usize::try_from(read.n_samples()).expect("a length"));
        checkpoint = Some(read);
    }
}

/// Stops after every few samples and after every few steps; returns the whole.
fn check(what: &str, mechanism: &Mechanism) -> Summary {
    let (whole, summary, _) = run_in_parts(mechanism, usize::MAX, usize::MAX);
    assert!(summary.reached_end, "{what}");
    for (period, steps) in [(1, usize::MAX), (7, usize::MAX), (usize::MAX, 1), (usize::MAX, 5)] {
        let (parts, again, n_parts) = run_in_parts(mechanism, period, steps);
        assert!(n_parts > 1, "{what}: {n_parts} parts");
        assert_eq!(parts.len(), whole.len(), "{what}, {period} samples, {steps} steps");
        for (k, (part, sample)) in parts.iter().zip(&whole).enumerate() {
            let t = f64::from_bits(sample[0]);
            assert!(part == sample, "{what}, {period} samples, {steps} steps: {k} at t = {t}");
        }
        assert_eq!(again, summary, "{what}, {period} samples, {steps} steps");
    }
    summary
}

#[test]
fn stops_and_kinks_are_passed_as_if_undisturbed() {
    for method in [Method::Auto, Method::Explicit, Method::Radau] {
        let mut model = model(BOUNCING);
        model.solve.method = method;
        let summary = check(&format!("{method:?}"), &derive(model));
        assert!(summary.changes.len() > 10, "{:?}", summary.changes);
    }
}

#[test]
fn ticks_are_passed_as_if_undisturbed() {
    for method in [Method::Auto, Method::Explicit, Method::Radau] {
        let mut model = model(include_str!("../fixtures/elements/encoder-quantised.toml"));
        // Few enough ticks to be stopped after each of their steps; some samples lie on ticks, some do not.
        (model.solve.t_end, model.solve.every) = (0.05, Some(0.001));
        model.solve.method = method;
        check(&format!("{method:?}"), &derive(model));
    }
}

#[test]
fn quaternions_go_on_as_if_undisturbed() {
    for method in [Method::Auto, Method::Radau] {
        let mut model = model(include_str!("../fixtures/spatial-four-bar.toml"));
        model.solve.method = method;
        check(&format!("{method:?}"), &derive(model));
    }
}

#[test]
fn angles_near_their_pole_go_on_as_if_undisturbed() {
    let text = "space = \"spatial\"\n[bodies.bob]\nmass = 1\ncom = [0, 0, -0.5]\n\
                inertia = [0.02, 0.02, 0.01]\n[joints.ball]\ntype = \"spherical\"\n\
                between = [\"ground\", \"bob\"]\ncoordinate = [\"a\", \"b\", \"c\"]\n\
                [initial]\nbob = { w = [0.01, 1, 0] }\n[solve]\nt_end = 3\nevery = 0.01\n";
    let summary = check("near a pole", &derive(model(text)));
    assert!(summary.pole.is_some());
}

#[test]
fn singular_poses_are_passed_as_if_undisturbed() {
    for method in [Method::Auto, Method::Radau] {
        let mut model = model(&windows(2, Coordinates::Relative));
        (model.solve.t_end, model.solve.every) = (3.0, Some(0.05));
        model.solve.method = method;
        let summary = check(&format!("{method:?}"), &derive(model));
        assert!(!summary.singular_poses.is_empty());
        let changes = summary.methods.iter().any(|change| change.method == Integrator::Explicit);
        assert!(changes, "{:?}", summary.methods);
    }
}

#[test]
fn massless_links_go_on_as_if_undisturbed() {
    let text = windows(2, Coordinates::Absolute);
    let heavy = "[bodies.h1]\nmass = \"1 kg\"\ninertia = \"1 kg*m^2/12\"";
    assert!(text.contains(heavy));
    let mut model = model(&text.replace(heavy, "[bodies.h1]\nmass = 0\ninertia = 0"));
    (model.solve.t_end, model.solve.every) = (3.0, Some(0.05));
    let summary = check("a massless horizontal", &derive(model));
    assert!(!summary.singular_poses.is_empty());
}

#[test]
fn every_formulation_goes_on_with_fixed_steps_too() {
    use Formulation::{Ggl, Index1, Index2, Index3};
    for formulation in [Ggl, Index1, Index2, Index3] {
        let mut model = model(&windows(1, Coordinates::Relative));
        (model.solve.t_end, model.solve.every) = (0.5, Some(0.02));
        (model.solve.method, model.solve.step) = (Method::Radau, Some(0.004));
        model.solve.formulation = formulation;
        check(&format!("{formulation:?}"), &derive(model));
    }
}

#[test]
fn outputs_at_steps_and_at_given_times_go_on_too() {
    let times = [0.41, 0.2, 0.2, 0.7, 0.05, -1.0, 9.0, 0.701, 0.702, 1.1];
    for outputs in [Outputs::Steps, Outputs::Times(times.to_vec())] {
        let mut model = model(BOUNCING);
        model.solve.outputs = outputs.clone();
        let mechanism = derive(model);
        let summary = check(&format!("{outputs:?}"), &mechanism);
        let times: Vec<f64> =
            mechanism.solve().expect("a motion").samples.iter().map(|sample| sample.t).collect();
        if outputs == Outputs::Steps {
            let n_ends = summary.stats.n_accept + 1;
            assert!((n_ends - 2..=n_ends).contains(&times.len()), "{} of {n_ends}", times.len());
            assert!(times.is_sorted_by(|a, b| a < b), "{times:?}");
        } else {
            assert_eq!(times, [0.0, 0.05, 0.2, 0.41, 0.7, 0.701, 0.702, 1.1, 1.5]);
        }
    }
}

#[test]
fn a_run_stopped_in_a_step_of_many_samples_goes_on_from_before_it() {
    for method in [Method::Auto, Method::Radau] {
        let mut model = model(BOUNCING);
        (model.solve.method, model.solve.every) = (method, Some(1e-5));
        let mechanism = derive(model);
        let (whole, summary, _) = run_in_parts(&mechanism, usize::MAX, usize::MAX);
        let (parts, again, n_parts) = run_in_parts(&mechanism, 20_011, usize::MAX);
        assert!(n_parts > 5, "{n_parts} parts of {} samples", whole.len());
        assert!(parts == whole, "other samples");
        assert_eq!(again, summary);
    }
}

#[test]
fn another_model_and_other_options_are_refused() {
    let stopped = |text: &str| {
        let mechanism = derive(model(text));
        let simulation = mechanism.simulation().expect("equations");
        let start = simulation.start().expect("a start");
        let mut stop = |_: &Sample| Control::Stop;
        let summary = simulation.run(&start, &mut stop, &|| false).expect("a run");
        summary.checkpoint.expect("a checkpoint")
    };
    let saved = stopped(BOUNCING);
    let refusal = |text: &str, saved: &RunCheckpoint| {
        let mechanism = derive(model(text));
        let simulation = mechanism.simulation().expect("equations");
        let start = simulation.start().expect("a start");
        let mut observer = |_: &Sample| Control::Continue;
        match simulation.resume(&start, saved, &mut observer, &|| false) {
            Err(Unresumed::Unfit(unfit)) => unfit.to_string(),
            other => panic!("{other:?}"),
        }
    };
    for (from, to, expected) in [
        ("1 kg", "2 kg", "the checkpoint was saved with other equations"),
        ("0.5 m", "0.6 m", "the checkpoint was saved with other initial values"),
        ("\"y\"", "\"z\"", "the checkpoint was saved with other coordinates"),
        ("1.5 s", "2 s", "the checkpoint was saved with `t_end` = 1.5, not 2"),
        (
            "[solve]",
            "[solve]\nmethod = \"radau\"",
            "the checkpoint was saved with another `method`",
        ),
    ] {
        assert_eq!(refusal(&BOUNCING.replacen(from, to, 1), &saved), expected);
    }

    // Whatever the bytes are, they are a run or refused.
    let bytes = saved.to_bytes();
    for n in 0..bytes.len() {
        assert!(RunCheckpoint::from_bytes(&bytes[..n]).is_err(), "{n} bytes");
    }
    for bit in 0..8 * bytes.len() {
        let mut changed = bytes.clone();
        changed[bit / 8] ^= 1 << (bit % 8);
        let read = RunCheckpoint::from_bytes(&changed);
        assert!(matches!(read, Err(Unfit::Damaged(_))), "bit {bit}");
    }

    // Nor does it matter when somebody has made the checksum fit.
    let mechanism = derive(model(BOUNCING));
    let simulation = mechanism.simulation().expect("equations");
    let start = mechanism.start().expect("a start");
    let mut n_refused = 0;
    let end = bytes.len() - 4;
    for k in (8 * 14..end - 8).step_by(8) {
        let mut changed = bytes.clone();
        changed[k] ^= 0x5a;
        changed[k + 5] ^= 0x01;
        let checksum = crc32fast::hash(&changed[..end]);
        changed[end..].copy_from_slice(&checksum.to_le_bytes());
        match RunCheckpoint::from_bytes(&changed) {
            Err(unfit) => assert!(matches!(unfit, Unfit::Damaged(_))),
            Ok(read) => {
                let mut once = |_: &Sample| Control::Stop;
                let resumed = simulation.resume(&start, &read, &mut once, &|| true);
                n_refused += usize::from(resumed.is_err());
            }
        }
    }
    assert!(n_refused > 10, "{n_refused}");
}
