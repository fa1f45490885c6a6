//! Planar joint: the successor slides in a plane of the predecessor and turns about its normal.

use bksim_expr::Pool;

use super::{Motion, Row, Sides, rows};
use crate::spatial::{self, Rotation};
use bksim_model::Joint;

pub(super) fn motions(pool: &Pool, joint: &Joint) -> Vec<Motion> {
    let [e1, e2] = spatial::perpendicular(pool, &joint.axis);
    vec![Motion::translation(e1), Motion::translation(e2), Motion::rotation(joint.axis)]
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// The point stays in the plane, and the normals are parallel.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let mut rows = vec![rows::point_on_plane(pool, &joint.axis, sides)];
    rows.extend(rows::axes_parallel(pool, &joint.axis, sides));
    rows
}
