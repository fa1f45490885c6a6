//! Singular poses: the N-four-bar folds flat at every half turn, all its windows at once, and could
//! go on in 2ᴺ ways.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::support::large::{Coordinates, windows};
use crate::support::{derive, model, path, solve};
use bksim::model::Method;
use serde_json::Value;

/// Rows of (t, θ, θ′) of the closed form; θ turns clockwise.
fn closed_form(n: usize) -> Vec<[f64; 3]> {
    let text = std::fs::read_to_string(path("tests/data/n-four-bar.json")).expect("the data");
    let data: Value = serde_json::from_str(&text).expect("JSON");
    let rows = data["runs"][n.to_string()].as_array().expect("rows");
    let number = |x: &Value| x.as_f64().expect("a number");
    rows.iter().map(|row| std::array::from_fn(|k| number(&row[k]))).collect()
}

/// Runs the N-four-bar, checks it against the closed form, and returns the worst angle error.
fn check(n: usize, rtol: f64, method: Method) -> f64 {
    let mut model = model(&windows(n, Coordinates::Relative));
    (model.solve.t_end, model.solve.every) = (10.0, Some(0.1));
    (model.solve.rtol, model.solve.atol, model.solve.method) = (rtol, 1e-2 * rtol, method);
    let motion = solve(&derive(model));
    let summary = &motion.summary;
    let what = format!("N = {n}, rtol {rtol:.0e}, {method:?}");

    let known = closed_form(n);
    let worst = motion
        .samples
        .iter()
        .zip(&known)
        .map(|(sample, [t, theta, _])| {
            assert!((sample.t - t).abs() < 1e-12, "{what}: t = {} against {t}", sample.t);
            (sample.q[0] - (FRAC_PI_2 - theta)).abs()
        })
        .fold(0.0, f64::max);

    // Flat at θ = π/2, 3π/2, …: there, and only there, the row across each window is lost.
    let folds = |[_, theta, _]: &[f64; 3]| ((theta + FRAC_PI_2) / PI).floor();
    let n_crossings: f64 =
        known.windows(2).map(|two| (folds(&two[1]) - folds(&two[0])).abs()).sum();
    let times: Vec<f64> = summary.singular_poses.iter().map(|pose| pose.t).collect();
    assert_eq!(times.len() as f64, n_crossings, "{what}: {times:?}");
    for pose in &summary.singular_poses {
        assert_eq!((pose.rank, pose.rows.len()), (n, n), "{what}: {pose:?}");
    }
    let energy = summary.energy.worst_error / summary.energy.scale;
    assert!(energy < 1e-5, "{what}: energy off by {energy:.1e} of its scale");
    worst
}

#[test]
fn windows_fold_flat_and_stay_on_their_branch() {
    for n in [2, 10, 40] {
        for rtol in [1e-6, 1e-8] {
            let error = check(n, rtol, Method::Auto);
            assert!(error < 20.0 * rtol, "N = {n}, rtol {rtol:.0e}: angle off by {error:.1e}");
        }
    }
}

#[test]
fn radau_hands_over_ahead_of_the_pose_and_takes_over_behind() {
    for rtol in [1e-6, 1e-8] {
        let error = check(2, rtol, Method::Radau);
        assert!(error < 100.0 * rtol, "rtol {rtol:.0e}: angle off by {error:.1e}");
    }
}

/// Radau's steps may end as near to a pose as a small part of their length, and turn by two radians.
#[test]
fn radau_tells_every_pose_at_loose_tolerances() {
    for rtol in [1e-2, 5.6e-3, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6] {
        let mut model = model(&windows(1, Coordinates::Relative));
        (model.solve.rtol, model.solve.atol, model.solve.method) = (rtol, rtol, Method::Radau);
        model.solve.t_end = 10.0;
        let poses = solve(&derive(model)).summary.singular_poses;
        let times: Vec<f64> = poses.iter().map(|pose| pose.t).collect();
        assert_eq!(times.len(), 10, "rtol {rtol:.1e}: {times:?}");
    }
}

/// Steps that shorten on their way to a pose pass it as others do; every second pass is the way back.
#[test]
fn every_pose_is_reported_at_every_tolerance() {
    for method in [Method::Explicit, Method::Radau] {
        for exponent in 4..=11 {
            let mut model = model(include_str!("../fixtures/swinging-door.toml"));
            let tolerance = 10f64.powi(-exponent);
            (model.solve.rtol, model.solve.atol) = (tolerance, tolerance);
            model.solve.method = method;
            let summary = solve(&derive(model)).summary;
            let times: Vec<f64> = summary.singular_poses.iter().map(|pose| pose.t).collect();
            let what = format!("{method:?}, 1e-{exponent}: {times:?}");
            let [first, second, third] = times[..] else { panic!("{what}") };
            let off = 1e-5 + 100.0 * tolerance;
            assert!((second - 3.0 * first).abs() < off, "{what}");
            assert!((third - 5.0 * first).abs() < off, "{what}");
            assert!(summary.singular_poses.iter().all(|pose| pose.rank == 1), "{what}");
        }
    }
}

/// A stage lies off the constraints by so much more than the end of a step that next to a pose its accelerations are
/// none of the motion: on the constraints, steps are as long there as elsewhere, and nothing is wrong with the tolerance.
/// At 1e-10 the last digits of the start decide whether that is so.
#[test]
fn steps_are_as_long_at_singular_poses_as_elsewhere() {
    for (exponent, angle) in [(4, "-60"), (6, "-60"), (8, "-60"), (8, "-60.00000001"), (8, "-60.3")]
    {
        let text = include_str!("../fixtures/swinging-door.toml");
        let mut model = model(&text.replace("-60 deg", &format!("{angle} deg")));
        let tolerance = 10f64.powi(-exponent);
        (model.solve.rtol, model.solve.atol) = (tolerance, tolerance);
        model.solve.method = Method::Explicit;
        let mechanism = derive(model);
        let summary = solve(&mechanism).summary;
        let (stats, what) =
            (summary.stats, format!("1e-{exponent} from {angle}°: {}", summary.stats));
        assert_eq!(summary.singular_poses.len(), 3, "{what}");
        assert!(stats.n_reject < 20 && stats.n_accept < 120, "{what}");
        let energy = summary.energy.worst_error / summary.energy.scale;
        assert!(energy < tolerance, "{what}: energy off by {energy:.1e} of its scale");
        let warnings = mechanism.simulation().expect("functions").diagnose_worth(&summary);
        assert!(warnings.iter().all(|warning| warning.code.0 != "R018"), "{what}");
    }
}

/// The accelerations of ten windows in absolute coordinates are known to some 1e-9 near their poses: a
/// tolerance below takes several times the steps for no better motion, and the run says so.
#[test]
fn a_tolerance_below_the_noise_of_the_accelerations_is_told() {
    let warned = |rtol: f64| {
        let mut model = model(&windows(10, Coordinates::Absolute));
        (model.solve.t_end, model.solve.rtol, model.solve.atol) = (6.0, rtol, rtol);
        let mechanism = derive(model);
        let summary = solve(&mechanism).summary;
        let warnings = mechanism.simulation().expect("functions").diagnose_worth(&summary);
        (warnings.iter().any(|warning| warning.code.0 == "R018"), summary)
    };
    let (is_warned, summary) = warned(1e-8);
    assert!(!is_warned, "{:?} of {}", summary.noise, summary.stats);
    let (is_warned, summary) = warned(1e-10);
    assert!(is_warned, "{:?} of {}", summary.noise, summary.stats);
    assert!(summary.noise.mean_error() > 0.1, "{:?}", summary.noise);
}
