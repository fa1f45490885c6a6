//! Pin in a slot: the point of the successor slides along an axis of the predecessor, and the
//! bodies turn about z.

use bksim_expr::Pool;

use super::{Motion, Row, Sides, rows};
use crate::spatial::{Rotation, z_axis};
use bksim_model::Joint;

pub(super) fn motions(pool: &Pool, joint: &Joint) -> Vec<Motion> {
    vec![Motion::translation(joint.axis), Motion::rotation(z_axis(pool))]
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// The point stays on the line, and the z axes are parallel.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let mut rows = rows::point_on_line(pool, &joint.axis, sides);
    rows.extend(rows::axes_parallel(pool, &z_axis(pool), sides));
    rows
}
