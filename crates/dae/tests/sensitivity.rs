//! Sensitivities against closed forms, against differences of tight runs, and their order.

use bksim_dae::{
    Layout, NotFinite, Order, Pattern, SensitivitySolver, SensitivityStart, SensitivitySystem,
    Settings, Solver, Stages, Start, StepControl, System, Tolerance,
};

use crate::common::dual::{Dual, Real};
use crate::common::{Differentiated, Residual, fitted_order, uniform};

/// A residual with parameters, written once for numbers and for dual numbers.
trait Parametrised {
    fn layout(&self) -> Layout;
    fn parameters(&self) -> Vec<f64>;
    fn residual<T: Real>(&self, t: f64, y: &[T], ydot: &[T], p: &[T]) -> Vec<T>;
}

struct AtParameters<P>(P);

impl<P: Parametrised> Residual for AtParameters<P> {
    fn layout(&self) -> Layout {
        self.0.layout()
    }
    fn residual<T: Real>(&self, t: f64, y: &[T], ydot: &[T]) -> Vec<T> {
        let p: Vec<T> = self.0.parameters().into_iter().map(T::from).collect();
        self.0.residual(t, y, ydot, &p)
    }
}

/// Adds `∂F/∂p` by dual numbers.
struct Sensitive<P>(Differentiated<AtParameters<P>>);

impl<P: Parametrised> Sensitive<P> {
    fn new(problem: P) -> Self {
        Self(Differentiated::dense(AtParameters(problem)))
    }
}

impl<P: Parametrised> System for Sensitive<P> {
    fn layout(&self) -> &Layout {
        self.0.layout()
    }
    fn pattern(&self) -> &Pattern {
        self.0.pattern()
    }
    fn residual(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        out: &mut [f64],
    ) -> Result<(), NotFinite> {
        self.0.residual(t, y, ydot, out)
    }
    fn jacobian(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        df_dy: &mut [f64],
        df_dydot: &mut [f64],
    ) -> Result<(), NotFinite> {
        self.0.jacobian(t, y, ydot, df_dy, df_dydot)
    }
}

impl<P: Parametrised> SensitivitySystem for Sensitive<P> {
    fn n_parameters(&self) -> usize {
        self.0.problem.0.parameters().len()
    }
    fn parameter_jacobian(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        out: &mut [f64],
    ) -> Result<(), NotFinite> {
        let lift = |x: &[f64]| x.iter().map(|&x| Dual::from(x)).collect::<Vec<_>>();
        let problem = &self.0.problem.0;
        for (k, out) in out.chunks_exact_mut(y.len()).enumerate() {
            let mut p = lift(&problem.parameters());
            p[k].slope = 1.0;
            let column = problem.residual(t, &lift(y), &lift(ydot), &p);
            out.iter_mut().zip(column).for_each(|(out, dual)| *out = dual.slope);
        }
        Ok(())
    }
}

/// `y′ = −a y + b`, `y(0) = c`: parameters `a`, `b`, `c`.
struct Decay([f64; 3]);

impl Parametrised for Decay {
    fn layout(&self) -> Layout {
        uniform(1)
    }
    fn parameters(&self) -> Vec<f64> {
        self.0.to_vec()
    }
    fn residual<T: Real>(&self, _t: f64, y: &[T], ydot: &[T], p: &[T]) -> Vec<T> {
        vec![ydot[0] + p[0] * y[0] - p[1]]
    }
}

/// Pendulum with the constraint on velocities: parameters mass, gravity, initial speed.
struct Pendulum([f64; 3]);

impl Parametrised for Pendulum {
    fn layout(&self) -> Layout {
        Layout::from_groups(&[(4, bksim_dae::Index::One), (1, bksim_dae::Index::Two)])
    }
    fn parameters(&self) -> Vec<f64> {
        self.0.to_vec()
    }
    fn residual<T: Real>(&self, _t: f64, y: &[T], ydot: &[T], p: &[T]) -> Vec<T> {
        vec![
            ydot[0] - y[2],
            ydot[1] - y[3],
            p[0] * ydot[2] + y[4] * y[0],
            p[0] * ydot[3] + y[4] * y[1] + p[0] * p[1],
            y[0] * y[2] + y[1] * y[3],
        ]
    }
}

impl Pendulum {
    fn start(&self) -> Start {
        let [m, g, speed] = self.0;
        let lambda = m * speed * speed;
        Start {
            t: 0.0,
            y: vec![1.0, 0.0, 0.0, speed, lambda],
            ydot: vec![0.0, speed, -lambda / m, -g, 0.0],
        }
    }

    /// Only the initial speed and the multiplier depend on parameters at the start.
    fn sensitivities(&self) -> SensitivityStart {
        let [m, _, v] = self.0;
        let zero = vec![0.0; 5];
        let mut s = vec![zero.clone(); 3];
        let mut sdot = vec![zero; 3];
        (s[0][4], s[2][3], s[2][4]) = (v * v, 1.0, 2.0 * m * v);
        (sdot[1][3], sdot[2][1], sdot[2][2]) = (-1.0, 1.0, -2.0 * v);
        SensitivityStart { s, sdot }
    }

    fn run(&self, t_end: f64, settings: Settings) -> Vec<f64> {
        let mut solver = Solver::new(Sensitive::new(Self(self.0)), self.start(), t_end, settings)
            .expect("valid");
        while solver.step().expect("no failure").is_some() {}
        solver.y().to_vec()
    }
}

fn settings(tolerance: f64, order: Order) -> Settings {
    Settings { rtol: tolerance, atol: Tolerance::Scalar(tolerance), order, ..Settings::default() }
}

/// Sensitivities at the end, one vector per parameter.
fn end<S: SensitivitySystem>(mut run: SensitivitySolver<S>, count: usize) -> Vec<Vec<f64>> {
    while run.step().expect("no failure").is_some() {}
    (0..count).map(|k| run.s(k).to_vec()).collect()
}

#[test]
fn sensitivities_are_those_of_the_closed_form_between_the_steps_too() {
    let [a, b, c] = [1.3, 0.7, 2.0];
    // y = b/a + (c − b/a) e^{−a t}.
    let exact = |t: f64| {
        let e = (-a * t).exp();
        [-b / (a * a) * (1.0 - e) - (c - b / a) * t * e, (1.0 - e) / a, e]
    };
    for order in [Order::Fixed(Stages::One), Order::Fixed(Stages::Three), Order::Auto] {
        let tolerance = if order == Order::Fixed(Stages::One) { 1e-4 } else { 1e-9 };
        let start = Start { t: 0.0, y: vec![c], ydot: vec![b - a * c] };
        let sensitivities = SensitivityStart {
            s: vec![vec![0.0], vec![0.0], vec![1.0]],
            sdot: vec![vec![-c], vec![1.0], vec![-a]],
        };
        let system = Sensitive::new(Decay([a, b, c]));
        let settings = settings(tolerance, order);
        let mut run =
            SensitivitySolver::new(system, start, &sensitivities, 3.0, settings).expect("valid");
        let mut n_steps = 0;
        while let Some(step) = run.step().expect("no failure") {
            n_steps += 1;
            for part in [0.0, 0.3, 1.0] {
                let t = step.step.t0() + part * step.step.h();
                for (k, exact) in exact(t).into_iter().enumerate() {
                    let mut s = [0.0];
                    step.s_at(k, t, &mut s);
                    let error = (s[0] - exact).abs();
                    assert!(error < 20.0 * tolerance, "{order:?}, p{k} at {t}: {error:e}");
                }
            }
            let slope = step.sdot1(2)[0] + a * step.s1(2)[0];
            assert!(slope.abs() < 20.0 * tolerance, "s′ = −a s, off by {slope:e}");
        }
        assert!(n_steps > 4);
    }
}

#[test]
fn sensitivities_of_constrained_motion_are_the_differences_of_tight_runs() {
    let p = [1.4, 9.81, 0.6];
    let t_end = 2.0;
    let start = Pendulum(p);
    let run = SensitivitySolver::new(
        Sensitive::new(Pendulum(p)),
        start.start(),
        &start.sensitivities(),
        t_end,
        settings(1e-8, Order::Auto),
    );
    let found = end(run.expect("valid"), 3);
    for k in 0..3 {
        let shifted = |factor: f64| {
            let mut p = p;
            p[k] += factor * 1e-4;
            Pendulum(p).run(t_end, settings(1e-12, Order::Auto))
        };
        let (plus, minus) = (shifted(1.0), shifted(-1.0));
        for i in 0..5 {
            let difference = (plus[i] - minus[i]) / 2e-4;
            let error = (found[k][i] - difference).abs() / difference.abs().max(1.0);
            // Differences of second order with h = 1e-4.
            let allowed = if i < 4 { 1e-6 } else { 1e-5 };
            assert!(error < allowed, "p{k}, y{i}: {} and {difference}", found[k][i]);
        }
    }
}

#[test]
fn sensitivities_have_the_order_of_the_method() {
    let p = [1.0, 1.0, 0.7];
    let at = |h: f64, stages| {
        let step = StepControl::Fixed { h, newton_tolerance: 1e-13 };
        let settings = Settings { step, ..settings(1e-12, Order::Fixed(stages)) };
        let start = Pendulum(p);
        let run = SensitivitySolver::new(
            Sensitive::new(Pendulum(p)),
            start.start(),
            &start.sensitivities(),
            1.0,
            settings,
        );
        end(run.expect("valid"), 3)
    };
    let reference = at(1.0 / 64.0, Stages::Five);
    let steps = [16.0, 24.0, 32.0, 48.0].map(|count| 1.0 / count);
    let ends = steps.map(|h| at(h, Stages::Three));
    for k in 1..3 {
        for (part, range, expected) in [("q", 0..2, 5.0), ("v", 2..4, 5.0), ("λ", 4..5, 3.0)] {
            let errors: Vec<f64> = ends
                .iter()
                .map(|end| {
                    crate::common::max_error(&end[k][range.clone()], &reference[k][range.clone()])
                })
                .collect();
            let order = fitted_order(&steps, &errors);
            let what = format!("p{k}, {part}: order {order:.2} from {errors:?}");
            assert!((order - expected).abs() < 0.35, "{what}, expected {expected}");
        }
    }
}

#[test]
fn sensitivities_leave_the_solution_as_it_is_and_can_be_resumed() {
    let p = [1.4, 9.81, 0.6];
    let settings = settings(1e-7, Order::Auto);
    let new = || {
        let start = Pendulum(p);
        let system = Sensitive::new(Pendulum(p));
        SensitivitySolver::new(system, start.start(), &start.sensitivities(), 2.0, settings.clone())
            .expect("valid")
    };
    let mut whole = new();
    let mut n_steps = 0;
    while whole.step().expect("no failure").is_some() {
        n_steps += 1;
    }
    assert_eq!(whole.solver().y(), Pendulum(p).run(2.0, settings.clone()), "bit for bit");

    for after in [0, 1, n_steps / 2] {
        let mut run = new();
        for _ in 0..after {
            run.step().expect("no failure");
        }
        let saved = run.save();
        let system = Sensitive::new(Pendulum(p));
        let mut resumed =
            SensitivitySolver::resume(system, &saved, 2.0, settings.clone()).expect("it fits");
        while resumed.step().expect("no failure").is_some() {}
        for k in 0..3 {
            assert_eq!(resumed.s(k), whole.s(k), "p{k}, interrupted after {after}");
        }
    }
}

#[test]
fn sensitivities_that_do_not_fit_are_refused() {
    let start = Start { t: 0.0, y: vec![1.0], ydot: vec![0.0] };
    let short = SensitivityStart { s: vec![vec![0.0]; 2], sdot: vec![vec![0.0]; 3] };
    let system = Sensitive::new(Decay([1.0, 1.0, 1.0]));
    let refused = SensitivitySolver::new(system, start, &short, 1.0, Settings::default()).err();
    let message = refused.map(|error| error.to_string()).unwrap_or_default();
    assert!(message.contains("`s` has 2 entries"), "{message}");
}
