//! Point on a plane: the point of the successor slides in a plane of the predecessor, and the bodies
//! turn as they like.

use bksim_expr::Pool;

use super::{Motion, Row, Sides, rows};
use crate::spatial::{self, Rotation};
use bksim_model::Joint;

pub(super) fn motions(pool: &Pool, joint: &Joint) -> Vec<Motion> {
    let [e1, e2] = spatial::perpendicular(pool, &joint.axis);
    let mut motions = vec![Motion::translation(e1), Motion::translation(e2)];
    motions.extend(Motion::turns(pool));
    motions
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// The point stays in the plane.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    vec![rows::point_on_plane(pool, &joint.axis, sides)]
}
