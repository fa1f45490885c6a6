//! Which method runs when, and that all of them come to the same motion.

use crate::support::{Within, all_close, brief, derive, example, model, solve, weighted_error};
use bksim::model::{Formulation, Method};
use bksim::sim::run::{Integrator, Reason};

/// A mass of 1 kg behind a damper of 10 kN s/m and a spring of 100 N/m: it creeps back with a time
/// constant of 100 s, the damper acts within 0.1 ms.
const CREEP: &str = include_str!("../fixtures/creep.toml");

#[test]
fn a_motion_that_turns_stiff_goes_on_with_radau() {
    let motion = solve(&derive(model(CREEP)));
    let methods = &motion.summary.methods;
    let used: Vec<_> = methods.iter().map(|m| (m.method, m.reason)).collect();
    let expected = [(Integrator::Explicit, Reason::Cheapest), (Integrator::Radau, Reason::Stiff)];
    assert_eq!(used, expected);
    assert!(methods[1].t < 0.1, "noticed at t = {}", methods[1].t);

    // x'' + c x' + k x = 0 with two real roots.
    let (c, k) = (1e4_f64, 100.0);
    let root = (c * c - 4.0 * k).sqrt();
    // The slow root without cancellation: their product is k.
    let fast = -0.5 * (c + root);
    let slow = k / fast;
    for sample in &motion.samples {
        let t = sample.t;
        let x = 0.5 * (fast * (slow * t).exp() - slow * (fast * t).exp()) / (fast - slow);
        let within = Within { relative: 0.0, absolute: 1e-6 };
        all_close(&format!("t = {t}"), &sample.q, &[x], within);
    }
    let n_steps = motion.summary.stats.n_step;
    assert!(n_steps < 1000, "{n_steps} steps, where explicit ones would be some hundred thousand");
}

/// A mass of 1 kg on a spring of 100 N/m, whose damper of 10 kN s/m fails within a second.
const FAILING_DAMPER: &str = r#"
[bodies.mass]
mass = "1 kg"

[joints.rail]
type = "prismatic"
between = ["ground", "mass"]
axis = [1, 0]

[loads.spring]
type = "force"
on = "mass"
vector = ["-100 N/m*rail.position - 1e4 N s/m*exp(-t/(50 ms))*rail.velocity", 0]

[initial]
rail = { position = "1 m", velocity = 0 }

[solve]
t_end = "200 s"
"#;

#[test]
fn a_motion_that_is_no_longer_stiff_goes_on_with_explicit_steps() {
    let summary = solve(&derive(model(FAILING_DAMPER))).summary;
    let methods: Vec<_> = summary.methods.iter().map(|m| (m.method, m.reason)).collect();
    let expected = [
        (Integrator::Explicit, Reason::Cheapest),
        (Integrator::Radau, Reason::Stiff),
        (Integrator::Explicit, Reason::Relaxed),
    ];
    assert_eq!(methods, expected);
    assert!(summary.methods[2].t < 100.0, "noticed at t = {}", summary.methods[2].t);
}

/// The governor's arms are held by stiff springs; at some tolerances steps swing about the end of the range in
/// which they are stable, at others their small oscillations limit them.
#[test]
fn stiffness_is_found_at_every_tolerance() {
    for rtol in [1e-4, 1e-6, 1e-8, 1e-10] {
        let mut model = example("governor");
        model.solve.method = Method::Auto;
        (model.solve.rtol, model.solve.atol) = (rtol, rtol);
        let summary = solve(&derive(model)).summary;
        let last = summary.methods.last().map(|change| (change.method, change.reason));
        assert_eq!(last, Some((Integrator::Radau, Reason::Stiff)), "rtol {rtol:e}");
        let n_step = summary.stats.n_step;
        assert!(n_step < 1000, "rtol {rtol:e}: {n_step} steps, where Radau takes some 200");
    }
}

/// Andrews' squeezing mechanism far beyond the 0.03 s of its published solution, at up to 10⁴ rad/s, where the
/// multipliers of the stabilised form are below rounding. The crank has turned by 5000 rad in the end, whose last digit is as
/// large as the errors that the tightest tolerance allows.
#[test]
fn a_fast_mechanism_runs_on_at_tight_tolerances() {
    for rtol in [1e-8, 1e-10, 1e-12] {
        let mut model = model(include_str!("../../crates/bench/models/andrews.toml"));
        model.solve.method = Method::Radau;
        (model.solve.rtol, model.solve.atol, model.solve.t_end) = (rtol, rtol, 1.0);
        let mechanism = derive(model);
        let motion = mechanism.solve().unwrap_or_else(|e| panic!("rtol {rtol:e}: {e}"));
        let energy = motion.summary.energy;
        let off = energy.worst_error / energy.scale;
        assert!(off < rtol.max(1e-10), "rtol {rtol:e}: the energy is off by {off:e}");
    }
}

#[test]
fn every_method_and_formulation_comes_to_the_same_motion() {
    for name in ["slider-crank", "four-bar", "spring-pendulum"] {
        let motion = |method, formulation| {
            let mut model = example(name);
            (model.solve.method, model.solve.formulation) = (method, formulation);
            (model.solve.rtol, model.solve.atol) = (1e-9, 1e-9);
            model.solve.t_end = model.solve.t_start + 1.0;
            solve(&derive(model)).samples.pop().expect("a sample")
        };
        let expected = motion(Method::Explicit, Formulation::Ggl);
        let others = [
            (Method::Auto, Formulation::Ggl),
            (Method::Radau, Formulation::Ggl),
            (Method::Radau, Formulation::Index2),
            (Method::Radau, Formulation::Index1),
            (Method::Radau, Formulation::Index3),
        ];
        for (method, formulation) in others {
            let found = motion(method, formulation);
            let errors = [
                weighted_error(&found.q, &expected.q),
                weighted_error(&found.v, &expected.v),
                weighted_error(&found.lambda, &expected.lambda),
            ];
            let worst = errors.into_iter().fold(0.0, f64::max);
            assert!(worst < 1e-6, "{name}, {method:?}, {formulation:?}: q v λ {}", brief(&errors));
        }
    }
}
