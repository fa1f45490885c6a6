//! Weld: the two bodies do not move against each other.

use bksim_expr::Pool;

use super::{Motion, Row, Sides, rows};
use crate::spatial::{Rotation, z_axis};
use bksim_model::{Joint, JointKind};

pub(super) fn motions(_: &Pool, _: &Joint) -> Vec<Motion> {
    Vec::new()
}

/// The stated angle about z.
pub(super) fn fixed_turn(pool: &Pool, joint: &Joint) -> Rotation {
    let JointKind::Weld { angle } = joint.kind else { unreachable!("the table leads welds here") };
    Rotation::about(pool, &z_axis(pool), angle)
}

/// r_P − r_Q = 0, and the frames do not turn.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let mut rows =
        rows::points_together(pool, &sides.p_world_predecessor, &sides.p_world_successor);
    rows.extend(rows::frames_locked(pool, joint, sides));
    rows
}
