//! Measures by the names that expressions of a model file use, and their units.

use crate::ids::{BodyId, JointId, PointId};
use crate::joint::{MotionKind, motion_words};
use crate::measure::{Axis, Measure};
use crate::model::Model;

/// The motions of a body or a point by the words of the model file; a point has the first six.
const WORDS: [&str; 8] = ["x", "y", "z", "vx", "vy", "vz", "angle", "rate"];

impl Measure {
    /// The measure of `A.angle`, `rod.vx` or `rod.B.y`, as in the expressions of a model file; `None`
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
            let motions = model.joints[joint.0].kind.motions();
            motions.get(motion_idx) == Some(&MotionKind::Rotation)
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
    let motions = model.joints[joint].kind.motions();
    (0..motions.len()).find_map(|idx| {
        let joint = JointId(joint);
        match motion_words(motions, idx).iter().position(|known| *known == word)? {
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
