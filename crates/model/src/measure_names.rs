//! Measures by the names that expressions of a model file use, and their units.

use crate::ids::{BodyId, DriveId, JointId, PointId, StateId};
use crate::joint::{MotionKind, motion_words};
use crate::measure::{Axis, Frame, Initial, Measure};
use crate::model::Model;

/// A word of the model file, and what it measures of a body or its point.
pub(crate) type BodyWord = (&'static str, fn(BodyId, Option<PointId>) -> Measure);

/// The measures of a body; a point has the first [`N_POINT_WORDS`], and a start is stated by those up to
/// [`N_START_WORDS`].
#[rustfmt::skip]
pub(crate) const BODY_WORDS: [BodyWord; 36] = {
    use Axis::{X, Y, Z};
    [
        ("x", |b, p| Measure::PointPosition(b, p, X)),
        ("y", |b, p| Measure::PointPosition(b, p, Y)),
        ("z", |b, p| Measure::PointPosition(b, p, Z)),
        ("vx", |b, p| Measure::PointVelocity(b, p, X)),
        ("vy", |b, p| Measure::PointVelocity(b, p, Y)),
        ("vz", |b, p| Measure::PointVelocity(b, p, Z)),
        ("angle", |b, _| Measure::BodyAngle(b)),
        ("rate", |b, _| Measure::BodyRate(b)),
        ("roll", |b, _| Measure::RollPitchYaw(b, X)),
        ("pitch", |b, _| Measure::RollPitchYaw(b, Y)),
        ("yaw", |b, _| Measure::RollPitchYaw(b, Z)),
        ("wx", |b, _| Measure::AngularVelocity(b, Frame::World, X)),
        ("wy", |b, _| Measure::AngularVelocity(b, Frame::World, Y)),
        ("wz", |b, _| Measure::AngularVelocity(b, Frame::World, Z)),
        ("wx_body", |b, _| Measure::AngularVelocity(b, Frame::Body, X)),
        ("wy_body", |b, _| Measure::AngularVelocity(b, Frame::Body, Y)),
        ("wz_body", |b, _| Measure::AngularVelocity(b, Frame::Body, Z)),
        ("cxx", |b, _| Measure::DirectionCosine(b, X, X)),
        ("cxy", |b, _| Measure::DirectionCosine(b, X, Y)),
        ("cxz", |b, _| Measure::DirectionCosine(b, X, Z)),
        ("cyx", |b, _| Measure::DirectionCosine(b, Y, X)),
        ("cyy", |b, _| Measure::DirectionCosine(b, Y, Y)),
        ("cyz", |b, _| Measure::DirectionCosine(b, Y, Z)),
        ("czx", |b, _| Measure::DirectionCosine(b, Z, X)),
        ("czy", |b, _| Measure::DirectionCosine(b, Z, Y)),
        ("czz", |b, _| Measure::DirectionCosine(b, Z, Z)),
        ("e0", |b, _| Measure::Quaternion(b, 0)),
        ("e1", |b, _| Measure::Quaternion(b, 1)),
        ("e2", |b, _| Measure::Quaternion(b, 2)),
        ("e3", |b, _| Measure::Quaternion(b, 3)),
        ("px", |b, _| Measure::Momentum(Some(b), X)),
        ("py", |b, _| Measure::Momentum(Some(b), Y)),
        ("pz", |b, _| Measure::Momentum(Some(b), Z)),
        ("lx", |b, _| Measure::AngularMomentum(Some(b), X)),
        ("ly", |b, _| Measure::AngularMomentum(Some(b), Y)),
        ("lz", |b, _| Measure::AngularMomentum(Some(b), Z)),
    ]
};

/// Number of rows of [`BODY_WORDS`] that a point has.
pub(crate) const N_POINT_WORDS: usize = 6;
/// Number of rows of [`BODY_WORDS`] that a start is stated by.
pub(crate) const N_START_WORDS: usize = 17;

/// Number of rows of [`ACCELERATION_WORDS`] that a point has.
pub(crate) const N_POINT_ACCELERATIONS: usize = 3;

/// Accelerations of a body, which results have but no load; a point has the first three.
#[rustfmt::skip]
pub(crate) const ACCELERATION_WORDS: [BodyWord; 9] = {
    use Axis::{X, Y, Z};
    [
        ("ax", |b, p| Measure::PointAcceleration(b, p, X)),
        ("ay", |b, p| Measure::PointAcceleration(b, p, Y)),
        ("az", |b, p| Measure::PointAcceleration(b, p, Z)),
        ("alx", |b, _| Measure::AngularAcceleration(b, Frame::World, X)),
        ("aly", |b, _| Measure::AngularAcceleration(b, Frame::World, Y)),
        ("alz", |b, _| Measure::AngularAcceleration(b, Frame::World, Z)),
        ("alx_body", |b, _| Measure::AngularAcceleration(b, Frame::Body, X)),
        ("aly_body", |b, _| Measure::AngularAcceleration(b, Frame::Body, Y)),
        ("alz_body", |b, _| Measure::AngularAcceleration(b, Frame::Body, Z)),
    ]
};

/// The owner of the reactions of all joints, where no body or joint has this name: `reactions.A.fx`.
pub(crate) const REACTIONS: &str = "reactions";

/// The owner of the efforts of drives, where no body or joint has this name: `drives.crank`.
pub(crate) const DRIVES: &str = "drives";

/// The components of a reaction; with `_joint` behind them in the axes of its joint.
const REACTION_WORDS: [&str; 6] = ["fx", "fy", "fz", "mx", "my", "mz"];

/// The words of the components of reactions, in the axes of the ground and of joints.
pub(crate) fn reaction_words() -> impl Iterator<Item = String> {
    ["", "_joint"].into_iter().flat_map(|end| REACTION_WORDS.map(|word| format!("{word}{end}")))
}

/// The owner of the measures of all bodies together, where no body or joint has this name.
const ALL: &str = "mechanism";

impl Measure {
    /// The measure of `A.angle`, `rod.vx` or `rod.B.y`, as in the expressions of a model file, or of an
    /// acceleration such as `rod.ax`; `None` when the model has nothing of this name.
    pub fn named(model: &Model, name: &str) -> Option<Self> {
        let parts: Vec<&str> = name.split('.').collect();
        let (&word, owner) = parts.split_last()?;
        match *owner {
            [owner] => of_joint(model, owner, word)
                .or_else(|| of_body(model, owner, None, word))
                .or_else(|| Self::of_all(owner, word)),
            [owner, point] => of_body(model, owner, Some(point), word),
            _ => None,
        }
    }

    /// The measure of all bodies together by its words: `mechanism.px`, `mechanism.lz`.
    pub(crate) fn of_all(owner: &str, word: &str) -> Option<Self> {
        let index = |letter: &str| ["x", "y", "z"].iter().position(|known| *known == letter);
        let axis = |letter: &str| Some([Axis::X, Axis::Y, Axis::Z][index(letter)?]);
        match (owner == ALL).then(|| word.split_at_checked(1))?? {
            ("p", letter) => Some(Self::Momentum(None, axis(letter)?)),
            ("l", letter) => Some(Self::AngularMomentum(None, axis(letter)?)),
            _ => None,
        }
    }

    /// The measure of `fx` or `mz_joint` of the reaction of a joint.
    pub(crate) fn of_reaction(joint: JointId, word: &str) -> Option<Self> {
        let n = REACTION_WORDS.len();
        let place = reaction_words().position(|known| known == word)?;
        let frame = if place < n { Frame::World } else { Frame::Body };
        Some(Self::Reaction(joint, frame, place % n))
    }

    /// SI unit of the measure; empty of a pure number.
    pub fn unit(self, model: &Model) -> &'static str {
        let turns = |joint: JointId, motion_idx: usize| {
            let motions = model.joints[joint.0].kind.motions();
            motions.get(motion_idx) == Some(&MotionKind::Rotation)
        };
        let turned_by = |DriveId(drive): DriveId| {
            model.drives.get(drive).is_some_and(|drive| turns(drive.joint, drive.motion_idx))
        };
        match self {
            Self::JointPosition(joint, idx) if turns(joint, idx) => "rad",
            Self::JointVelocity(joint, idx) if turns(joint, idx) => "rad/s",
            Self::JointAcceleration(joint, idx) if turns(joint, idx) => "rad/s^2",
            Self::JointPosition(..) | Self::PointPosition(..) => "m",
            Self::JointVelocity(..) | Self::PointVelocity(..) => "m/s",
            Self::BodyAngle(_)
            | Self::Turn(..)
            | Self::CardanAngle(..)
            | Self::RollPitchYaw(..) => "rad",
            Self::BodyRate(_) | Self::CardanRate(..) | Self::AngularVelocity(..) => "rad/s",
            // The unit of a state is that of its start: see `Initial::unit`.
            Self::Quaternion(..) | Self::DirectionCosine(..) | Self::State(_) => "",
            Self::AngularAcceleration(..) => "rad/s^2",
            Self::JointAcceleration(..) | Self::PointAcceleration(..) => "m/s^2",
            Self::Effort(drive) if turned_by(drive) => "N m",
            Self::Reaction(_, _, ..3) | Self::Effort(_) => "N",
            Self::Reaction(..) => "N m",
            Self::Momentum(..) => "kg m/s",
            Self::AngularMomentum(..) => "kg m^2/s",
        }
    }
}

impl Initial {
    /// The SI unit of its value; empty of a pure number and of a state without unit.
    pub fn unit<'m>(&self, model: &'m Model) -> &'m str {
        match self.measure {
            Measure::State(StateId(state)) => &model.states[state].units[1],
            measure => measure.unit(model),
        }
    }
}

fn of_joint(model: &Model, owner: &str, word: &str) -> Option<Measure> {
    let joint = model.joints.iter().position(|joint| joint.name == owner)?;
    let motions = model.joints[joint].kind.motions();
    (0..motions.len()).find_map(|idx| {
        let joint = JointId(joint);
        match motion_words(motions, idx).iter().position(|known| *known == word)? {
            0 => Some(Measure::JointPosition(joint, idx)),
            1 => Some(Measure::JointVelocity(joint, idx)),
            _ => Some(Measure::JointAcceleration(joint, idx)),
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
    let [rows, accelerations] = match point {
        Some(_) => [&BODY_WORDS[..N_POINT_WORDS], &ACCELERATION_WORDS[..N_POINT_ACCELERATIONS]],
        None => [&BODY_WORDS[..], &ACCELERATION_WORDS[..]],
    };
    let (_, measure) = rows.iter().chain(accelerations).find(|(known, _)| *known == word)?;
    Some(measure(BodyId(body), point))
}
