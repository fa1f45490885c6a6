//! Link: a rod without mass keeps the two points at one distance; it is always cut.

use bksim_expr::Pool;

use super::{JointWrench, Motion, Row, Sides};
use crate::spatial::{self, Rotation};
use bksim_model::Joint;

pub(super) fn motions(_: &Pool, _: &Joint) -> Vec<Motion> {
    Vec::new()
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// (d·d − L²) / (2L) = 0 with d = r_P − r_Q, whose multiplier is the pull of the link in newtons and
/// which needs no square root. The reader of models guarantees L > 0.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let length = joint.kind.link_length().expect("the table leads links here");
    let d = spatial::sub(pool, &sides.p_world_predecessor, &sides.p_world_successor);
    let excess = pool.sub(spatial::dot(pool, &d, &d), pool.mul(length, length));
    let force = spatial::scale(pool, pool.div(pool.one(), length), &d);
    vec![Row {
        expression: pool.div(excess, pool.mul(pool.int(2), length)),
        direction: "length",
        wrench: JointWrench::of_force(pool, force),
    }]
}
