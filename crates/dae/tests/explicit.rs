//! The explicit method: order, a long orbit, projection, stiffness, failures, backward runs.

use bksim_dae::{
    Cause, Control, ExplicitSolver, Layout, NotFinite, Ode, Outcome, Settings, SolveError, Start,
    StepControl, Tolerance, solve_ode,
};

use crate::common::reference::Reference;
use crate::common::{digits, fitted_order, max_error, uniform};

/// `y′ = f(t, y)` as a function, with an optional projection.
struct Function<F, P = fn(&mut [f64])> {
    layout: Layout,
    f: F,
    project: Option<P>,
}

impl<F: FnMut(f64, &[f64], &mut [f64])> Function<F> {
    fn new(n: usize, f: F) -> Self {
        Self { layout: uniform(n), f, project: None }
    }
}

impl<F: FnMut(f64, &[f64], &mut [f64]), P: Fn(&mut [f64])> Ode for Function<F, P> {
    fn layout(&self) -> &Layout {
        &self.layout
    }
    fn derivative(&mut self, t: f64, y: &[f64], ydot: &mut [f64]) -> Result<(), NotFinite> {
        (self.f)(t, y, ydot);
        Ok(())
    }
    fn project(&mut self, _t: f64, y: &mut [f64]) -> Result<(), NotFinite> {
        if let Some(project) = &self.project {
            project(y);
        }
        Ok(())
    }
}

fn settings(tolerance: f64) -> Settings {
    Settings { rtol: tolerance, atol: Tolerance::Scalar(tolerance), ..Settings::default() }
}

fn fixed(h: f64) -> Settings {
    let step = StepControl::Fixed { h, newton_tolerance: 1e-10 };
    Settings { step, ..Settings::default() }
}

fn start(t: f64, y: &[f64]) -> Start {
    Start { t, y: y.to_vec(), ydot: vec![0.0; y.len()] }
}

fn run<S: Ode>(system: S, from: Start, t_end: f64, settings: Settings) -> Outcome {
    solve_ode(system, from, t_end, settings, &mut |_| Control::Continue).expect("the run ends")
}

/// `y₁′ = y₂, y₂′ = −y₁ + t`, nonautonomous: `y₁ = t + cos t`.
fn forced() -> impl Ode {
    Function::new(2, |t, y, ydot| {
        ydot[0] = y[1];
        ydot[1] = t - y[0];
    })
}

#[test]
fn end_values_have_order_eight_and_dense_output_order_seven() {
    let steps = [1.0, 0.8, 0.5, 0.4];
    let errors = steps.map(|h| {
        let end = run(forced(), start(0.0, &[1.0, 1.0]), 4.0, fixed(h));
        (end.y[0] - (4.0 + 4f64.cos())).abs()
    });
    let order = fitted_order(&steps, &errors);
    assert!((7.6..8.6).contains(&order), "order {order:.2} from errors {errors:?}");

    // One step from an exact start: the extension errs by O(h⁸), its slope by O(h⁷).
    let within = |h: f64| {
        let (mut y, mut ydot) = ([0.0; 2], [0.0; 2]);
        let t = 0.4 * h;
        solve_ode(forced(), start(0.0, &[1.0, 1.0]), h, fixed(h), &mut |step| {
            step.at(t, &mut y);
            step.derivative_at(t, &mut ydot);
            Control::Continue
        })
        .expect("one step");
        [(y[0] - (t + t.cos())).abs(), (ydot[0] - (1.0 - t.sin())).abs()]
    };
    let errors = steps.map(|h| within(2.0 * h));
    for (part, expected) in [(0, 8.0), (1, 7.0)] {
        let order = fitted_order(&steps, &errors.map(|errors| errors[part]));
        assert!((order - expected).abs() < 0.7, "part {part}: order {order:.2} from {errors:?}");
    }
}

/// The restricted three-body problem on Arenstorf's orbit (HNW1 §II.0).
fn arenstorf() -> impl Ode {
    const MU: f64 = 0.012_277_471;
    Function::new(4, |_, y, ydot| {
        let r1 = ((y[0] + MU).powi(2) + y[1] * y[1]).sqrt().powi(3);
        let r2 = ((y[0] - (1.0 - MU)).powi(2) + y[1] * y[1]).sqrt().powi(3);
        ydot[0] = y[2];
        ydot[1] = y[3];
        ydot[2] = y[0] + 2.0 * y[3] - (1.0 - MU) * (y[0] + MU) / r1 - MU * (y[0] - (1.0 - MU)) / r2;
        ydot[3] = y[1] - 2.0 * y[2] - (1.0 - MU) * y[1] / r1 - MU * y[1] / r2;
    })
}

#[test]
fn arenstorfs_orbit_closes() {
    let y0 = [0.994, 0.0, 0.0, -2.001_585_106_379_082_5];
    let period = 17.065_216_560_157_964;
    let mut before = 0.0;
    for (tolerance, wanted, limit) in [(1e-7, 2.5, 130), (1e-10, 5.0, 230), (1e-13, 8.0, 500)] {
        let end = run(arenstorf(), start(0.0, &y0), period, settings(tolerance));
        let found = digits(&end.y[..2], &y0[..2]);
        assert!(found > wanted, "{found:.1} digits at {tolerance:e}");
        assert!(end.stats.n_accept < limit, "{tolerance:e}: {}", end.stats);
        assert!(found > before + 1.0, "tighter tolerances help");
        before = found;
    }
}

/// The pendulum of the data file, its accelerations from the multiplier: `λ = (v² − g y)/L²`.
fn pendulum(data: &Reference) -> Function<impl FnMut(f64, &[f64], &mut [f64]) + use<>> {
    let g = data.parameter("g");
    Function::new(4, move |_, y, ydot| {
        let lambda = (y[2] * y[2] + y[3] * y[3] - g * y[1]) / (y[0] * y[0] + y[1] * y[1]);
        ydot.copy_from_slice(&[y[2], y[3], -lambda * y[0], -lambda * y[1] - g]);
    })
}

/// Onto the circle, and the velocity onto its tangent.
fn onto_circle(y: &mut [f64]) {
    let radius = y[0].hypot(y[1]);
    y[0] /= radius;
    y[1] /= radius;
    let radial = y[0] * y[2] + y[1] * y[3];
    y[2] -= radial * y[0];
    y[3] -= radial * y[1];
}

#[test]
fn a_projected_pendulum_reaches_its_reference_on_its_circle() {
    let data = Reference::load("pendulum");
    let initial = [data.initial("q"), data.initial("v")].concat();
    for (tolerance, wanted, evaluations) in
        [(1e-4, 2.7, 760), (1e-6, 4.9, 1280), (1e-8, 7.1, 2120), (1e-10, 9.4, 3750)]
    {
        let Function { layout, f, .. } = pendulum(&data);
        let system = Function { layout, f, project: Some(onto_circle) };
        let mut drift = 0.0f64;
        let mut dense = 0.0f64;
        let mut y = [0.0; 4];
        let from = start(0.0, &initial);
        let end = solve_ode(system, from, data.t_end(), settings(tolerance), &mut |step| {
            let y1 = step.y1();
            drift = drift.max((y1[0] * y1[0] + y1[1] * y1[1] - 1.0).abs());
            step.at(step.t0() + 0.3 * step.h(), &mut y);
            dense = dense.max((y[0] * y[0] + y[1] * y[1] - 1.0).abs());
            Control::Continue
        })
        .expect("the run ends");
        let found = [digits(&end.y[..2], &data.end("q")), digits(&end.y[2..], &data.end("v"))];
        assert!(found[0] > wanted && found[1] > wanted - 0.6, "{found:.1?} at {tolerance:e}");
        assert!(drift < 1e-15, "drift {drift:e}");
        assert!(dense < 30.0 * tolerance, "dense output leaves the circle by {dense:e}");
        assert!(end.stats.n_residual < evaluations, "{tolerance:e}: {}", end.stats);
    }
}

#[test]
fn dense_output_follows_the_solution_in_both_directions() {
    for t_end in [3.0, -3.0f64] {
        let mut y = [0.0; 2];
        let end =
            solve_ode(forced(), start(0.0, &[1.0, 1.0]), t_end, settings(1e-9), &mut |step| {
                for part in [0.1, 0.3, 0.5, 0.7, 0.9] {
                    let t = step.t0() + part * step.h();
                    step.at(t, &mut y);
                    assert!((y[0] - (t + t.cos())).abs() < 1e-7, "{} at {t}", y[0]);
                }
                Control::Continue
            })
            .expect("the run ends");
        assert!(end.stats.n_accept > 2, "{}", end.stats);
    }
}

#[test]
fn dense_output_costs_three_evaluations_and_only_where_asked_for() {
    let mut solver =
        ExplicitSolver::new(forced(), start(0.0, &[1.0, 1.0]), 1.0, fixed(0.25)).expect("valid");
    let before = solver.stats().n_residual;
    while solver.advance().expect("no failure") {}
    assert_eq!(solver.stats().n_residual - before, 4 * 12);
    solver.last_step().expect("the last step");
    solver.last_step().expect("again, without new evaluations");
    assert_eq!(solver.stats().n_residual - before, 4 * 12 + 3);
}

/// Van der Pol's oscillator with `μ` in the form of HW2 §IV.1.
fn van_der_pol(mu: f64) -> impl Ode {
    Function::new(2, move |_, y, ydot| {
        ydot[0] = y[1];
        ydot[1] = mu * mu * ((1.0 - y[0] * y[0]) * y[1] - y[0]);
    })
}

#[test]
fn stiffness_is_detected_and_only_there() {
    let from = || start(0.0, &[2.0, 0.0]);
    let error =
        solve_ode(van_der_pol(1e3), from(), 2.0, settings(1e-6), &mut |_| Control::Continue)
            .expect_err("the slow branch is stiff");
    assert!(matches!(error, SolveError::Stiff { .. }), "{error}");
    let at = error.standstill().expect("the run was under way");
    assert!(at.stats.n_accept < 200, "found after {}", at.stats);
    assert!(error.report().contains("Radau"), "{}", error.report());
    run(van_der_pol(1.0), from(), 20.0, settings(1e-6));
}

#[test]
fn a_run_can_go_backwards_and_ends_exactly() {
    for settings in [settings(1e-10), fixed(0.1)] {
        let end = solve_ode(
            forced(),
            start(1.0, &[1.0 + 1f64.cos(), 1.0 - 1f64.sin()]),
            -1.0,
            settings,
            &mut |step| {
                assert!(step.h() < 0.0 && step.t1() < step.t0());
                Control::Continue
            },
        )
        .expect("the run ends");
        assert_eq!(end.t, -1.0);
        let exact = [-1.0 + 1f64.cos(), 1.0 + 1f64.sin()];
        assert!(max_error(&end.y, &exact) < 1e-9, "{:?}", end.y);
    }
}

#[test]
fn a_root_that_turns_negative_shrinks_the_step_then_stops_with_its_row() {
    // y = (1 − t/2)², which ends at t = 2.
    let falling = Function::new(2, |_, y: &[f64], ydot: &mut [f64]| {
        ydot[0] = 1.0;
        ydot[1] = -y[1].sqrt() - 1e-3;
    });
    let error = solve_ode(falling, start(0.0, &[0.0, 1.0]), 4.0, settings(1e-6), &mut |_| {
        Control::Continue
    })
    .expect_err("the solution ends near 2");
    assert!(matches!(error, SolveError::NotFinite { row: 1, .. }), "{error}");
    let at = error.standstill().expect("the run was under way");
    assert!((at.t - 1.98).abs() < 0.05, "stopped at {}", at.t);
    assert!(at.stats.n_newton_failed > 5, "{}", at.stats);
}

#[test]
fn a_pole_names_the_worst_unknown() {
    let layout = uniform(2).with_names(vec!["calm".into(), "wild".into()]);
    let mut system = Function::new(2, |_, y: &[f64], ydot: &mut [f64]| {
        ydot[0] = -y[0];
        ydot[1] = y[1] * y[1];
    });
    system.layout = layout;
    let error =
        solve_ode(system, start(0.0, &[1.0, 1.0]), 2.0, settings(1e-6), &mut |_| Control::Continue)
            .expect_err("1/(1 − t) has a pole");
    let at = error.standstill().expect("the run was under way");
    assert!((at.t - 1.0).abs() < 1e-6, "stopped at {}", at.t);
    assert!(matches!(error, SolveError::StepTooSmall { cause: Cause::ErrorTest, .. }), "{error}");
    assert_eq!(at.worst[0].name, "wild", "{}", error.report());
}

#[test]
fn a_long_run_is_not_stopped_for_its_number_of_steps() {
    let n = 1_200_000_u32;
    let still = Function::new(1, |_, _, ydot| ydot[0] = 0.0);
    let outcome = run(still, start(0.0, &[1.0]), f64::from(n), fixed(1.0));
    assert_eq!(outcome.stats.n_step, n as usize);
}
