//! Cylindrical joint: the successor slides along an axis of the predecessor and turns about it.

use bksim_expr::Pool;

use super::{Motion, Row, Sides, rows};
use crate::spatial::Rotation;
use bksim_model::Joint;

pub(super) fn motions(_: &Pool, joint: &Joint) -> Vec<Motion> {
    vec![Motion::translation(joint.axis), Motion::rotation(joint.axis)]
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// The point stays on the line, and the axes are parallel.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let mut rows = rows::point_on_line(pool, &joint.axis, sides);
    rows.extend(rows::axes_parallel(pool, &joint.axis, sides));
    rows
}
