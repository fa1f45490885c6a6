//! Rolling: a disc or ball of the successor stays on the plane of x and y of the predecessor's point and does not
//! slip on it.
//!
//! With the normal n of the plane, the axis a of the disc, the radii c of its circle and r of its rim, the lowest place
//! of the rim is from the centre
//!
//! ```text
//! b = c ((n · a) a − n)/s − r n,   s = √(1 − (n · a)²) = |a × n|        normal   c s + r − n · (r_Q − r_P) = 0
//! ```
//!
//! and of the places there of both bodies e · (v_P − v_Q) = 0 along the way of the disc, e = a × n/s, and across it,
//! n × e; of a ball, c = 0, along x and y of the plane. These hold between rates.

use bksim_expr::{Expr, Pool};

use super::{JointWrench, Motion, Row, Sides};
use crate::spatial::{self, Rotation, z_axis};
use bksim_model::{Joint, Vector};

/// No motions that are coordinates.
pub(super) fn motions(_: &Pool, _: &Joint) -> Vec<Motion> {
    Vec::new()
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// The height of the lowest place of the rim, and its slip in both directions.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let Touching { height, normal, along, arm } = Touching::of(pool, joint, sides);
    let across = spatial::cross(pool, &normal, &along);
    let row = |expression: Expr, direction, force: Vector| Row {
        expression,
        direction,
        wrench: JointWrench { force, moment: spatial::cross(pool, &arm, &force) },
    };
    vec![
        row(pool.neg(height), "normal", normal),
        row(pool.zero(), "along", along),
        row(pool.zero(), "across", across),
    ]
}

/// A wheel on its plane, world axes.
struct Touching {
    /// Of the lowest place above the plane, m.
    height: Expr,
    normal: Vector,
    /// Unit vector along the way of the wheel.
    along: Vector,
    /// From the centre to the place, m.
    arm: Vector,
}

impl Touching {
    fn of(pool: &Pool, joint: &Joint, sides: &Sides) -> Self {
        let [circle, rim] = joint.kind.wheel().expect("the table leads wheels here");
        let plane = |axis: &Vector| sides.predecessor.rotation.apply(pool, axis);
        let normal = plane(&z_axis(pool));
        let offset = spatial::sub(pool, &sides.p_world_successor, &sides.p_world_predecessor);
        let above = spatial::dot(pool, &normal, &offset);
        let to_rim = spatial::scale(pool, pool.neg(rim), &normal);
        if pool.is_zero(circle) {
            let [x, ..] = spatial::axes(pool);
            let height = pool.sub(above, rim);
            return Self { height, normal, along: plane(&x), arm: to_rim };
        }
        let axis = sides.successor.rotation.apply(pool, &joint.axis);
        let lean = spatial::dot(pool, &normal, &axis);
        let way = spatial::cross(pool, &axis, &normal);
        let sine = pool.sqrt(spatial::dot(pool, &way, &way));
        let down = spatial::sub(pool, &spatial::scale(pool, lean, &axis), &normal);
        let to_circle = spatial::scale(pool, pool.div(circle, sine), &down);
        Self {
            height: pool.sub(above, pool.add(pool.mul(circle, sine), rim)),
            normal,
            along: spatial::scale(pool, pool.div(pool.one(), sine), &way),
            arm: spatial::add(pool, &to_circle, &to_rim),
        }
    }
}

/// The place of a wheel that is on its plane, world axes; `None` of other joints.
pub(super) fn place(pool: &Pool, joint: &Joint, sides: &Sides) -> Option<Vector> {
    joint.kind.wheel()?;
    let Touching { arm, .. } = Touching::of(pool, joint, sides);
    Some(spatial::add(pool, &sides.p_world_successor, &arm))
}
