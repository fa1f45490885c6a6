//! Parallel axes: an axis of the predecessor and the same axis of the successor keep one direction;
//! nothing holds the points together.

use bksim_expr::Pool;

use super::{Motion, Row, Sides, rows};
use crate::spatial::Rotation;
use bksim_model::Joint;

pub(super) fn motions(pool: &Pool, joint: &Joint) -> Vec<Motion> {
    let mut motions = Motion::slides(pool);
    motions.push(Motion::rotation(joint.axis));
    motions
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// The axes are parallel.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    rows::axes_parallel(pool, &joint.axis, sides)
}
