//! Stiff equations, ends of runs, failures with their causes, fixed steps, backward runs.

use bksim_dae::{
    Cause, Control, End, Layout, NewtonSettings, NotFinite, Pattern, Settings, SolveError, Solver,
    Start, StepControl, System, Tolerance, solve,
};

use crate::common::dual::Real;
use crate::common::problems::{Robertson, VanDerPol};
use crate::common::{Differentiated, Residual, max_error, uniform};

fn settings(tolerance: f64) -> Settings {
    Settings { rtol: tolerance, atol: Tolerance::Scalar(tolerance), ..Settings::default() }
}

fn start(y: &[f64], ydot: &[f64]) -> Start {
    Start { t: 0.0, y: y.to_vec(), ydot: ydot.to_vec() }
}

#[test]
fn van_der_pol_passes_its_jumps() {
    // Start and end value of the Test Set for IVP Solvers, `vdpol`, ε = 1e-6.
    let from = start(&[2.0, 0.0], &[0.0, -2e6]);
    let system = Differentiated::dense(VanDerPol);
    let end =
        solve(system, from, 2.0, settings(1e-6), &mut |_| Control::Continue).expect("the run ends");
    let error = max_error(&end.y, &[1.706_167_732_170_483, -0.892_809_701_024_795]);
    assert!(error < 1e-5, "error {error:e}");
    assert!(end.stats.n_accept < 1000, "{}", end.stats);
}

#[test]
fn robertson_reaches_its_steady_state() {
    let from = start(&[1.0, 0.0, 0.0], &[-0.04, 0.04, 0.0]);
    let atol = Tolerance::PerUnknown(vec![1e-9, 1e-13, 1e-9]);
    let settings = Settings { rtol: 1e-7, atol, ..Settings::default() };
    let system = Differentiated::dense(Robertson);
    let end =
        solve(system, from, 1e11, settings, &mut |_| Control::Continue).expect("the run ends");
    // End value of the Test Set for IVP Solvers, `rober`, t = 1e11.
    let reference = [0.208_334_014_970_122e-7, 0.833_336_077_033_471e-13, 0.999_999_979_166_589];
    for i in 0..3 {
        let error = (end.y[i] - reference[i]).abs() / reference[i];
        assert!(error < 2e-2, "y[{i}] = {:e}, reference {:e}", end.y[i], reference[i]);
    }
    assert!(end.stats.n_accept < 550 && end.stats.n_factor < 300, "{}", end.stats);
}

/// `y′ = −rate · y`.
struct Decay(f64);

impl Residual for Decay {
    fn layout(&self) -> Layout {
        uniform(1)
    }
    fn residual<T: Real>(&self, _t: f64, y: &[T], ydot: &[T]) -> Vec<T> {
        vec![ydot[0] + T::from(self.0) * y[0]]
    }
}

#[test]
fn a_run_ends_exactly_at_its_end_and_dense_output_meets_the_steps() {
    let mut last = 0.0;
    let end = solve(
        Differentiated::dense(Decay(1.0)),
        start(&[1.0], &[-1.0]),
        0.7,
        settings(1e-9),
        &mut |step| {
            assert_eq!(step.t0(), last, "steps follow each other");
            let mut y = [0.0];
            step.at(step.t0(), &mut y);
            assert_eq!(y[0], step.y0()[0]);
            step.at(step.t1(), &mut y);
            assert_eq!(y[0], step.y1()[0]);
            step.derivative_at(step.t1(), &mut y);
            assert!((y[0] - step.ydot1()[0]).abs() < 1e-10, "{} {}", y[0], step.ydot1()[0]);
            last = step.t1();
            Control::Continue
        },
    )
    .expect("the run ends");
    assert_eq!((end.t, end.end, last), (0.7, End::Reached, 0.7));
    assert!((end.y[0] - (-0.7f64).exp()).abs() < 1e-9, "{}", end.y[0]);
}

#[test]
fn an_observer_can_stop_the_run() {
    let system = Differentiated::dense(Decay(1.0));
    let stop_after_half = &mut |step: &bksim_dae::Step<'_>| {
        if step.t1() > 0.5 { Control::Stop } else { Control::Continue }
    };
    let end = solve(system, start(&[1.0], &[-1.0]), 9.0, settings(1e-6), stop_after_half)
        .expect("the run ends");
    assert_eq!(end.end, End::Stopped);
    assert!(end.t > 0.5 && end.t < 9.0, "t = {}", end.t);
}

#[test]
fn a_run_can_go_backwards() {
    let from = Start { t: 1.0, y: vec![1.0], ydot: vec![-1.0] };
    for step in [StepControl::Adaptive, StepControl::Fixed { h: 0.05, newton_tolerance: 1e-12 }] {
        let settings = Settings { step, ..settings(1e-9) };
        let system = Differentiated::dense(Decay(1.0));
        let end = solve(system, from.clone(), -1.0, settings, &mut |step| {
            assert!(step.h() < 0.0);
            Control::Continue
        })
        .expect("the run ends");
        assert_eq!(end.t, -1.0);
        assert!((end.y[0] - 2f64.exp()).abs() < 1e-7, "{step:?}: {}", end.y[0]);
    }
}

#[test]
fn fixed_steps_are_counted_not_summed() {
    for (h, t_end, count) in [(0.1, 1.0, 10), (0.1, 1.05, 11), (0.01, 5.0, 500), (2.0, 1.0, 1)] {
        let step = StepControl::Fixed { h, newton_tolerance: 1e-12 };
        let settings = Settings { step, ..Settings::default() };
        let system = Differentiated::dense(Decay(1.0));
        let end = solve(system, start(&[1.0], &[-1.0]), t_end, settings, &mut |step| {
            assert_eq!(step.error(), None);
            Control::Continue
        })
        .expect("the run ends");
        assert_eq!((end.t, end.stats.n_accept), (t_end, count), "h = {h}");
    }
}

/// `y′ = −1/2 · 1/√y`, so that `y = (1 − 3t/4)^{2/3}` ends at `t = 4/3`.
struct Falling;

impl Residual for Falling {
    fn layout(&self) -> Layout {
        uniform(1)
    }
    fn residual<T: Real>(&self, _t: f64, y: &[T], ydot: &[T]) -> Vec<T> {
        vec![ydot[0] * y[0].sqrt() + T::from(0.5)]
    }
}

#[test]
fn a_root_that_turns_negative_stops_the_run_and_is_named() {
    let system = Differentiated::dense(Falling);
    let error =
        solve(system, start(&[1.0], &[-0.5]), 2.0, settings(1e-6), &mut |_| Control::Continue)
            .expect_err("the solution ends at 4/3");
    let at = error.standstill().expect("the run was under way").clone();
    assert!((at.t - 4.0 / 3.0).abs() < 1e-3, "stopped at {}", at.t);
    assert!(matches!(error, SolveError::NotFinite { row: 0, .. }), "{error}");
    assert!(at.stats.n_newton_failed > 0, "{}", at.stats);
    assert!(at.y[0] < 0.0, "the state tried last is reported: {:?}", at.y);
}

#[test]
fn values_missing_beyond_the_solution_only_shrink_steps() {
    // Close to the end of the root's domain stages, and the point ahead where the Jacobian is
    // taken, fall outside.
    let system = Differentiated::dense(Falling);
    let t_end = 4.0 / 3.0 - 1e-4;
    let end =
        solve(system, start(&[1.0], &[-0.5]), t_end, settings(1e-6), &mut |_| Control::Continue)
            .expect("the solution exists up to there");
    let exact = (0.75f64 * 1e-4).powf(2.0 / 3.0);
    assert!((end.y[0] - exact).abs() < 1e-5, "{} {exact}", end.y[0]);
}

/// A Jacobian without value beyond `t = 1`, by its own word or by an infinite entry.
struct NoJacobian {
    inner: Differentiated<Decay>,
    says_so: bool,
}

impl System for NoJacobian {
    fn layout(&self) -> &Layout {
        self.inner.layout()
    }
    fn pattern(&self) -> &Pattern {
        self.inner.pattern()
    }
    fn residual(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        out: &mut [f64],
    ) -> Result<(), NotFinite> {
        self.inner.residual(t, y, ydot, out)
    }
    fn jacobian(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        df_dy: &mut [f64],
        df_dydot: &mut [f64],
    ) -> Result<(), NotFinite> {
        self.inner.jacobian(t, y, ydot, df_dy, df_dydot)?;
        if t > 1.0 && self.says_so {
            return Err(NotFinite { row: 0 });
        }
        if t > 1.0 {
            df_dy[0] = f64::INFINITY;
        }
        Ok(())
    }
}

#[test]
fn a_jacobian_without_value_is_taken_at_the_start_of_the_step_and_else_named() {
    for says_so in [true, false] {
        let system = || NoJacobian { inner: Differentiated::dense(Decay(1.0)), says_so };
        // A new Jacobian in every step, though the equation is linear.
        let newton = NewtonSettings { keep_jacobian_below: Some(0.0), ..NewtonSettings::default() };
        let run = |t_end| {
            let settings = Settings { newton, ..settings(1e-6) };
            solve(system(), start(&[1.0], &[-1.0]), t_end, settings, &mut |_| Control::Continue)
        };
        // The last step starts before t = 1 and would reach beyond it.
        let end = run(1.001).expect("a Jacobian at the start of each step is enough");
        assert!((end.y[0] - (-1.001f64).exp()).abs() < 1e-6, "{}", end.y[0]);
        let error = run(30.0).expect_err("there is none beyond");
        assert!(matches!(error, SolveError::NotFinite { row: 0, .. }), "{error}");
    }
}

/// The second equation repeats the first.
struct Repeated;

impl Residual for Repeated {
    fn layout(&self) -> Layout {
        uniform(2)
    }
    fn residual<T: Real>(&self, _t: f64, y: &[T], ydot: &[T]) -> Vec<T> {
        let row = ydot[0] + y[0] + y[1];
        vec![row, row]
    }
}

#[test]
fn a_repeated_equation_is_reported_as_singular() {
    for step in [StepControl::Adaptive, StepControl::Fixed { h: 0.1, newton_tolerance: 1e-10 }] {
        let settings = Settings { step, ..settings(1e-6) };
        let system = Differentiated::dense(Repeated);
        let error = solve(system, start(&[1.0, 0.0], &[-1.0, 0.0]), 1.0, settings, &mut |_| {
            Control::Continue
        })
        .expect_err("the matrix is singular");
        let cause = match &error {
            SolveError::StepTooSmall { cause, .. } | SolveError::FixedStepFailed { cause, .. } => {
                *cause
            }
            other => panic!("unexpected {other}"),
        };
        assert_eq!(cause, Cause::Singular, "{error}");
        assert_eq!(error.stats().map(|stats| stats.n_accept), Some(0));
    }
}

/// A jump of the right-hand side that no step passes with the tolerance asked for.
struct Explosion;

impl Residual for Explosion {
    fn layout(&self) -> Layout {
        uniform(2)
    }
    fn residual<T: Real>(&self, _t: f64, y: &[T], ydot: &[T]) -> Vec<T> {
        vec![ydot[0] - y[0] * y[0], ydot[1] + y[1]]
    }
}

#[test]
fn a_pole_stops_the_run_and_names_the_worst_unknown() {
    let system = Differentiated::dense(Explosion);
    let from = start(&[1.0, 1.0], &[1.0, -1.0]);
    let error = solve(system, from, 2.0, settings(1e-6), &mut |_| Control::Continue)
        .expect_err("y = 1/(1 − t) has a pole");
    let at = error.standstill().expect("the run was under way");
    assert!((at.t - 1.0).abs() < 1e-6, "stopped at {}", at.t);
    assert_eq!(at.worst.first().map(|worst| worst.i), Some(0), "{at:?}");
}

#[test]
fn the_number_of_steps_is_limited() {
    let settings = Settings { max_steps: 7, h_max: 0.01, ..settings(1e-6) };
    let system = Differentiated::dense(Decay(1.0));
    let error = solve(system, start(&[1.0], &[-1.0]), 1.0, settings, &mut |_| Control::Continue)
        .expect_err("seven steps are not enough");
    assert!(matches!(error, SolveError::TooManySteps { limit: 7, .. }), "{error}");
    assert_eq!(error.stats().map(|stats| stats.n_step), Some(7));
}

#[test]
fn input_out_of_range_is_refused_by_name() {
    let refuse = |settings: Settings, y: &[f64]| {
        let system = Differentiated::dense(Decay(1.0));
        let result = Solver::new(system, start(y, &[-1.0]), 1.0, settings);
        result.err().expect("the input is refused").to_string()
    };
    let with_rtol = |rtol| Settings { rtol, ..Settings::default() };
    assert_eq!(
        refuse(with_rtol(f64::NAN), &[1.0]),
        "option `rtol` must be 1e-14 ..= 0.1, found NaN"
    );
    assert_eq!(
        refuse(Settings::default(), &[1.0, 2.0]),
        "`y` has 2 entries, the system has 1 unknowns"
    );
    assert_eq!(refuse(Settings::default(), &[f64::NAN]), "`y` is not finite: NaN");
    let fixed = StepControl::Fixed { h: 0.0, newton_tolerance: 1e-10 };
    let settings = Settings { step: fixed, ..Settings::default() };
    assert_eq!(refuse(settings, &[1.0]), "option `step.h` must be positive and finite, found 0");
}

#[test]
fn a_corrected_state_is_the_start_of_the_next_step() {
    let mut solver =
        Solver::new(Differentiated::dense(Decay(1.0)), start(&[1.0], &[-1.0]), 1.0, settings(1e-6))
            .expect("valid input");
    solver.step().expect("a step").expect("not at the end");
    let y = solver.y()[0] * (1.0 + 1e-9);
    solver.correct_state(&[y], &[-y]).expect("fits");
    let step = solver.step().expect("a step").expect("not at the end");
    assert_eq!(step.y0()[0], y);
}
