//! Screw joint: the successor turns about an axis of the predecessor, and each turn takes it one lead
//! along the axis.

use bksim_expr::{Expr, Pool};

use super::{JointWrench, Motion, Row, Sides, rotation, rows};
use crate::spatial::{self, Rotation};
use bksim_model::Joint;

pub(super) fn motions(pool: &Pool, joint: &Joint) -> Vec<Motion> {
    vec![Motion { pitch: Some(pitch(pool, joint)), ..Motion::rotation(joint.axis) }]
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// The point stays on the line, the axes are parallel, and p sin(θ − d/p) = 0 with the pitch
/// p = lead/2π, the angle θ and the travel d: near a solution p θ − d, and no angle needs to be counted
/// in turns. The wrench is the one where the row holds.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let mut rows = rows::point_on_line(pool, &joint.axis, sides);
    rows.extend(rows::axes_parallel(pool, &joint.axis, sides));
    let p = pitch(pool, joint);
    let axis_world = sides.predecessor.rotation.apply(pool, &joint.axis);
    let offset = spatial::sub(pool, &sides.p_world_successor, &sides.p_world_predecessor);
    let turned = pool.div(spatial::dot(pool, &axis_world, &offset), p);
    // The sine and cosine of θ, from a normal of the axis.
    let [e1, e2] = spatial::perpendicular(pool, &joint.axis);
    let image = rotation(pool, joint, sides).apply(pool, &e1);
    let [cos, sin] = [e1, e2].map(|e| spatial::dot(pool, &e, &image));
    let defect = pool.sub(pool.mul(sin, pool.cos(turned)), pool.mul(cos, pool.sin(turned)));
    rows.push(Row {
        expression: pool.mul(p, defect),
        direction: "screw",
        wrench: JointWrench {
            force: axis_world,
            moment: spatial::scale(pool, pool.neg(p), &axis_world),
        },
    });
    rows
}

/// The force along the axis that does the work of a unit moment about it, where the joint holds.
pub(super) fn thrust(pool: &Pool, joint: &Joint, sides: &Sides) -> JointWrench {
    let axis_world = sides.predecessor.rotation.apply(pool, &joint.axis);
    let per_pitch = pool.div(pool.one(), pitch(pool, joint));
    JointWrench::of_force(pool, spatial::scale(pool, per_pitch, &axis_world))
}

/// Travel by angle, m/rad.
fn pitch(pool: &Pool, joint: &Joint) -> Expr {
    let lead = joint.kind.lead().expect("the table leads screws here");
    pool.div(lead, pool.mul(pool.int(2), pool.pi()))
}
