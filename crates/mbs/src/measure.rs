//! Measures of the motion by their names, and as functions of the state.

use bksim_expr::{Expr, Runner, SymbolId, Tape, TapeError, Workspace};

use crate::assemble::SymbolicSystem;
use crate::joint::{MotionKind, motions};
use crate::model::{Axis, BodyId, JointId, Measure, Model, PointId};

/// The motions of a body or a point by the words of the model file; a point has the first six.
const WORDS: [&str; 8] = ["x", "y", "z", "vx", "vy", "vz", "angle", "rate"];

impl Measure {
    /// What `A.angle`, `rod.vx` or `rod.B.y` measure, as in the expressions of a model file; `None`
    /// when the model has nothing of this name.
    pub fn named(model: &Model, name: &str) -> Option<Self> {
        let parts: Vec<&str> = name.split('.').collect();
        let (&word, owner) = parts.split_last()?;
        match *owner {
            [owner] => of_joint(model, owner, word).or_else(|| of_body(model, owner, None, word)),
            [owner, point] => of_body(model, owner, Some(point), word),
            _ => None,
        }
    }

    /// Its SI unit.
    pub fn unit(self, model: &Model) -> &'static str {
        let turns = |joint: JointId, motion_idx: usize| {
            let motion = motions(&model.pool, &model.joints[joint.0]);
            motion.get(motion_idx).is_some_and(|motion| motion.kind == MotionKind::Rotation)
        };
        match self {
            Self::JointPosition(joint, idx) if turns(joint, idx) => "rad",
            Self::JointVelocity(joint, idx) if turns(joint, idx) => "rad/s",
            Self::JointPosition(..) | Self::PointPosition(..) => "m",
            Self::JointVelocity(..) | Self::PointVelocity(..) => "m/s",
            Self::BodyAngle(_) => "rad",
            Self::BodyRate(_) => "rad/s",
        }
    }
}

fn of_joint(model: &Model, owner: &str, word: &str) -> Option<Measure> {
    let joint = model.joints.iter().position(|joint| joint.name == owner)?;
    let motions = motions(&model.pool, &model.joints[joint]);
    motions.iter().enumerate().find_map(|(idx, motion)| {
        let words = match motion.kind {
            MotionKind::Rotation => ["angle", "rate"],
            MotionKind::Translation => ["position", "velocity"],
        };
        let joint = JointId(joint);
        match words.iter().position(|known| *known == word)? {
            0 => Some(Measure::JointPosition(joint, idx)),
            _ => Some(Measure::JointVelocity(joint, idx)),
        }
    })
}

fn of_body(model: &Model, owner: &str, point: Option<&str>, word: &str) -> Option<Measure> {
    let body = model.bodies.iter().position(|body| body.name == owner)?;
    let points = &model.bodies[body].points;
    let point = match point {
        Some(name) => Some(PointId(points.iter().position(|point| point.name == name)?)),
        None => None,
    };
    let body = BodyId(body);
    let axis = |idx: usize| [Axis::X, Axis::Y, Axis::Z][idx % 3];
    match WORDS.iter().position(|known| *known == word)? {
        idx @ 0..3 => Some(Measure::PointPosition(body, point, axis(idx))),
        idx @ 3..6 => Some(Measure::PointVelocity(body, point, axis(idx))),
        _ if point.is_some() => None,
        6 => Some(Measure::BodyAngle(body)),
        _ => Some(Measure::BodyRate(body)),
    }
}

/// Measures at one set of parameters, with their buffers.
#[derive(Clone, Debug)]
pub struct Measures {
    runner: Runner,
    workspace: Workspace,
    inputs: Vec<f64>,
}

impl Measures {
    /// Compiles measures as functions of the state.
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
        let coordinates = system.coordinates();
        let outputs: Vec<Expr> =
            measures.iter().map(|&measure| system.kinematics.measure(model, measure)).collect();
        let values = coordinates.iter().map(|c| c.q);
        let inputs: Vec<SymbolId> = values.chain(coordinates.iter().map(|c| c.v)).collect();
        let symbols: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
        let tape = Tape::compile(&model.pool, &outputs, &inputs, &symbols)?;
        let workspace = tape.workspace(parameters);
        let runner = Runner::new(tape, model.solve.jit);
        Ok(Self { runner, workspace, inputs: Vec::new() })
    }

    /// Writes the measures at a state, in the order they were given in.
    ///
    /// # Panics
    /// If a length is not that of the model, or `values` are not as many as the measures.
    pub fn at(&mut self, q: &[f64], v: &[f64], values: &mut [f64]) {
        self.inputs.clear();
        self.inputs.extend_from_slice(q);
        self.inputs.extend_from_slice(v);
        self.runner.evaluate(&mut self.workspace, &self.inputs, values);
    }
}
