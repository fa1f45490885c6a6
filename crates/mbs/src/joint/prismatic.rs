//! Prismatic joint: the successor slides along an axis of the predecessor and does not turn.

use bksim_expr::Pool;

pub(super) use super::kept_turn as fixed_turn;
use super::{Motion, Row, Sides, rows};
use bksim_model::Joint;

pub(super) fn motions(_: &Pool, joint: &Joint) -> Vec<Motion> {
    vec![Motion::translation(joint.axis)]
}

/// The point stays on the line, and the frames do not turn.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let mut rows = rows::point_on_line(pool, &joint.axis, sides);
    rows.extend(rows::frames_locked(pool, joint, sides));
    rows
}
