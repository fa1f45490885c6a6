//! [`HeldRows`]: slopes of the measures that tell assemblies apart by being held, and of what moves.

use bksim_expr::{Expr, SymbolId, TapeError};
use bksim_mbs::coordinate::CoordinateKind;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{Axis, BodyId, JointId, Measure, Model, MotionKind, Space};

use crate::function::Function;
use crate::linear::rows::LARGEST_DENSE;

/// The slopes that K and the naming of joints need, as one function of (t, q).
#[derive(Clone, Debug)]
pub(crate) struct HeldRows {
    pub(crate) slopes: Function,
    /// Row and coordinate of each slope.
    pub(crate) entries: Vec<(usize, usize)>,
    pub(crate) n_held: usize,
    /// Of each row after those of what is held: the joint or the body that it tells of.
    pub(crate) moving: Vec<Moving>,
    /// The bodies of each joint.
    pub(crate) bodies: Vec<[BodyId; 2]>,
    /// Coordinates that are positions: all but integrals.
    pub(crate) columns: Vec<usize>,
}

/// A row that tells what moves.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Moving {
    Turn(JointId),
    Slide(JointId),
    Body(BodyId),
}

impl HeldRows {
    /// Compiles the rows for the assembly that `model` holds; `None` where it holds none, or is too large for dense
    /// matrices.
    pub(crate) fn compile(
        model: &Model,
        system: &SymbolicSystem,
        parameters: &[SymbolId],
    ) -> Result<Option<Self>, TapeError> {
        let found = model.assembly.as_ref().and_then(|chosen| chosen.found.as_ref());
        let coordinates = system.coordinates();
        let Some(found) = found.filter(|_| coordinates.len() <= LARGEST_DENSE) else {
            return Ok(None);
        };
        let (mut measures, mut moving) = (found.held.clone(), Vec::new());
        for (idx, joint) in model.joints.iter().enumerate() {
            for (motion_idx, motion) in joint.kind.motions().iter().enumerate() {
                measures.push(Measure::JointPosition(JointId(idx), motion_idx));
                moving.push(match motion {
                    MotionKind::Rotation => Moving::Turn(JointId(idx)),
                    MotionKind::Translation => Moving::Slide(JointId(idx)),
                });
            }
        }
        for body in (1..model.bodies.len()).map(BodyId) {
            let places = [Axis::X, Axis::Y, Axis::Z]
                .into_iter()
                .map(|axis| Measure::PointPosition(body, None, axis));
            let turn = (model.space == Space::Planar).then_some(Measure::BodyAngle(body));
            for measure in places.take(if turn.is_some() { 2 } else { 3 }).chain(turn) {
                measures.push(measure);
                moving.push(Moving::Body(body));
            }
        }
        let value = |&measure: &Measure| system.kinematics.measure(model, measure);
        let values: Vec<Expr> = measures.iter().map(value).collect();
        let q: Vec<SymbolId> = coordinates.iter().map(|c| c.q).collect();
        let jacobian = model.pool.jacobian(&values, &q);
        let outputs: Vec<Expr> = jacobian.entries.iter().map(|entry| entry.2).collect();
        let is_position = |&k: &usize| coordinates[k].kind != CoordinateKind::Integral;
        Ok(Some(Self {
            slopes: Function::compile(model, &outputs, &[&[model.time], &q], parameters)?,
            entries: jacobian.entries.iter().map(|&(row, column, _)| (row, column)).collect(),
            n_held: found.held.len(),
            moving,
            bodies: model.joints.iter().map(|j| [j.predecessor.body, j.successor.body]).collect(),
            columns: (0..coordinates.len()).filter(is_position).collect(),
        }))
    }
}
