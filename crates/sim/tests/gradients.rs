//! Gradients back along motions in which nothing switches, and what has none.

use crate::both_ways::{Of, both_ways};
use bksim_dae::Control;
use bksim_model::{Jit, Method};
use bksim_sim::Mechanism;
use bksim_sim::run::Sample;
use bksim_sim::sensitivity::SampleWeights;

fn mechanism(text: &str, t_end: f64, rtol: f64) -> Mechanism {
    let mut mechanism =
        Mechanism::from_toml(text, "model").unwrap_or_else(|fault| panic!("{fault}"));
    let solve = &mut mechanism.model.solve;
    (solve.rtol, solve.atol) = (rtol, rtol);
    (solve.t_end, solve.every) = (t_end, Some(t_end / 20.0));
    mechanism
}

/// Compares both ways for these options.
fn agree(mechanism: &Mechanism, names: &[&str], of: Of, within: f64) {
    let find = |name: &&str| mechanism.sensitive(name).expect("it is there");
    let sensitive: Vec<_> = names.iter().map(find).collect();
    let simulation = mechanism.simulation().expect("a simulation");
    let motion = simulation.sensitivities(&sensitive).unwrap_or_else(|e| panic!("{e}"));
    both_ways(mechanism, &motion, &sensitive, of, within);
}

const SLIDER_CRANK: &str = include_str!("../../../examples/slider-crank/model.toml");

#[test]
fn a_loop_has_the_same_derivatives_both_ways_by_every_method() {
    for method in [Method::Auto, Method::Explicit, Method::Radau] {
        for jit in [Jit::Off, Jit::On] {
            let mut mechanism = mechanism(SLIDER_CRANK, 2.0, 1e-10);
            (mechanism.model.solve.method, mechanism.model.solve.jit) = (method, jit);
            agree(&mechanism, &["l1", "m3", "i2", "A.rate"], Of::Everything, 1e-10);
        }
    }
}

/// At rest the slider's mass does not act on the crank: its derivative begins with a high power of time, which rounding
/// covers at first.
#[test]
fn derivatives_that_begin_as_rounding_come_to_the_end() {
    let mut mechanism = mechanism(SLIDER_CRANK, 0.5, 1e-10);
    mechanism.model.solve.atol = 1e-12;
    agree(&mechanism, &["m3"], Of::Everything, 1e-9);
}

/// A pendulum on a ball joint, which turns by a quaternion.
const BALL: &str = "space = \"spatial\"\n[parameters]\nm = \"1 kg\"\nlean = \"0.3 rad\"\n\
    [bodies.bob]\nmass = \"m\"\ninertia = [0.02, 0.03, 0.04]\ncom = [0, 0, -0.5]\n\
    [joints.ball]\ntype = \"spherical\"\nbetween = [\"ground\", \"bob\"]\n\
    [loads.g]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n\
    [initial]\nbob = { rpy = [\"lean\", 0.1, 0], wx_body = 0.4, wy_body = 5, wz_body = 0.2 }\n";

#[test]
fn a_quaternion_has_the_same_derivatives_both_ways() {
    agree(&mechanism(BALL, 1.0, 1e-10), &["m", "lean", "bob.wy_body"], Of::Everything, 1e-10);
}

/// A drive says how the crank turns, and lengths are defined by others.
#[test]
fn a_driven_loop_has_the_same_derivatives_both_ways() {
    let text = include_str!("../../../examples/four-bar/model.toml");
    agree(&mechanism(text, 1.0, 1e-10), &["c", "speed"], Of::Everything, 1e-10);
}

#[test]
fn joints_that_repeat_others_have_gradients_of_motion_alone() {
    let text = include_str!("../../../examples/parallelogram/model.toml");
    let mechanism = mechanism(text, 0.2, 1e-10);
    agree(&mechanism, &["l", "A.rate"], Of::Motion, 1e-10);

    let simulation = mechanism.simulation().expect("a simulation");
    let start = simulation.start().expect("a start");
    let by = [mechanism.sensitive("l").expect("it is there")];
    let plan = simulation.plan_gradient(&start, &by).expect("a plan");
    let mut ignored = |_: &Sample| Control::Continue;
    let mut goal = |samples: &[Sample]| {
        let lambda = vec![1.0; samples[0].lambda.len()];
        vec![Some(SampleWeights { lambda, ..SampleWeights::default() })]
    };
    let failure = simulation.gradient(&start, &plan, &mut ignored, &mut goal, &|| false);
    let failure = failure.expect_err("multipliers are not unique");
    let fault = simulation.diagnose(&failure);
    assert_eq!(fault.code.0, "S012", "{fault:?}");
    assert!(fault.message.contains("share the reactions"), "{fault:?}");
}

/// Errors fall with the tolerance of the run.
#[test]
fn gradients_converge_with_the_tolerance() {
    let find = |rtol: f64| {
        let mechanism = mechanism(SLIDER_CRANK, 2.0, rtol);
        let simulation = mechanism.simulation().expect("a simulation");
        let start = simulation.start().expect("a start");
        let by = [mechanism.sensitive("l1").expect("it is there")];
        let plan = simulation.plan_gradient(&start, &by).expect("a plan");
        let mut ignored = |_: &Sample| Control::Continue;
        let mut goal = |samples: &[Sample]| {
            let n = samples[0].q.len();
            let last = SampleWeights { q: vec![1.0; n], ..SampleWeights::default() };
            let mut weights = vec![None; samples.len()];
            *weights.last_mut().expect("samples") = Some(last);
            weights
        };
        let found = simulation.gradient(&start, &plan, &mut ignored, &mut goal, &|| false);
        found.expect("it runs").expect("to the end").by[0]
    };
    let exact = find(1e-12);
    let errors = [1e-5, 1e-7, 1e-9].map(|rtol| (find(rtol) - exact).abs() / exact.abs());
    assert!(errors[0] < 1e-3 && errors[1] < 1e-5 && errors[2] < 1e-7, "{errors:?}");
    assert!(errors[0] > errors[1] && errors[1] > errors[2], "{errors:?}");
}

/// A run that is asked to stop has no gradient: on its way, or back.
#[test]
fn a_stopped_run_has_no_gradient() {
    let mechanism = mechanism(SLIDER_CRANK, 2.0, 1e-6);
    let simulation = mechanism.simulation().expect("a simulation");
    let start = simulation.start().expect("a start");
    let by = [mechanism.sensitive("l1").expect("it is there")];
    let plan = simulation.plan_gradient(&start, &by).expect("a plan");
    for stops_on_the_way in [true, false] {
        let is_back = std::cell::Cell::new(false);
        let mut ignored = |_: &Sample| Control::Continue;
        let mut goal = |samples: &[Sample]| {
            is_back.set(true);
            let n = samples[0].q.len();
            let one = SampleWeights { q: vec![1.0; n], ..SampleWeights::default() };
            vec![Some(one); samples.len()]
        };
        let stop = || stops_on_the_way || is_back.get();
        let found = simulation.gradient(&start, &plan, &mut ignored, &mut goal, &stop);
        assert_eq!(found.expect("no fault"), None);
        assert_ne!(is_back.get(), stops_on_the_way);
    }
}
