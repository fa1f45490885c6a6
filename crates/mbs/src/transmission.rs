//! The wrenches that a joint can transmit, whether or not it is cut: all that do no work along the motions
//! it allows, at the successor's joint point in world axes.

use crate::coordinate::turns_by_quaternion;
use crate::joint::{self, JointWrench, Motion};
use crate::kinematics::Kinematics;
use crate::spatial;
use bksim_model::{JointId, Model, Vector};

/// Wrenches that a joint transmits to its successor.
#[derive(Clone, Debug)]
pub struct Transmission {
    /// The joint.
    pub joint: JointId,
    /// The successor's joint point, or the place where two curves touch, world axes, m.
    pub at: Vector,
    /// The axes of the joint, those of its first point's frame: unit vectors in world axes.
    pub frame: [Vector; 3],
    /// Directions of force and moment there.
    pub directions: Directions,
}

/// Directions of the wrenches that a joint transmits.
#[derive(Clone, Debug)]
pub enum Directions {
    /// No force along the axis of a translation and no moment about the axis of a rotation; unit
    /// vectors in world axes.
    AllBut(Vec<Motion>),
    /// A multiple of this wrench alone.
    Alone(JointWrench),
}

/// The wrenches that `joint` can transmit.
pub fn transmission(model: &Model, kinematics: &Kinematics, joint: JointId) -> Transmission {
    let pool = &model.pool;
    let of = &model.joints[joint.0];
    let sides = kinematics.sides(model, of);
    let mut at = sides.p_world_successor;
    let directions = if of.kind.link_length().is_some() {
        let [from, to] = [&sides.p_world_predecessor, &sides.p_world_successor];
        Directions::Alone(JointWrench::of_force(pool, spatial::sub(pool, from, to)))
    } else if let Some(contact) = joint::contact(pool, of, &sides) {
        Directions::Alone(contact)
    } else if let Some((place, motions)) = joint::touch(pool, of, &sides) {
        at = place;
        Directions::AllBut(motions)
    } else {
        // Where no angle is used, three turns have no pole.
        let has_angles = !turns_by_quaternion(model, joint);
        let positions = has_angles.then(|| kinematics.joint_positions(model, joint));
        Directions::AllBut(joint::motions_in_world(pool, of, positions.as_deref(), &sides))
    };
    let frame = spatial::axes(pool).map(|axis| sides.predecessor.rotation.apply(pool, &axis));
    Transmission { joint, at, frame, directions }
}
