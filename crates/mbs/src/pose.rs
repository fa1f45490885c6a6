//! [`Pose`]: position and rotation of a body, as expressions of the coordinates; frames of points in their bodies.

use bksim_expr::Pool;
use bksim_model::{Anchor, Joint, Model, Vector};

use crate::spatial::{self, Rotation};

/// The pose of a body: the world position of one of its points, and its rotation.
#[derive(Clone, Debug)]
pub struct Pose {
    /// The point, body frame.
    pub anchor_body: Vector,
    /// Position of the pose, world frame.
    pub anchor_world: Vector,
    /// r_world_from_body.
    pub rotation: Rotation,
    /// Angular velocity in world axes, linear in the velocities.
    pub omega: Vector,
}

impl Pose {
    /// Pose with the axes of a frame of the body, which is turned by `r_body_from_frame`.
    #[must_use]
    pub fn with_axes(&self, pool: &Pool, r_body_from_frame: &Rotation) -> Self {
        Self { rotation: self.rotation.then(pool, r_body_from_frame), ..self.clone() }
    }

    /// The world position of a point of the body.
    pub fn position(&self, pool: &Pool, p_body: &Vector) -> Vector {
        let arm = spatial::sub(pool, p_body, &self.anchor_body);
        spatial::add(pool, &self.anchor_world, &self.rotation.apply(pool, &arm))
    }
}

/// The rotation r_body_from_frame of the frame of an anchor.
pub(crate) fn orientation(model: &Model, anchor: Anchor) -> Rotation {
    let pool = &model.pool;
    let Some(point) = anchor.point else { return Rotation::default() };
    let turns = &model.bodies[anchor.body.0].points[point.0].orientation;
    spatial::turned(pool, turns)
}

/// The rotations r_body_from_frame of the frames that a joint has on its two bodies.
pub(crate) fn orientations(model: &Model, joint: &Joint) -> [Rotation; 2] {
    let pool = &model.pool;
    let [predecessor, successor] =
        [joint.predecessor, joint.successor].map(|anchor| orientation(model, anchor));
    [predecessor, successor.then(pool, &spatial::turned(pool, &joint.alignment))]
}

/// An anchor in the frame of its body; without a point, the origin.
pub(crate) fn anchor_in_body(model: &Model, anchor: Anchor) -> Vector {
    match anchor.point {
        Some(point) => model.bodies[anchor.body.0].points[point.0].position,
        None => spatial::zero(&model.pool),
    }
}
