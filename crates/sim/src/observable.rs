//! Observables of the motion by name: measures, and reactions along the axes of their joints.

use bksim_expr::{Expr, SymbolId, TapeError};
use bksim_mbs::spatial;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{JointId, Measure, Model};

use crate::function::{Buffers, Function};

/// An observable of the motion that has a name.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Observable {
    /// Of positions, velocities and accelerations.
    Measure(Measure),
    /// A component of the reaction of a joint, fx, fy, fz, mx, my, mz, along the axes of its first point's frame.
    ReactionInJoint(JointId, usize),
}

/// The components of a reaction in the axes of its joint.
const IN_JOINT: [&str; 6] =
    ["fx_joint", "fy_joint", "fz_joint", "mx_joint", "my_joint", "mz_joint"];

impl Observable {
    /// The observable of `rod.B.x`, `rod.px` or `A.angle`, as [`Measure::named`] knows them, or of
    /// `reactions.A.fx_joint`.
    pub fn named(model: &Model, name: &str) -> Option<Self> {
        if let Some(measure) = Measure::named(model, name) {
            return Some(Self::Measure(measure));
        }
        let (joint, word) = name.strip_prefix("reactions.")?.rsplit_once('.')?;
        let joint = model.joints.iter().position(|of| of.name == joint).map(JointId)?;
        let component = IN_JOINT.iter().position(|known| *known == word)?;
        Some(Self::ReactionInJoint(joint, component))
    }

    /// SI unit of the observable; empty of a pure number.
    pub fn unit(self, model: &Model) -> &'static str {
        match self {
            Self::Measure(measure) => measure.unit(model),
            Self::ReactionInJoint(_, ..3) => "N",
            Self::ReactionInJoint(..) => "N m",
        }
    }

    /// Expressions of the observable: itself, or the axis of a component in world axes.
    fn outputs(self, model: &Model, system: &SymbolicSystem) -> Vec<Expr> {
        match self {
            Self::Measure(measure) => vec![system.kinematics.measure(model, measure)],
            Self::ReactionInJoint(joint, component) => {
                let axis = spatial::axes(&model.pool)[component % 3];
                let sides = system.kinematics.sides(model, &model.joints[joint.0]);
                sides.predecessor.rotation.apply(&model.pool, &axis).to_vec()
            }
        }
    }
}

/// Observables at one set of parameters, with their buffers.
#[derive(Clone, Debug)]
pub struct Observables {
    all: Vec<Observable>,
    function: Function,
    buffers: Buffers,
}

impl Observables {
    /// Compiles observables as functions of coordinates, velocities, accelerations and reactions.
    ///
    /// # Errors
    /// [`TapeError`] names a symbol that is neither a parameter nor part of the state.
    ///
    /// # Panics
    /// If `parameters` are not as many as in the model.
    pub fn compile(
        model: &Model,
        system: &SymbolicSystem,
        observables: &[Observable],
        parameters: &[f64],
    ) -> Result<Self, TapeError> {
        let outputs: Vec<Expr> =
            observables.iter().flat_map(|observable| observable.outputs(model, system)).collect();
        let coordinates = system.coordinates();
        let q: Vec<SymbolId> = coordinates.iter().map(|c| c.q).collect();
        let v: Vec<SymbolId> = coordinates.iter().map(|c| c.v).collect();
        let a: Vec<SymbolId> = coordinates.iter().map(|c| c.a).collect();
        let symbols: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
        let function = Function::compile(model, &outputs, &[&q, &v, &a], &symbols)?;
        Ok(Self { buffers: function.buffers(parameters), all: observables.to_vec(), function })
    }

    /// Sets the values of the parameters.
    ///
    /// # Panics
    /// If `parameters` are not as many as in the model.
    pub fn set_parameters(&mut self, parameters: &[f64]) {
        self.buffers = self.function.buffers(parameters);
    }

    /// Writes the observables at coordinates, velocities and accelerations, in the order they were given in;
    /// `reaction` has that of a joint in world axes.
    ///
    /// # Panics
    /// If a length is not that of the model, or `values` are not as many as the observables.
    pub fn at(
        &mut self,
        qva: [&[f64]; 3],
        reaction: &dyn Fn(JointId) -> [f64; 6],
        values: &mut [f64],
    ) {
        let mut results = self.function.evaluate(&mut self.buffers, &qva);
        assert_eq!(values.len(), self.all.len(), "a value for each observable");
        for (value, observable) in values.iter_mut().zip(&self.all) {
            let n = if matches!(observable, Observable::Measure(_)) { 1 } else { 3 };
            let (own, rest) = results.split_at(n);
            results = rest;
            *value = match *observable {
                Observable::Measure(_) => own[0],
                Observable::ReactionInJoint(joint, component) => {
                    let world = &reaction(joint)[component / 3 * 3..][..3];
                    own.iter().zip(world).map(|(axis, part)| axis * part).sum()
                }
            };
        }
    }
}
