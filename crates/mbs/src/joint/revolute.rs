//! Revolute joint: the two points coincide, and the bodies turn about one axis.

use bksim_expr::Pool;

use super::{Motion, Row, Sides, rows};
use crate::spatial::Rotation;
use bksim_model::Joint;

pub(super) fn motions(_: &Pool, joint: &Joint) -> Vec<Motion> {
    vec![Motion::rotation(joint.axis)]
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// r_P − r_Q = 0, and the axes are parallel.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let mut rows =
        rows::points_together(pool, &sides.p_world_predecessor, &sides.p_world_successor);
    rows.extend(rows::axes_parallel(pool, &joint.axis, sides));
    rows
}
