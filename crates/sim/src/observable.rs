//! Measures of the motion as functions of a sample.

use bksim_expr::{Expr, SymbolId, TapeError};
use bksim_mbs::reaction::reported_force;
use bksim_mbs::spatial;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{Frame, JointId, Measure, Model};

use crate::function::{Buffers, Function};

/// Expressions that a measure is made of: itself, the axis of a component of a reaction, or none.
fn outputs(measure: Measure, model: &Model, system: &SymbolicSystem) -> Vec<Expr> {
    match measure {
        Measure::Reaction(_, Frame::World, _) | Measure::Resultant(..) => Vec::new(),
        Measure::Reaction(joint, Frame::Body, component) => {
            let axis = spatial::axes(&model.pool)[component % 3];
            let sides = system.kinematics.sides(model, &model.joints[joint.0]);
            sides.predecessor.rotation.apply(&model.pool, &axis).to_vec()
        }
        _ => {
            let of_motion = || system.kinematics.measure(model, measure);
            vec![reported_force(model, system, measure).unwrap_or_else(of_motion)]
        }
    }
}

/// Measures at one set of parameters, with their buffers.
#[derive(Clone, Debug)]
pub struct Observables {
    all: Vec<Measure>,
    /// Numbers of expressions of each.
    n_outputs: Vec<usize>,
    function: Function,
    buffers: Buffers,
    /// Multipliers where none are given.
    unknown: Vec<f64>,
}

impl Observables {
    /// The measure of a name, as [`Measure::named`] knows it, if a sample gives it: efforts of drives are multipliers.
    pub fn named(model: &Model, name: &str) -> Option<Measure> {
        Measure::named(model, name).filter(|measure| !matches!(measure, Measure::Effort(_)))
    }

    /// Compiles measures as functions of coordinates, velocities, accelerations, multipliers and reactions.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither a parameter nor part of the state.
    ///
    /// # Panics
    /// If `parameters` are not as many as in the model.
    pub fn compile(
        model: &Model,
        system: &SymbolicSystem,
        measures: &[Measure],
        parameters: &[f64],
    ) -> Result<Self, TapeError> {
        let outputs: Vec<Vec<Expr>> =
            measures.iter().map(|&measure| outputs(measure, model, system)).collect();
        let n_outputs = outputs.iter().map(Vec::len).collect();
        let coordinates = system.coordinates();
        let q: Vec<SymbolId> = coordinates.iter().map(|c| c.q).collect();
        let v: Vec<SymbolId> = coordinates.iter().map(|c| c.v).collect();
        let a: Vec<SymbolId> = coordinates.iter().map(|c| c.a).collect();
        let lambda: Vec<SymbolId> = system.constraints.iter().map(|row| row.lambda).collect();
        let symbols: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
        let function =
            Function::compile(model, &outputs.concat(), &[&q, &v, &a, &lambda], &symbols)?;
        let buffers = function.buffers(parameters);
        let unknown = vec![f64::NAN; lambda.len()];
        Ok(Self { buffers, all: measures.to_vec(), n_outputs, function, unknown })
    }

    /// Sets the values of the parameters.
    ///
    /// # Panics
    /// If `parameters` are not as many as in the model.
    pub fn set_parameters(&mut self, parameters: &[f64]) {
        self.buffers = self.function.buffers(parameters);
    }

    /// True if one of these needs the multipliers.
    pub fn need_multipliers(measures: &[Measure]) -> bool {
        measures.iter().any(|m| matches!(m, Measure::Contact(..) | Measure::Force(_)))
    }

    /// Writes the measures at coordinates, velocities, accelerations and multipliers, in the order they were given in;
    /// `reaction` has that of a joint in world axes. Without multipliers what needs them is not a number.
    ///
    /// # Panics
    /// If a length is not that of the model, or `values` are not as many as the measures.
    pub fn at(
        &mut self,
        [q, v, a, lambda]: [&[f64]; 4],
        reaction: &dyn Fn(JointId) -> [f64; 6],
        values: &mut [f64],
    ) {
        let lambda = if lambda.len() == self.unknown.len() { lambda } else { &self.unknown };
        let mut results = self.function.evaluate(&mut self.buffers, &[q, v, a, lambda]);
        assert_eq!(values.len(), self.all.len(), "a value for each measure");
        let measures = self.all.iter().zip(&self.n_outputs);
        for (value, (measure, &n)) in values.iter_mut().zip(measures) {
            let (own, rest) = results.split_at(n);
            results = rest;
            *value = match *measure {
                Measure::Reaction(joint, Frame::World, component) => reaction(joint)[component],
                Measure::Reaction(joint, Frame::Body, component) => {
                    let world = &reaction(joint)[component / 3 * 3..][..3];
                    own.iter().zip(world).map(|(axis, part)| axis * part).sum()
                }
                Measure::Resultant(joint, whole) => {
                    let parts = &reaction(joint)[whole.components()];
                    parts.iter().map(|part| part * part).sum::<f64>().sqrt()
                }
                _ => own[0],
            };
        }
    }
}
