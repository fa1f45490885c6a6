//! Order of convergence with fixed steps, of every part of the state, and of the dense output.

use bksim_dae::{Control, Order, Settings, Stages, Start, StepControl, solve};

use crate::common::mechanism::{Form, Formulated};
use crate::common::problems::{ImplicitCubic, Pendulum};
use crate::common::{Differentiated, fitted_order, max_error};

fn fixed(h: f64, stages: Stages) -> Settings {
    let step = StepControl::Fixed { h, newton_tolerance: 1e-13 };
    Settings { step, order: Order::Fixed(stages), ..Settings::default() }
}

/// Pendulum of length and gravity one, released from the horizontal, over one unit of time.
fn pendulum_end(form: Form, h: f64, stages: Stages) -> [Vec<f64>; 3] {
    let mechanism = Pendulum { m: 1.0, length: 1.0, g: 1.0 };
    let formulated = Formulated { mechanism, form };
    // Moving at the start, so that no symmetry hides an order.
    let (v, lambda) = (0.7, 0.49);
    let start = formulated.start([vec![1.0, 0.0], vec![0.0, v], vec![-lambda, -1.0], vec![lambda]]);
    let system = Differentiated::sparse(formulated);
    let end = solve(system, start, 1.0, fixed(h, stages), &mut |_| Control::Continue)
        .expect("fixed steps pass");
    [end.y[..2].to_vec(), end.y[2..4].to_vec(), end.y[4..5].to_vec()]
}

/// Orders of `q`, `v`, `λ` against a much finer solution of order 9.
fn orders(form: Form, stages: Stages, counts: [u32; 4]) -> [f64; 3] {
    let reference = pendulum_end(Form::Index1, 1.0 / 32.0, Stages::Five);
    let steps = counts.map(|count| 1.0 / f64::from(count));
    let ends = steps.map(|h| pendulum_end(form, h, stages));
    [0, 1, 2].map(|part| {
        let errors: Vec<f64> =
            ends.iter().map(|end| max_error(&end[part], &reference[part])).collect();
        fitted_order(&steps, &errors)
    })
}

fn check(form: Form, stages: Stages, counts: [u32; 4], expected: [f64; 3]) {
    let found = orders(form, stages, counts);
    // Order nine reaches rounding before the leading term is alone.
    let allowed = if stages == Stages::Five { 0.5 } else { 0.2 };
    for (part, (found, expected)) in ["q", "v", "λ"].iter().zip(found.iter().zip(expected)) {
        assert!(
            (found - expected).abs() < allowed,
            "{form:?}, {stages:?}: order {found:.2} in {part}, expected {expected}"
        );
    }
}

#[test]
fn three_stages_have_the_orders_of_each_formulation() {
    let counts = [12, 16, 24, 32];
    // HW2 §VII.4 for index 2; Hairer, Lubich, Roche, Lecture Notes in Mathematics 1409 (1989), §6,
    // for index 3: 2s − 1, s and s − 1.
    check(Form::Index3, Stages::Three, counts, [5.0, 3.0, 2.0]);
    check(Form::Index2, Stages::Three, counts, [5.0, 5.0, 3.0]);
    check(Form::Ggl, Stages::Three, counts, [5.0, 5.0, 3.0]);
    check(Form::Index1, Stages::Three, counts, [5.0, 5.0, 5.0]);
}

#[test]
fn one_and_five_stages_have_order_one_and_nine() {
    check(Form::Index1, Stages::One, [64, 96, 128, 192], [1.0, 1.0, 1.0]);
    check(Form::Index1, Stages::Five, [3, 4, 5, 6], [9.0, 9.0, 9.0]);
}

/// Exact solution by a much finer run.
fn cubic_end(h: f64, stages: Stages) -> f64 {
    // y′³ + y′ = 2 at t = 0 with y = −1: y′ = 1.
    let start = Start { t: 0.0, y: vec![-1.0], ydot: vec![1.0] };
    let system = Differentiated::dense(ImplicitCubic);
    solve(system, start, 2.0, fixed(h, stages), &mut |_| Control::Continue)
        .expect("fixed steps pass")
        .y[0]
}

#[test]
fn a_derivative_may_enter_nonlinearly() {
    let exact = cubic_end(0.125, Stages::Seven);
    let steps = [1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0, 1.0 / 6.0];
    let errors = steps.map(|h| (cubic_end(h, Stages::Three) - exact).abs());
    let order = fitted_order(&steps, &errors);
    assert!((4.6..5.6).contains(&order), "order {order:.2} from errors {errors:?}");
}

#[test]
fn dense_output_has_order_four_and_its_derivative_three() {
    // One step from an exact start, so that only the polynomial itself errs: u − y = O(h^{s+1}).
    let errors = |h: f64| {
        let mechanism = Pendulum { m: 1.0, length: 1.0, g: 1.0 };
        let formulated = Formulated { mechanism, form: Form::Index1 };
        let start =
            formulated.start([vec![1.0, 0.0], vec![0.0, 0.7], vec![-0.49, -1.0], vec![0.49]]);
        let run = |t_end: f64, h, stages| {
            let (mut y, mut ydot) = (vec![0.0; 5], vec![0.0; 5]);
            let formulated = Formulated {
                mechanism: Pendulum { m: 1.0, length: 1.0, g: 1.0 },
                form: Form::Index1,
            };
            let system = Differentiated::sparse(formulated);
            let end = solve(system, start.clone(), t_end, fixed(h, stages), &mut |step| {
                step.at(0.7 * h, &mut y);
                step.derivative_at(0.7 * h, &mut ydot);
                Control::Continue
            })
            .expect("fixed steps pass");
            (end, y, ydot)
        };
        let (_, y, ydot) = run(h, h, Stages::Three);
        let (exact, ..) = run(0.7 * h, 0.7 * h, Stages::Seven);
        [max_error(&y[..4], &exact.y[..4]), max_error(&ydot[..4], &exact.ydot[..4])]
    };
    let steps = [0.2, 0.15, 0.1, 0.07];
    let found = steps.map(errors);
    let order = |part: usize| fitted_order(&steps, &found.map(|errors| errors[part]));
    assert!((3.6..4.4).contains(&order(0)), "value: order {:.2}, {found:?}", order(0));
    assert!((2.6..3.4).contains(&order(1)), "slope: order {:.2}, {found:?}", order(1));
}
