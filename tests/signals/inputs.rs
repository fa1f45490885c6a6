//! Parameters that are functions of the motion give the motion that the same law gives as a part of
//! the model.

use std::sync::Arc;

use bksim::model::file::{Source, read};
use bksim::model::{Formulation, Method};
use bksim::sim::input::{Law, find_inputs};
use bksim::{Mechanism, Rejected};

use crate::support::at;

/// A double pendulum with a motor at its shoulder and a damper at its elbow.
const ARM: &str = include_str!("../fixtures/driven-double-pendulum.toml");

/// Arm with these laws of the motor and the damper.
fn arm(motor: &str, damping: &str) -> String {
    let motor = format!("value = \"{motor}\"");
    let damping = format!("damping = \"{damping}\"");
    ARM.replace("value = \"u\"", &motor).replace("damping = \"c\"", &damping)
}

fn with_inputs(text: &str, names: &[&str], law: Arc<Law>) -> Result<Mechanism, Rejected> {
    let mut model = read(&Source::new(text, "arm")).model.expect("a model");
    model.inputs = find_inputs(&model, names).expect("parameters");
    Mechanism::derive_with(model, Some(law), Vec::new())
}

/// The angle of the upper arm, and the damping: both loads at once, the second from the first.
fn place_of_a(mechanism: &Mechanism) -> usize {
    mechanism.compiled.coordinates.iter().position(|c| c.name == "a").expect("a coordinate")
}

#[test]
fn an_input_moves_as_the_same_law_in_the_model() {
    let written = arm(
        "9 N m - 40 N m*(a - 0.5) - 3 N m s*a_dot + 2 N m*sin(3*t/(1 s))",
        "0.2 N m s + 0.1 N m s*a^2",
    );
    let mut own = Mechanism::from_toml(&written, "arm").expect("a model");
    let place = place_of_a(&own);
    let law: Arc<Law> = Arc::new(move |t, q, v, values| {
        values[0] = 9.0 - 40.0 * (q[place] - 0.5) - 3.0 * v[place] + 2.0 * (3.0 * t).sin();
        values[1] = 0.2 + 0.1 * q[place] * q[place];
    });
    let mut by_input = with_inputs(&arm("u", "c"), &["u", "c"], law).expect("a mechanism");
    let methods = [
        (Method::Explicit, Formulation::Ggl),
        (Method::Radau, Formulation::Ggl),
        (Method::Radau, Formulation::Index3),
        (Method::Radau, Formulation::Index2),
        (Method::Radau, Formulation::Index1),
    ];
    for (method, formulation) in methods {
        for mechanism in [&mut own, &mut by_input] {
            mechanism.model.solve.method = method;
            mechanism.model.solve.formulation = formulation;
        }
        let (expected, found) = (own.solve().expect("solves"), by_input.solve().expect("solves"));
        for (expected, found) in expected.samples.iter().zip(&found.samples) {
            let gap = |a: &[f64], b: &[f64]| {
                a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            };
            let what = format!("{method:?}, {formulation:?}, t = {}", found.t);
            assert!(gap(&expected.q, &found.q) < 1e-7, "{what}");
            assert!(gap(&expected.a, &found.a) < 1e-4, "{what}");
            assert!(gap(&expected.lambda, &found.lambda) < 1e-4, "{what}");
            assert!(
                gap(expected.reactions[0].as_slice(), found.reactions[0].as_slice()) < 1e-4,
                "{what}"
            );
            assert!((expected.work - found.work).abs() < 1e-7, "{what}: work");
            let a = found.q[place];
            assert!(
                (found.inputs[1] - 0.2 - 0.1 * a * a).abs() < 1e-9,
                "{what}: {:?}",
                found.inputs
            );
        }
        let balance = found.summary.energy;
        assert!(balance.worst_error < 1e-6 * balance.scale, "{method:?}: {balance:?}");
        let last = at(&found, 1.0);
        assert!(last.inputs[0].abs() > 0.1, "the motor does something");
    }
}

#[test]
fn a_stiff_input_takes_no_more_steps_than_the_same_law_in_the_model() {
    let mut own =
        Mechanism::from_toml(&arm("-2e4 N m*(a - 0.5) - 4e3 N m s*a_dot", "0.1 N m s"), "arm")
            .expect("a model");
    let place = place_of_a(&own);
    let law: Arc<Law> =
        Arc::new(move |_, q, v, values| values[0] = -2e4 * (q[place] - 0.5) - 4e3 * v[place]);
    let mut by_input = with_inputs(&arm("u", "0.1 N m s"), &["u"], law).expect("a mechanism");
    let mut steps = [&mut own, &mut by_input].map(|mechanism| {
        mechanism.model.solve.method = Method::Radau;
        mechanism.solve().expect("solves").summary.stats
    });
    let [expected, found] = &mut steps;
    assert!(found.n_step < expected.n_step * 11 / 10, "{found:?} against {expected:?}");
    assert!(found.n_newton < expected.n_newton * 12 / 10, "{found:?} against {expected:?}");
}

#[test]
fn what_is_more_than_a_part_of_loads_is_no_input() {
    let law: Arc<Law> = Arc::new(|_, _, _, values| values.fill(1.0));
    for name in ["l", "k"] {
        let Err(Rejected(faults)) = with_inputs(&arm("u", "c"), &[name], law.clone()) else {
            panic!("`{name}` is an input");
        };
        assert_eq!(faults[0].code.0, "S013", "{faults:?}");
        assert!(!faults[0].labels.is_empty());
    }
    let model = read(&Source::new(&arm("u", "c"), "arm")).model.expect("a model");
    let unknown = find_inputs(&model, &["w"]).expect_err("no parameter");
    assert_eq!(unknown.0, "w");
}

#[test]
fn a_law_without_a_value_ends_the_run_where_it_ends() {
    let law: Arc<Law> =
        Arc::new(|t, _, _, values| values[0] = if t < 0.4 { 1.0 } else { f64::NAN });
    let mechanism = with_inputs(&arm("u", "0.1 N m s"), &["u"], law).expect("a mechanism");
    let Rejected(faults) = mechanism.solve().expect_err("no value from 0.4 s on");
    assert_eq!(faults[0].code.0, "R002", "{faults:?}");
    assert!(faults[0].message.contains("`u` has no value"), "{faults:?}");
}
