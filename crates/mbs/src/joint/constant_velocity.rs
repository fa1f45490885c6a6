//! Constant-velocity joint: the two points coincide, and both bodies turn about their axis by the same
//! angle, however the axes are bent; it is always cut.

use bksim_expr::Pool;

use super::{JointWrench, Motion, Row, Sides, rows};
use crate::spatial::{self, Rotation};
use bksim_model::Joint;

pub(super) fn motions(_: &Pool, _: &Joint) -> Vec<Motion> {
    Vec::new()
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// r_P − r_Q = 0, and x_P · y_Q − y_P · x_Q = 0 for two normals of the axis: the relative rotation is
/// one turn about an axis across it.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let mut rows =
        rows::points_together(pool, &sides.p_world_predecessor, &sides.p_world_successor);
    let [x, y] = spatial::perpendicular(pool, &joint.axis);
    let one = rows::axes_perpendicular(pool, &x, &y, sides);
    let other = rows::axes_perpendicular(pool, &y, &x, sides);
    let moment = spatial::sub(pool, &one.wrench.moment, &other.wrench.moment);
    rows.push(Row {
        expression: pool.sub(one.expression, other.expression),
        direction: "angle",
        wrench: JointWrench::of_moment(pool, moment),
    });
    rows
}
