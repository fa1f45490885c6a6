//! Generalised coordinates: their names, kinds, and the motions that they are.

use bksim_expr::SymbolId;

use bksim_model::{BodyId, JointId, Load, Measure, Model, MotionKind, Signal, StateId};

/// The part of the model whose motion a coordinate is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Owner {
    /// The given motion of a tree joint.
    Joint(JointId, usize),
    /// A free body's translation of the centre of mass along x, y (z), then rotation.
    Body(BodyId, usize),
    /// The given part of the quaternion by which a body turns, freely or in its tree joint.
    Quaternion(BodyId, usize),
    /// A state, which is the velocity of this coordinate.
    State(StateId),
}

/// Measure of a coordinate.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum CoordinateKind {
    /// An angle, rad.
    Angle,
    /// A length, m.
    Length,
    /// A part of a unit quaternion.
    Quaternion,
    /// The integral of a state over time.
    Integral,
}

impl CoordinateKind {
    /// SI unit of the value; empty of a pure number, and of an integral, whose state has one of its own.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Angle => "rad",
            Self::Length => "m",
            Self::Quaternion | Self::Integral => "",
        }
    }
}

impl From<MotionKind> for CoordinateKind {
    fn from(kind: MotionKind) -> Self {
        match kind {
            MotionKind::Rotation => Self::Angle,
            MotionKind::Translation => Self::Length,
        }
    }
}

/// A generalised coordinate.
#[derive(Clone, Debug)]
pub struct Coordinate {
    /// Identifier of the value.
    pub name: String,
    /// Identifier of the velocity: `…_dot`, but the name of a state.
    pub rate_name: String,
    /// Identifier of the acceleration.
    pub second_rate_name: String,
    /// Symbol of the value, in the unit of its kind.
    pub q: SymbolId,
    /// Symbol of its velocity.
    pub v: SymbolId,
    /// Symbol of its acceleration.
    pub a: SymbolId,
    /// Angle, length or part of a quaternion.
    pub kind: CoordinateKind,
    /// The joint or body whose motion it is.
    pub owner: Owner,
}

/// True where the bodies of a tree joint turn by a quaternion: they turn about all axes, and nothing in the
/// model uses an angle of theirs.
pub fn turns_by_quaternion(model: &Model, joint: JointId) -> bool {
    let of = &model.joints[joint.0];
    let is_angle = |id: JointId, motion_idx: usize| id == joint && of.kind.turns(motion_idx);
    let is_loaded =
        |load: &Load| load.kind.joint_motion().is_some_and(|(joint, idx)| is_angle(joint, idx));
    let is_read = |signal: &Signal| match signal.measure {
        Measure::JointPosition(joint, idx) | Measure::JointVelocity(joint, idx) => {
            is_angle(joint, idx)
        }
        _ => false,
    };
    of.kind.turns_freely()
        && of.coordinate_names.is_empty()
        && !model.drives.iter().any(|drive| is_angle(drive.joint, drive.motion_idx))
        && !model.loads.iter().any(is_loaded)
        && !model.signals.iter().any(is_read)
}
