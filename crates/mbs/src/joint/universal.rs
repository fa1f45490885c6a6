//! Universal joint (Cardan, Hooke): the two points coincide, and an axis of the predecessor stays
//! perpendicular to one of the successor, the two arms of the cross.

use bksim_expr::Pool;

use super::{Motion, Row, Sides, rows};
use crate::spatial::Rotation;
use bksim_model::Joint;

pub(super) fn motions(_: &Pool, joint: &Joint) -> Vec<Motion> {
    vec![Motion::rotation(joint.axis), Motion::rotation(super::second_axis(joint))]
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// r_P − r_Q = 0, and the axes are perpendicular.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let mut rows =
        rows::points_together(pool, &sides.p_world_predecessor, &sides.p_world_successor);
    rows.push(rows::axes_perpendicular(pool, &joint.axis, &super::second_axis(joint), sides));
    rows
}
