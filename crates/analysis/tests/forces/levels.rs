//! Equations of a homework: velocity and acceleration equations, free bodies, at states of a run.

use std::collections::HashMap;

use crate::support::model;
use bksim_mbs::equations::{Level, free_bodies, levels, levels_at};
use bksim_model::{Measure, Model, Space};
use bksim_sim::Mechanism;
use bksim_sim::observable::Observables;
use bksim_sim::run::Sample;

const SLIDER_CRANK: &str = include_str!("../../../../examples/slider-crank/model.toml");
const FOUR_BAR: &str = include_str!("../../../../examples/four-bar/model.toml");
const SPATIAL: &str = include_str!("../../../../examples/spatial-four-bar/model.toml");

/// The values of a sample by the names of symbols.
fn values(mechanism: &Mechanism, sample: &Sample) -> HashMap<String, f64> {
    let Mechanism { model, system, parameters, .. } = mechanism;
    let (model, pool): (&Model, _) = (model, &model.pool);
    let mut values: HashMap<String, f64> = HashMap::new();
    values.insert("t".to_owned(), sample.t);
    for (parameter, value) in model.parameters.iter().zip(parameters) {
        values.insert(parameter.name.clone(), *value);
    }
    for (k, c) in system.coordinates().iter().enumerate() {
        let own = [(c.q, sample.q[k]), (c.v, sample.v[k]), (c.a, sample.a[k])];
        values.extend(own.map(|(symbol, value)| (pool.symbol_name(symbol), value)));
    }
    for (row, value) in system.constraints.iter().zip(&sample.lambda) {
        values.insert(pool.symbol_name(row.lambda), *value);
    }
    for (joint, six) in model.joints.iter().zip(&sample.reactions) {
        let words = ["fx", "fy", "fz", "mx", "my", "mz"].iter().zip(six);
        values.extend(words.map(|(word, value)| (format!("{}_{word}", joint.name), *value)));
    }
    for body in model.bodies.iter().skip(1) {
        for word in ["ax", "ay", "az", "alz"] {
            let name = format!("{}.{word}", body.name);
            let measure = Measure::named(model, &name).expect("an acceleration");
            let mut observed =
                Observables::compile(model, system, &[measure], parameters).expect("a tape");
            let mut value = [0.0];
            observed.at(
                [&sample.q, &sample.v, &sample.a, &sample.lambda],
                &|j| sample.reactions[j.0],
                &mut value,
            );
            values.insert(format!("{}_{word}", body.name), value[0]);
        }
    }
    values
}

/// The largest left side of the rows of a level whose symbols all have values, and how many these are.
fn largest(model: &Model, level: &Level, values: &HashMap<String, f64>) -> (f64, usize) {
    let value = |symbol| values.get(&model.pool.symbol_name(symbol)).copied();
    let rows = level.rows.iter().filter_map(|(_, left)| model.pool.evaluate(*left, &value).ok());
    rows.fold((0.0, 0), |(most, n), x| (f64::max(most, x.abs()), n + 1))
}

#[test]
fn free_bodies_are_in_balance_along_runs() {
    for text in [SLIDER_CRANK, FOUR_BAR, SPATIAL] {
        let mut own = model(text);
        (own.solve.t_end, own.solve.every) = (own.solve.t_start + 0.3, Some(0.1));
        let mechanism = Mechanism::derive(own, Vec::new()).expect("a mechanism");
        let samples = mechanism.solve().expect("a run").samples;
        let model = &mechanism.model;
        let level = free_bodies(model, &mechanism.system);
        let n_bodies = model.bodies.len() - 1;
        assert_eq!(level.rows.len(), n_bodies * if model.space == Space::Planar { 3 } else { 6 });
        for sample in [&samples[0], &samples[samples.len() - 1]] {
            let values = values(&mechanism, sample);
            let force =
                sample.reactions.iter().flatten().fold(1.0, |most: f64, x| most.max(x.abs()));
            let (off, n) = largest(model, &level, &values);
            assert!(n >= 3 * n_bodies, "{n} rows of {}", model.name);
            assert!(off < 1e-8 * force, "{}: {off} of {force} N", model.name);
        }
    }
}

#[test]
fn velocity_and_acceleration_equations_hold_in_letters_and_numbers() {
    let mechanism = Mechanism::derive(model(SLIDER_CRANK), Vec::new()).expect("a mechanism");
    let (model, system) = (&mechanism.model, &mechanism.system);
    let samples = mechanism.solve().expect("a run").samples;
    let sample = &samples[samples.len() / 2];
    let values = values(&mechanism, sample);
    let value = |symbol| values.get(&model.pool.symbol_name(symbol)).copied();
    let rate = sample.v.iter().chain(&sample.a).fold(1.0, |most: f64, x| most.max(x.abs()));
    for level in levels(model, system) {
        let (off, n) = largest(model, &level, &values);
        assert_eq!(n, system.constraints.len());
        assert!(off < 1e-9 * rate, "{}: {off}", level.title);
    }
    // Six digits of each number.
    for level in levels_at(model, system, &value) {
        let (off, n) = largest(model, &level, &values);
        assert_eq!(n, system.constraints.len());
        assert!(off < 1e-4 * rate, "{}: {off}", level.title);
        let symbols = level.rows.iter().flat_map(|(_, left)| model.pool.symbols_of(*left));
        let names: Vec<String> = symbols.map(|symbol| model.pool.symbol_name(symbol)).collect();
        assert!(
            !names.is_empty() && !names.iter().any(|name| name == "l1" || name == "theta1"),
            "{names:?}"
        );
    }
}
