//! Point on a curve: the point of the successor follows a curve of the predecessor, or a roller about it does, and
//! the bodies turn as they like. The parameter of the curve is a coordinate without inertia, whose own equation says that the force has no
//! part along the curve.

use bksim_expr::Pool;

use super::{Motion, Row, Sides, rows};
use crate::spatial::{self, Rotation, z_axis};
use bksim_model::Joint;

/// The parameter of the curve; its axis has no meaning.
pub(super) fn motions(pool: &Pool, _: &Joint) -> Vec<Motion> {
    vec![Motion::rotation(z_axis(pool))]
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// r_P + r(s) − r_Q = 0; of a point that lifts off the curve t · (r_P + r(s) − r_Q) = 0: the place is the nearest one.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let Some(on_curve) = &sides.on_curve else { return Vec::new() };
    let offset = sides.predecessor.rotation.apply(pool, &on_curve.offset);
    let here = spatial::add(pool, &sides.p_world_predecessor, &offset);
    if joint.kind.lifts().is_some() {
        return vec![rows::nearest(pool, sides, &here, &on_curve.tangent)];
    }
    rows::points_together(pool, &here, &sides.p_world_successor)
}
