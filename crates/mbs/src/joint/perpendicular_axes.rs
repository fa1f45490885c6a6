//! Perpendicular axes: an axis of the predecessor stays perpendicular to one of the successor; nothing
//! holds the points together.

use bksim_expr::Pool;

use super::{Motion, Row, Sides, rows};
use crate::spatial::Rotation;
use bksim_model::Joint;

pub(super) fn motions(pool: &Pool, joint: &Joint) -> Vec<Motion> {
    let mut motions = Motion::slides(pool);
    motions.extend([joint.axis, super::second_axis(joint)].map(Motion::rotation));
    motions
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// The axes are perpendicular.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    vec![rows::axes_perpendicular(pool, &joint.axis, &super::second_axis(joint), sides)]
}
