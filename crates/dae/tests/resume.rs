//! Runs saved between two steps and continued: bit for bit as if never interrupted.

use bksim_dae::{
    Checkpoint, ExplicitSolver, Layout, Method, NotFinite, Ode, Order, Settings, SolveError,
    Solver, Start, Stats, System, Tolerance,
};

use crate::common::mechanism::{Form, Formulated};
use crate::common::problems::{Chain, Pendulum, VanDerPol};
use crate::common::reference::Reference;
use crate::common::{Differentiated, uniform};

fn settings(tolerance: f64, order: Order) -> Settings {
    Settings { rtol: tolerance, atol: Tolerance::Scalar(tolerance), order, ..Settings::default() }
}

/// Every step's end, as bits, and the counters.
type Trace = (Vec<Vec<u64>>, Stats);

fn bits(t: f64, y: &[f64]) -> Vec<u64> {
    std::iter::once(t).chain(y.iter().copied()).map(f64::to_bits).collect()
}

fn finish<S: System>(solver: &mut Solver<S>) -> Trace {
    let mut trace = Vec::new();
    while let Some(step) = solver.step().expect("no failure") {
        trace.push(bits(step.t1(), step.y1()));
    }
    (trace, *solver.stats())
}

/// Interrupts a run after each of `after` steps and compares what follows.
fn check<S: System>(make: impl Fn() -> S, start: &Start, t_end: f64, settings: &Settings) {
    let new = || Solver::new(make(), start.clone(), t_end, settings.clone()).expect("valid");
    let undisturbed = finish(&mut new());
    let n = undisturbed.0.len();
    assert!(n > 10, "{n} steps");
    for after in [0, 1, 2, 5, n / 3, n / 2, n - 1] {
        let mut solver = new();
        for _ in 0..after {
            solver.step().expect("no failure");
        }
        let bytes = solver.save().to_bytes();
        drop(solver);
        let saved = Checkpoint::from_bytes(&bytes).expect("its own bytes");
        let mut resumed = Solver::resume(make(), &saved, t_end, settings.clone()).expect("it fits");
        let (trace, stats) = finish(&mut resumed);
        assert_eq!(trace, undisturbed.0[after..], "interrupted after {after} of {n} steps");
        assert_eq!(stats, undisturbed.1);
    }
}

fn pendulum_start(form: Form) -> Start {
    let data = Reference::load("pendulum");
    let initial = ["q", "v", "a", "lam"].map(|name| data.initial(name));
    Formulated { mechanism: Pendulum::from(&data), form }.start(initial)
}

#[test]
fn a_resumed_radau_run_equals_the_undisturbed_one() {
    let make = |form| {
        let mechanism = Pendulum::from(&Reference::load("pendulum"));
        Differentiated::dense(Formulated { mechanism, form })
    };
    for form in [Form::Ggl, Form::Index3] {
        for order in [Order::Auto, Settings::default().order] {
            check(|| make(form), &pendulum_start(form), 2.0, &settings(1e-7, order));
        }
    }
    // Stiff, with Jacobians and factors kept over many steps; forwards and backwards.
    let start = Start { t: 0.0, y: vec![2.0, 0.0], ydot: vec![0.0, -2e6] };
    let stiff = || Differentiated::dense(VanDerPol);
    check(stiff, &start, 1.0, &settings(1e-6, Order::Auto));
    check(|| make(Form::Index2), &pendulum_start(Form::Index2), -2.0, &settings(1e-7, Order::Auto));
}

#[test]
fn a_resumed_run_with_the_sparse_kernel_equals_the_undisturbed_one() {
    let n_links = 16;
    let formulated = || Formulated { mechanism: Chain { n_links }, form: Form::Index2 };
    let q: Vec<f64> =
        (0..2 * n_links).map(|i| if i % 2 == 0 { (i / 2 + 1) as f64 } else { 0.0 }).collect();
    let a: Vec<f64> = (0..2 * n_links).map(|i| if i % 2 == 0 { 0.0 } else { -9.81 }).collect();
    let zero = vec![0.0; 2 * n_links];
    let start = formulated().start([q, zero, a, vec![0.0; n_links]]);
    let make = || Differentiated::sparse(formulated());
    check(make, &start, 0.4, &settings(1e-7, Settings::default().order));
}

/// A harmonic oscillator.
struct Oscillator(Layout);

impl Ode for Oscillator {
    fn layout(&self) -> &Layout {
        &self.0
    }
    fn derivative(&mut self, _t: f64, y: &[f64], ydot: &mut [f64]) -> Result<(), NotFinite> {
        ydot.copy_from_slice(&[y[1], -y[0].sin()]);
        Ok(())
    }
}

#[test]
fn a_resumed_explicit_run_equals_the_undisturbed_one() {
    for t_end in [40.0, -40.0] {
        let settings = settings(1e-9, Order::Auto);
        let start = Start { t: 0.0, y: vec![3.0, 0.0], ydot: vec![0.0; 2] };
        let finish = |solver: &mut ExplicitSolver<Oscillator>| {
            let mut trace = Vec::new();
            while solver.advance().expect("no failure") {
                trace.push(bits(solver.t(), solver.y()));
            }
            (trace, *solver.stats())
        };
        let new = || {
            ExplicitSolver::new(Oscillator(uniform(2)), start.clone(), t_end, settings.clone())
                .expect("valid")
        };
        let undisturbed = finish(&mut new());
        for after in [0, 1, undisturbed.0.len() / 2] {
            let mut solver = new();
            for _ in 0..after {
                solver.advance().expect("no failure");
            }
            let bytes = solver.save().to_bytes();
            let saved = Checkpoint::from_bytes(&bytes).expect("its own bytes");
            let system = Oscillator(uniform(2));
            let mut resumed =
                ExplicitSolver::resume(system, &saved, t_end, settings.clone()).expect("it fits");
            assert_eq!(finish(&mut resumed).0, undisturbed.0[after..]);
            assert_eq!(resumed.stats(), &undisturbed.1);
        }
    }
}

#[test]
fn checkpoints_of_others_are_refused() {
    let start = Start { t: 0.0, y: vec![1.0, 0.0], ydot: vec![0.0; 2] };
    let settings = settings(1e-6, Order::Auto);
    let solver =
        ExplicitSolver::new(Oscillator(uniform(2)), start, 1.0, settings.clone()).expect("valid");
    let saved = solver.save();
    let resume = |saved: &Checkpoint| {
        ExplicitSolver::resume(Oscillator(uniform(2)), saved, 1.0, settings.clone()).err()
    };
    assert_eq!(resume(&saved), None);
    let refused = |saved| matches!(resume(&saved), Some(SolveError::Checkpoint { .. }));
    assert!(refused(Checkpoint { method: Method::Radau, ..saved.clone() }));
    assert!(refused(Checkpoint { reals: saved.reals[..3].to_vec(), ..saved.clone() }));
    let bytes = saved.to_bytes();
    for cut in 0..bytes.len() {
        assert!(Checkpoint::from_bytes(&bytes[..cut]).is_err(), "{cut} of {} bytes", bytes.len());
    }
    let mut huge = bytes.clone();
    huge[16..24].copy_from_slice(&u64::MAX.to_le_bytes());
    assert!(Checkpoint::from_bytes(&huge).is_err());
}
