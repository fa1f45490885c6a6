//! Perpendicular axes: an axis of the predecessor stays perpendicular to one of the successor; nothing
//! holds the points together.

use bksim_expr::Pool;

use super::{Motion, Row, Sides, rows};
use crate::spatial::Rotation;
use bksim_model::{Joint, JointKind, Vector};

pub(super) fn motions(pool: &Pool, joint: &Joint) -> Vec<Motion> {
    let mut motions = Motion::slides(pool);
    motions.extend([joint.axis, second(joint)].map(Motion::rotation));
    motions
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// The axes are perpendicular.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    vec![rows::axes_perpendicular(pool, &joint.axis, &second(joint), sides)]
}

fn second(joint: &Joint) -> Vector {
    let JointKind::PerpendicularAxes { second } = joint.kind else {
        unreachable!("the table leads perpendicular axes here")
    };
    second
}
