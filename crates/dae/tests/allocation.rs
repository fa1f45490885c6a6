//! Once running, no step allocates, whatever the method, the kernel and the order.

mod common;

use bksim_dae::{
    ExplicitSolver, Layout, LinearSolver, NotFinite, Ode, Order, SensitivitySolver,
    SensitivityStart, SensitivitySystem, Settings, Solver, Stages, Start, Tolerance,
};

use common::by_hand::AndrewsByHand;
use common::mechanism::{Form, Formulated};
use common::problems::Andrews;
use common::reference::Reference;
use common::uniform;

fn settings(order: Order, linear_solver: LinearSolver) -> Settings {
    let atol = Tolerance::Scalar(1e-7);
    Settings { rtol: 1e-7, atol, order, linear_solver, ..Settings::default() }
}

fn andrews() -> (AndrewsByHand, Start, f64) {
    let data = Reference::load("andrews");
    let system = AndrewsByHand::from(&data);
    let initial = ["q", "v", "a", "lam"].map(|part| data.initial(part));
    let t_end = data.t_end();
    let start = Formulated { mechanism: Andrews { data }, form: Form::Index2 }.start(initial);
    (system, start, t_end)
}

/// Allocations during a run after its first `warm` steps, and the steps after them.
fn allocations(warm: usize, mut step: impl FnMut() -> bool) -> (u64, usize) {
    assert!((0..warm).all(|_| step()), "more than {warm} steps");
    let mut n_steps = 0;
    let info = allocation_counter::measure(|| {
        while step() {
            n_steps += 1;
        }
    });
    (info.count_total, n_steps)
}

#[test]
fn the_counter_counts() {
    let info = allocation_counter::measure(|| drop(std::hint::black_box(vec![0.0f64; 100])));
    assert_eq!(info.count_total, 1);
}

#[test]
fn no_step_of_radau_allocates_changes_of_order_included() {
    let orders = [Order::Auto, Order::Fixed(Stages::Three), Order::Fixed(Stages::Seven)];
    for order in orders {
        let (system, start, t_end) = andrews();
        let mut solver =
            Solver::new(system, start, t_end, settings(order, LinearSolver::Dense)).expect("valid");
        let mut stages = Vec::with_capacity(10_000);
        let mut step = || {
            let step = solver.step().expect("no failure");
            stages.extend(step.map(|step| step.n_stages()));
            step.is_some()
        };
        // No warming: all buffers exist from the start.
        let (count, n_steps) = allocations(0, &mut step);
        assert!(n_steps > 20, "{n_steps} steps");
        assert_eq!(count, 0, "{order:?}: {count} allocations in {n_steps} steps");
        stages.dedup();
        assert!(order != Order::Auto || stages.len() > 1, "the order changed: {stages:?}");
    }
}

#[test]
fn no_step_with_the_sparse_kernel_allocates_once_its_factors_exist() {
    let (system, start, t_end) = andrews();
    let settings = settings(Order::Fixed(Stages::Three), LinearSolver::Sparse);
    let mut solver = Solver::new(system, start, t_end, settings).expect("valid");
    let step = || solver.step().expect("no failure").is_some();
    let (count, n_steps) = allocations(20, step);
    assert!(n_steps > 100, "{n_steps} steps");
    assert_eq!(count, 0, "{count} allocations in {n_steps} steps");
}

/// A pendulum by its angle.
struct Angle(Layout);

impl Ode for Angle {
    fn layout(&self) -> &Layout {
        &self.0
    }
    fn derivative(&mut self, _t: f64, y: &[f64], ydot: &mut [f64]) -> Result<(), NotFinite> {
        ydot.copy_from_slice(&[y[1], -y[0].sin()]);
        Ok(())
    }
}

#[test]
fn no_explicit_step_allocates() {
    let start = Start { t: 0.0, y: vec![2.0, 0.0], ydot: vec![0.0; 2] };
    let settings = settings(Order::Auto, LinearSolver::Auto);
    let mut solver = ExplicitSolver::new(Angle(uniform(2)), start, 50.0, settings).expect("valid");
    let step = || solver.step().expect("no failure").is_some();
    let (count, n_steps) = allocations(0, step);
    assert!(n_steps > 20, "{n_steps} steps");
    assert_eq!(count, 0, "{count} allocations in {n_steps} steps");
}

impl SensitivitySystem for AndrewsByHand {
    fn n_parameters(&self) -> usize {
        1
    }
    /// The drive's moment acts on the first coordinate.
    fn parameter_jacobian(
        &mut self,
        _t: f64,
        _y: &[f64],
        _ydot: &[f64],
        out: &mut [f64],
    ) -> Result<(), NotFinite> {
        out.fill(0.0);
        out[7] = -1.0;
        Ok(())
    }
}

#[test]
fn no_step_with_sensitivities_allocates_once_pivots_are_chosen() {
    let (system, start, t_end) = andrews();
    let zero = SensitivityStart { s: vec![vec![0.0; 20]], sdot: vec![vec![0.0; 20]] };
    let settings = settings(Order::Auto, LinearSolver::Auto);
    let mut solver = SensitivitySolver::new(system, start, &zero, t_end, settings).expect("valid");
    let step = || solver.step().expect("no failure").is_some();
    let (count, n_steps) = allocations(1, step);
    assert!(n_steps > 20, "{n_steps} steps");
    assert_eq!(count, 0, "{count} allocations in {n_steps} steps");
}
