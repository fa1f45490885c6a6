//! Everything that can be read of a mechanism: outputs, energies, reactions, and the states of model exchange.

use std::collections::BTreeSet;

use bksim_analysis::{AnalysisError, pose_quantities};
use bksim_expr::Expr;
use bksim_mbs::coordinate::CoordinateKind;
use bksim_mbs::quantity::coordinate_units;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{ENERGIES, Model, Space, reaction_words};
use bksim_sim::quantities::Quantities;
use bksim_sim::start::Start;

use crate::variable::Variable;

/// Everything that can be read, outputs first.
pub(crate) struct Shown {
    pub(crate) variables: Vec<Variable>,
    pub(crate) expressions: Vec<Expr>,
    pub(crate) n_outputs: usize,
}

impl Shown {
    /// Quantities of a mechanism: the outputs of these names, or all that are usual.
    pub(crate) fn of(
        model: &Model,
        system: &SymbolicSystem,
        start: &Start,
        names: &[String],
    ) -> Result<Self, AnalysisError> {
        let quantities = Quantities::new(model, system);
        let asked = if names.is_empty() { &model.io.outputs } else { names };
        let usual = usual(model, system);
        let others = others(model, start, &quantities);
        let mut outputs = Vec::new();
        for name in asked {
            let known = usual.iter().chain(&others).find(|(variable, _)| variable.name == *name);
            let found = known.cloned().or_else(|| {
                let (value, unit) = quantities.named(name)?;
                Some((Variable::new(name, &unit, "output of the model"), value))
            });
            let near = || model.did_you_mean(name, |_| true);
            let unknown = || AnalysisError::UnknownMeasure { name: name.clone(), near: near() };
            outputs.push(found.ok_or_else(unknown)?);
        }
        let (n_asked, n_usual) = (outputs.len(), usual.len());
        outputs.extend(usual.into_iter().chain(others));
        // The first of a name has it; no output is called as a value that can be set.
        let mut known: BTreeSet<String> = BTreeSet::new();
        known.extend(model.parameters.iter().map(|p| p.name.clone()));
        known.insert("time".to_owned());
        let n_first = if n_asked == 0 { n_usual } else { n_asked };
        let mut n_outputs = 0;
        let mut kept = Vec::new();
        for (place, one) in outputs.into_iter().enumerate() {
            if known.insert(one.0.name.clone()) {
                n_outputs += usize::from(place < n_first);
                kept.push(one);
            }
        }
        let (variables, expressions) = kept.into_iter().unzip();
        Ok(Self { variables, expressions, n_outputs })
    }
}

/// Positions and rates of joints, bodies and points, states and signals.
fn usual(model: &Model, system: &SymbolicSystem) -> Vec<(Variable, Expr)> {
    let pool = &model.pool;
    let quantities = Quantities::new(model, system);
    let mut all = Vec::new();
    for quantity in pose_quantities(model, system) {
        let [unit, rate, _] = quantity.units();
        let value = Variable::new(&quantity.names[0], &unit, "position or angle");
        all.push((value, quantity.value));
        let of_rate = Variable::new(&quantity.names[1], &rate, "its rate");
        all.push((of_rate, system.kinematics.rate(model, quantity.value)));
    }
    let integrals = system.coordinates().iter().filter(|c| c.kind == CoordinateKind::Integral);
    for c in integrals {
        let unit = coordinate_units(model, c)[1].clone();
        all.push((Variable::new(&c.rate_name, &unit, "state"), pool.symbol_expr(c.v)));
    }
    for signal in &model.named_signals {
        let description = if signal.is_output { "output" } else { "signal" };
        let variable = Variable::new(&signal.name, &signal.unit, description);
        let found = quantities.named(&format!("signals.{}", signal.name));
        all.extend(found.map(|(value, _)| (variable, value)));
    }
    for held in model.held.iter().filter(|held| !held.is_count()) {
        let variable = Variable::new(&held.name, "", "signal that is held between events");
        all.push((variable, pool.symbol_expr(held.held)));
    }
    all
}

/// Energies, efforts of drives and couplings, and reactions that are unique.
fn others(model: &Model, start: &Start, quantities: &Quantities<'_>) -> Vec<(Variable, Expr)> {
    let mut named: Vec<(String, &str)> = Vec::new();
    for (field, _) in ENERGIES {
        named.push((format!("energy.{field}"), "energy of all bodies, power of all loads"));
    }
    let unique = &start.uniqueness;
    for (drive, _) in model.drives.iter().zip(&unique.drives).filter(|(_, is_unique)| **is_unique) {
        named.push((format!("drives.{}", drive.name), "effort of the drive"));
    }
    let planar = [true, true, false, false, false, true];
    for (joint, is_unique) in model.joints.iter().zip(&unique.reactions) {
        for (k, word) in reaction_words().take(6).enumerate() {
            if is_unique[k] && (model.space == Space::Spatial || planar[k]) {
                let name = format!("reactions.{}.{word}", joint.name);
                named.push((name, "reaction on the second body of the joint, world axes"));
            }
        }
    }
    let found = named.into_iter().filter_map(|(name, description)| {
        let (value, unit) = quantities.named(&name)?;
        Some((Variable::new(&name, &unit, description), value))
    });
    found.collect()
}

/// The states of model exchange: where all coordinates are free, these; else those of them that are chosen.
pub(crate) fn states(model: &Model, system: &SymbolicSystem, n_free: usize) -> Vec<Variable> {
    let coordinates = system.coordinates();
    let units: Vec<[String; 3]> = coordinates.iter().map(|c| coordinate_units(model, c)).collect();
    let state = |order: usize, k: usize| {
        let of_all = n_free == coordinates.len();
        let is_shared = units.iter().all(|unit| unit[order] == units[0][order]);
        let unit = if of_all {
            &units[k][order]
        } else if is_shared {
            &units[0][order]
        } else {
            ""
        };
        let coordinate = &coordinates[k];
        let description = match (of_all, order) {
            (true, 0) => format!("coordinate {}", coordinate.name),
            (true, 1) => format!("rate {}", coordinate.rate_name),
            (true, _) => format!("acceleration {}", coordinate.second_rate_name),
            (false, 0) => "free coordinate, chosen by pivots".to_owned(),
            (false, 1) => "rate of a free coordinate".to_owned(),
            (false, _) => "acceleration of a free coordinate".to_owned(),
        };
        let name = format!("state[{}]", order * n_free + k + 1);
        Variable::new(&name, unit, &description)
    };
    let all = (0..3).flat_map(|order| (0..n_free).map(move |k| (order, k)));
    all.map(|(order, k)| state(order, k)).collect()
}
