//! Equations in the angles of the bodies, and the steps of a derivation, against those in the angles of the joints.

use std::collections::HashMap;

use crate::support::model;
use bksim_expr::{Expr, SymbolId};
use bksim_mbs::assemble::in_absolute_angles;
use bksim_mbs::equations::{Level, ReadingForm, RowName, levels, steps};
use bksim_mbs::system::{Derivation, SymbolicSystem};
use bksim_model::Model;
use bksim_sim::Mechanism;

const FOUR_BAR: &str = include_str!("../../../../examples/four-bar/model.toml");
const QUICK_RETURN: &str = include_str!("../../../../examples/quick-return/model.toml");
const WALKING_BEAM: &str = include_str!("../../../../examples/walking-beam/model.toml");
const PUMP_JACK: &str = include_str!("../../../../examples/pump-jack/model.toml");
const SPRING_PENDULUM: &str = include_str!("../../../../examples/spring-pendulum/model.toml");
const SPATIAL: &str = include_str!("../../../../examples/spatial-four-bar/model.toml");

type Values = HashMap<SymbolId, f64>;

/// A value for each symbol of a state: of parameters their own, of the motion numbers without a pattern.
fn state(mechanism: &Mechanism) -> Values {
    let Mechanism { model, system, parameters, .. } = mechanism;
    let own = model.parameters.iter().map(|parameter| parameter.symbol);
    let mut values: Values = own.zip(parameters.iter().copied()).collect();
    let moving = system.coordinates().iter().flat_map(|c| [c.q, c.v, c.a]);
    let moving = moving.chain(system.constraints.iter().map(|row| row.lambda)).chain([model.time]);
    values.extend(moving.zip(1..).map(|(symbol, k)| (symbol, (1.7 * f64::from(k)).sin())));
    values
}

fn at(model: &Model, e: Expr, values: &Values) -> f64 {
    model.pool.evaluate(e, &|symbol| values.get(&symbol).copied()).expect("a value")
}

fn close(what: &str, found: f64, expected: f64) {
    let scale = 1.0 + found.abs().max(expected.abs());
    assert!((found - expected).abs() < 1e-10 * scale, "{what}: {found}, not {expected}");
}

/// The angles of the bodies and their rates at a state that is given in those of the joints.
fn add_angles(
    model: &Model,
    system: &SymbolicSystem,
    absolute: &SymbolicSystem,
    values: &mut Values,
) {
    for (i, c) in absolute.coordinates().iter().enumerate() {
        let Some(angle) = absolute.kinematics.absolute_angle(i) else { continue };
        let [q, v] = angle.by_joints;
        let levels = [q, v, system.kinematics.second_rate(model, v)];
        let found = levels.map(|e| at(model, e, values));
        values.extend([c.q, c.v, c.a].into_iter().zip(found));
    }
}

#[test]
fn absolute_angles_say_what_relative_ones_say() {
    for text in [FOUR_BAR, QUICK_RETURN, WALKING_BEAM, PUMP_JACK] {
        let mechanism = Mechanism::derive(model(text), Vec::new()).expect("a mechanism");
        let (model, system) = (&mechanism.model, &mechanism.system);
        let pool = &model.pool;
        let absolute = in_absolute_angles(model, system).expect("a planar mechanism");
        let names: Vec<&str> = absolute.coordinates().iter().map(|c| c.name.as_str()).collect();
        assert!(names.iter().any(|name| name.ends_with("_angle")), "{names:?}");
        let mut values = state(&mechanism);
        add_angles(model, system, &absolute, &mut values);
        let [own, other] = [system, &absolute].map(|system| ReadingForm::plain(model, system));

        let energies = |form: &ReadingForm| {
            [&form.kinetic_energy, &form.potential_energy]
                .map(|terms| at(model, pool.sum(terms.iter().copied()), &values))
        };
        for (found, expected) in energies(&other).into_iter().zip(energies(&own)) {
            close(&model.name, found, expected);
        }
        for (found, expected) in other.constraints.iter().zip(&own.constraints) {
            let [found, expected] = [found, expected].map(|terms| pool.sum(terms.iter().copied()));
            close(&model.name, at(model, found, &values), at(model, expected, &values));
        }
        for (found, expected) in levels(model, &absolute).iter().zip(&levels(model, system)) {
            for ((_, found), (_, expected)) in found.rows.iter().zip(&expected.rows) {
                close(&model.name, at(model, *found, &values), at(model, *expected, &values));
            }
        }
        // E_q = (∂θ/∂q)ᵀ E_θ: virtual work is that of either coordinates.
        let left =
            other.left_sides(pool).iter().map(|&e| at(model, e, &values)).collect::<Vec<_>>();
        for (i, e) in own.left_sides(pool).into_iter().enumerate() {
            let q = system.coordinates()[i].q;
            let by_angle = |j: usize| match absolute.kinematics.absolute_angle(j) {
                Some(angle) => at(model, pool.diff(angle.by_joints[0], q), &values),
                None => f64::from(u8::from(i == j)),
            };
            let found: f64 = left.iter().enumerate().map(|(j, e)| by_angle(j) * e).sum();
            close(&model.name, found, at(model, e, &values));
        }
    }
    let spatial = Mechanism::derive(model(SPATIAL), Vec::new()).expect("a mechanism");
    assert!(in_absolute_angles(&spatial.model, &spatial.system).is_none());
}

#[test]
fn the_steps_add_up_to_lagranges_equations() {
    for text in [FOUR_BAR, QUICK_RETURN, SPRING_PENDULUM] {
        let mechanism = Mechanism::derive(model(text), Vec::new()).expect("a mechanism");
        let (model, system) = (&mechanism.model, &mechanism.system);
        let pool = &model.pool;
        assert_eq!(system.derivation, Derivation::Lagrange);
        let form = ReadingForm::grouped(model, system);
        let mut values = state(&mechanism);
        for group in &form.groups {
            let value = at(model, group.definition(pool), &values);
            values.insert(group.symbol, value);
        }
        let found = steps(model, system, &form);
        let row = |name: RowName| {
            let mut rows = found.iter().flat_map(|level: &Level| &level.rows);
            let (_, e) = rows.find(|(own, _)| *own == name).expect("a row");
            at(model, *e, &values)
        };
        for (i, c) in system.coordinates().iter().enumerate() {
            let sum = row(RowName::RateOf(c.v)) - row(RowName::By(c.q)) - row(RowName::Load(c.q))
                + row(RowName::OfConstraints(c.q));
            let expected = pool.sum(form.equation_terms(pool, i));
            close(&format!("{} {}", model.name, c.name), sum, at(model, expected, &values));
        }
        // T − V, and T as the sum over the bodies.
        let whole = |terms: &[Expr]| at(model, pool.sum(terms.iter().copied()), &values);
        let [kinetic, potential] = [&form.kinetic_energy, &form.potential_energy].map(|e| whole(e));
        close("L", row(RowName::Lagrangian), kinetic - potential);
        let of_bodies = model
            .bodies
            .iter()
            .skip(1)
            .map(|body| row(RowName::Symbol(pool.symbol(&format!("T_{}", body.name)))));
        close("T", of_bodies.sum(), kinetic);
    }
    let spatial = Mechanism::derive(model(SPATIAL), Vec::new()).expect("a mechanism");
    let form = ReadingForm::plain(&spatial.model, &spatial.system);
    let is_empty = steps(&spatial.model, &spatial.system, &form).is_empty();
    assert_eq!(is_empty, spatial.system.derivation == Derivation::Recursion);
}
