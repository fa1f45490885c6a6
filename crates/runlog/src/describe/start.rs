//! The consistent start.

use bksim_mbs::quantity::Quantity;
use bksim_sim::start::{Moved, Start};
use serde_json::{Map, Value, json};

use crate::channels::Channels;

use bksim_sim::Mechanism;

/// Values by name, what was given and what became of it, residuals.
pub fn start(mechanism: &Mechanism, start: &Start) -> Value {
    let compiled = &mechanism.compiled;
    let lambda = start.sampled_multipliers(compiled, &mechanism.parameters);
    let moved = |m: &Moved| {
        json!({
            "name": m.name, "given": m.stated, "found": m.found,
            "moved": m.found - m.stated, "guess": m.is_guess,
        })
    };
    let not_unique: Vec<&str> = start
        .not_unique_rows()
        .iter()
        .map(|&row| compiled.multipliers[row].name.as_str())
        .collect();
    json!({
        "model": mechanism.model.name,
        "t": start.t,
        "q": by_name(&compiled.coordinates, &start.q),
        "v": by_name(&compiled.coordinates, &start.v),
        "a": by_name(&compiled.coordinates, &start.a),
        "lambda": by_name(&compiled.multipliers, &lambda),
        "lambda_not_unique": not_unique,
        "not_unique": Channels::new(mechanism).not_unique(&start.uniqueness),
        "initial": start.moved.iter().map(moved).collect::<Vec<_>>(),
        "residual": { "position": start.position_residual, "velocity": start.velocity_residual },
        "mobility": start.mobility,
    })
}

fn by_name(quantities: &[Quantity], values: &[f64]) -> Value {
    let entries = quantities.iter().zip(values);
    Value::Object(entries.map(|(q, &v)| (q.name.clone(), json!(v))).collect::<Map<_, _>>())
}
