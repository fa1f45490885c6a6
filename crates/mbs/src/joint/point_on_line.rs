//! Point on a line: the point of the successor slides along an axis of the predecessor, and the bodies
//! turn as they like.

use bksim_expr::Pool;

use super::{Motion, Row, Sides, rows};
use crate::spatial::Rotation;
use bksim_model::Joint;

pub(super) fn motions(pool: &Pool, joint: &Joint) -> Vec<Motion> {
    let mut motions = vec![Motion::translation(joint.axis)];
    motions.extend(Motion::turns(pool));
    motions
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// The point stays on the line.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    rows::point_on_line(pool, &joint.axis, sides)
}
