//! Spherical joint: the two points coincide, and the bodies turn as they like.
//!
//! In the tree the turning is three turns in sequence, about x, y and z of the moving frame; at a
//! second angle of ±90° the first and the third have one axis, and the sequence has a pole.

use bksim_expr::Pool;

use super::{Motion, Row, Sides, rows};
use crate::spatial::Rotation;
use bksim_model::Joint;

/// Turns about x, y, z.
pub(super) fn motions(pool: &Pool, _: &Joint) -> Vec<Motion> {
    Motion::turns(pool)
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// r_P − r_Q = 0.
pub(super) fn constraint_rows(pool: &Pool, _: &Joint, sides: &Sides) -> Vec<Row> {
    rows::points_together(pool, &sides.p_world_predecessor, &sides.p_world_successor)
}
