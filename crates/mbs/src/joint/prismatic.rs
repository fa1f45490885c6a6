//! Prismatic joint: the successor slides along an axis of the predecessor and does not turn.

use bksim_expr::Pool;

use super::{Motion, Row, Sides, rows};
use crate::spatial::{Rotation, z_axis};
use bksim_model::{Joint, JointKind};

pub(super) fn motions(_: &Pool, joint: &Joint) -> Vec<Motion> {
    vec![Motion::translation(joint.axis)]
}

/// The stated angle about z.
pub(super) fn fixed_turn(pool: &Pool, joint: &Joint) -> Rotation {
    let JointKind::Prismatic { angle } = joint.kind else {
        unreachable!("the table leads prismatic joints here")
    };
    Rotation::about(pool, &z_axis(pool), angle)
}

/// The point stays on the line, and the frames do not turn.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let mut rows = rows::point_on_line(pool, &joint.axis, sides);
    rows.extend(rows::frames_locked(pool, joint, sides));
    rows
}
