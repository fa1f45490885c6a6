//! Weld: the two bodies do not move against each other.

use bksim_expr::Pool;

pub(super) use super::kept_turn as fixed_turn;
use super::{Motion, Row, Sides, rows};
use bksim_model::Joint;

pub(super) fn motions(_: &Pool, _: &Joint) -> Vec<Motion> {
    Vec::new()
}

/// r_P − r_Q = 0, and the frames do not turn.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let mut rows =
        rows::points_together(pool, &sides.p_world_predecessor, &sides.p_world_successor);
    rows.extend(rows::frames_locked(pool, joint, sides));
    rows
}
