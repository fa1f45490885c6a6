//! Knife edge: a blade of the successor, at its point, moves along its edge and not across it in the plane of x and y of
//! the predecessor's point. The condition holds between rates: it leaves every position free.

use bksim_expr::Pool;

use super::{JointWrench, Motion, Row, Sides};
use crate::folding::short;
use crate::spatial::{self, Rotation, z_axis};
use bksim_model::{Joint, Vector};

/// No motions that are coordinates.
pub(super) fn motions(_: &Pool, _: &Joint) -> Vec<Motion> {
    Vec::new()
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// e · (v_P − v_Q) = 0 where the blade is, for the direction e to its left.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    vec![Row {
        expression: pool.zero(),
        direction: "across",
        wrench: JointWrench::of_force(pool, left(pool, joint, sides)),
    }]
}

/// The unit vector to the left of the blade in the plane, world axes.
pub(super) fn left(pool: &Pool, joint: &Joint, sides: &Sides) -> Vector {
    let normal = sides.predecessor.rotation.apply(pool, &z_axis(pool));
    let blade = sides.successor.rotation.apply(pool, &joint.axis);
    let left = spatial::cross(pool, &normal, &blade);
    let length = short(pool, pool.sqrt(spatial::dot(pool, &left, &left)));
    spatial::scale(pool, pool.div(pool.one(), length), &left)
}
