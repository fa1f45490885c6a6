//! Cylinder: an actuator, rope or strut without mass between two points, whose length is its one motion; it forbids
//! nothing, and what acts along it pushes the points apart.

use bksim_expr::{Expr, Pool};

use super::{JointWrench, Motion, Row, Sides};
use crate::spatial::{self, Rotation};
use bksim_model::Joint;

/// The length; its axis has no meaning.
pub(super) fn motions(_: &Pool, joint: &Joint) -> Vec<Motion> {
    vec![Motion::translation(joint.axis)]
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// No rows: a cylinder joint is not cut.
pub(super) fn constraint_rows(_: &Pool, _: &Joint, _: &Sides) -> Vec<Row> {
    Vec::new()
}

/// |r_Q − r_P|, m; `None` of other joints.
pub(super) fn length(pool: &Pool, joint: &Joint, sides: &Sides) -> Option<Expr> {
    if !joint.kind.is_cylinder() {
        return None;
    }
    let d = spatial::sub(pool, &sides.p_world_successor, &sides.p_world_predecessor);
    Some(pool.sqrt(spatial::dot(pool, &d, &d)))
}

/// A unit push on the successor, (r_Q − r_P)/|r_Q − r_P|; `None` of other joints.
pub(super) fn push(pool: &Pool, joint: &Joint, sides: &Sides) -> Option<JointWrench> {
    let length = length(pool, joint, sides)?;
    let d = spatial::sub(pool, &sides.p_world_successor, &sides.p_world_predecessor);
    let along = spatial::scale(pool, pool.div(pool.one(), length), &d);
    Some(JointWrench::of_force(pool, along))
}

/// Every motion, that along the line first, for unit vectors in world axes; `None` of other joints.
pub(super) fn motions_in_world(pool: &Pool, joint: &Joint, sides: &Sides) -> Option<Vec<Motion>> {
    let along = push(pool, joint, sides)?.force;
    // Any three directions of which two are independent of the line: with it, they span all.
    let mut motions = vec![Motion::translation(along)];
    motions.extend(Motion::slides(pool));
    motions.extend(Motion::turns(pool));
    Some(motions)
}
