//! Free joint: every motion, with names, frames and a start of its own.

use bksim_expr::Pool;

use super::{Motion, Row, Sides};
use crate::spatial::Rotation;
use bksim_model::Joint;

pub(super) fn motions(pool: &Pool, _: &Joint) -> Vec<Motion> {
    let mut motions = Motion::slides(pool);
    motions.extend(Motion::turns(pool));
    motions
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// No rows: a free joint cuts nothing.
pub(super) fn constraint_rows(_: &Pool, _: &Joint, _: &Sides) -> Vec<Row> {
    Vec::new()
}
