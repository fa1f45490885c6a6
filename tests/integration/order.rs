//! The observed order of the fixed-step mode, bounded on both sides, for every formulation.
//!
//! Reported multipliers are those of the equations of motion at the output state, so they converge
//! as positions and velocities do. Radau's own velocities of index 3 have order 3 (HW2 §VII.4); their
//! error lies in the direction of M⁻¹Gᵀ, and the projection in the norm of M takes it away.

use crate::support::{brief, derive, example, fitted_order, solve, weighted_error};
use bksim::Motion;
use bksim::model::{Formulation, Model};
use bksim::sim::run::Sample;

/// A part of the state.
type Part = fn(&Sample) -> &Vec<f64>;

const T_END: f64 = 2.0;

/// Numbers of steps; the output times are steps of each.
const N_STEPS: [f64; 6] = [20.0, 28.0, 40.0, 56.0, 80.0, 112.0];

/// The slider-crank, sampled at four times.
fn slider_crank() -> Model {
    let mut model = example("slider-crank");
    model.solve.t_end = T_END;
    model.solve.every = Some(T_END / 4.0);
    model
}

fn exact() -> Motion {
    let mut model = slider_crank();
    (model.solve.rtol, model.solve.atol) = (1e-12, 1e-13);
    solve(&derive(model))
}

/// Worst error of a part of the state over the output times.
fn error(found: &Motion, exact: &Motion, part: Part) -> f64 {
    let pairs = found.samples.iter().zip(&exact.samples).skip(1);
    pairs.map(|(a, b)| weighted_error(part(a), part(b))).fold(0.0, f64::max)
}

#[test]
fn positions_velocities_and_multipliers_converge_with_their_orders() {
    let exact = exact();
    let steps = N_STEPS.map(|n| T_END / n);
    for (formulation, orders) in [
        (Formulation::Ggl, [(4.5, 5.5), (4.6, 5.3), (4.6, 5.3)]),
        (Formulation::Index2, [(4.7, 5.3), (4.7, 5.3), (4.7, 5.3)]),
        (Formulation::Index3, [(4.5, 5.5), (3.8, 5.5), (3.8, 5.5)]),
        (Formulation::Index1, [(4.5, 5.5), (4.5, 5.5), (4.5, 5.5)]),
    ] {
        let motions = steps.map(|h| {
            let mut model = slider_crank();
            model.solve.formulation = formulation;
            (model.solve.step, model.solve.newton_tolerance) = (Some(h), 1e-12);
            solve(&derive(model))
        });
        let parts: [(&str, Part); 3] = [("q", |s| &s.q), ("v", |s| &s.v), ("λ", |s| &s.lambda)];
        for ((what, part), (least, most)) in parts.into_iter().zip(orders) {
            let errors = motions.each_ref().map(|motion| error(motion, &exact, part));
            let order = fitted_order(&steps, &errors);
            assert!(
                (least..most).contains(&order),
                "{formulation:?}: {what} has observed order {order:.2} from errors {}",
                brief(&errors)
            );
        }
    }
}

#[test]
fn a_fixed_step_run_takes_exactly_the_steps_asked_for() {
    let mut model = slider_crank();
    model.solve.step = Some(T_END / 40.0);
    let motion = solve(&derive(model));
    assert_eq!(motion.summary.stats.n_step, 40);
    assert_eq!(motion.summary.stats.n_reject, 0);
}
