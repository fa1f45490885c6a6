//! Constraint rows that several kinds of joints share.

use bksim_expr::{Expr, Pool};

use super::{JointWrench, Row, Sides, fixed_turn, rotation};
use crate::spatial::{self, Turn};
use bksim_model::{Joint, Vector};

/// r_P − r_Q = 0 along the world axes, for a point of either body.
pub(super) fn points_together(pool: &Pool, p: &Vector, q: &Vector) -> Vec<Row> {
    let gap = spatial::sub(pool, p, q);
    let unit = |i: usize| {
        let mut axis = spatial::zero(pool);
        axis[i] = pool.one();
        axis
    };
    let row = |i: usize| Row {
        expression: gap[i],
        direction: ["x", "y", "z"][i],
        wrench: JointWrench::of_force(pool, unit(i)),
    };
    (0..3).map(row).collect()
}

/// e · (r_P − r_Q) = 0 for the normals e of a line fixed in the predecessor.
///
/// The force acts at the pin, so its moment on the predecessor is about that point.
pub(super) fn point_on_line(pool: &Pool, axis: &Vector, sides: &Sides) -> Vec<Row> {
    let gap = spatial::sub(pool, &sides.p_world_predecessor, &sides.p_world_successor);
    let row = |normal: Vector| {
        let normal_world = sides.predecessor.rotation.apply(pool, &normal);
        Row {
            expression: spatial::dot(pool, &normal_world, &gap),
            direction: "normal",
            wrench: JointWrench::of_force(pool, normal_world),
        }
    };
    spatial::perpendicular(pool, axis).into_iter().map(row).collect()
}

/// t · (p − r_Q) = 0 for a place p on a curve of the predecessor with the tangent t: the place is the nearest one to Q.
pub(super) fn nearest(pool: &Pool, sides: &Sides, place: &Vector, tangent: &Vector) -> Row {
    let length = pool.sqrt(spatial::dot(pool, tangent, tangent));
    let unit = spatial::scale(pool, pool.div(pool.one(), length), tangent);
    let along = sides.predecessor.rotation.apply(pool, &unit);
    let gap = spatial::sub(pool, place, &sides.p_world_successor);
    Row {
        expression: spatial::dot(pool, &along, &gap),
        direction: "tangent",
        wrench: JointWrench::of_force(pool, along),
    }
}

/// n · (r_P − r_Q) = 0 for the normal n of a plane fixed in the predecessor.
pub(super) fn point_on_plane(pool: &Pool, normal: &Vector, sides: &Sides) -> Row {
    let gap = spatial::sub(pool, &sides.p_world_predecessor, &sides.p_world_successor);
    let normal_world = sides.predecessor.rotation.apply(pool, normal);
    Row {
        expression: spatial::dot(pool, &normal_world, &gap),
        direction: "normal",
        wrench: JointWrench::of_force(pool, normal_world),
    }
}

/// a · b = 0 for an axis a of the predecessor and b of the successor.
pub(super) fn axes_perpendicular(pool: &Pool, a: &Vector, b: &Vector, sides: &Sides) -> Row {
    let a_world = sides.predecessor.rotation.apply(pool, a);
    let b_world = sides.successor.rotation.apply(pool, b);
    perpendicular_row(pool, &a_world, &b_world)
}

/// e · n = 0 for the normals e of the axis in the predecessor and the axis n in the successor.
pub(super) fn axes_parallel(pool: &Pool, axis: &Vector, sides: &Sides) -> Vec<Row> {
    let n_world = sides.successor.rotation.apply(pool, axis);
    let row = |normal: Vector| {
        let normal_world = sides.predecessor.rotation.apply(pool, &normal);
        perpendicular_row(pool, &normal_world, &n_world)
    };
    spatial::perpendicular(pool, axis).into_iter().map(row).collect()
}

/// No relative rotation: one angle where the axes are parallel by form, else three right angles
/// between unlike axes of the two frames.
pub(super) fn frames_locked(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let relative = rotation(pool, joint, sides);
    match relative.turns() {
        [] => Vec::new(),
        [Turn::About { axis, angle }] => {
            let axis_world = sides.predecessor.rotation.apply(pool, axis);
            vec![angle_row(pool, pool.neg(*angle), axis_world)]
        }
        _ => {
            let [zero, one] = [pool.zero(), pool.one()];
            let axes = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
            let fixed = fixed_turn(pool, joint);
            let frame = sides.predecessor.rotation.then(pool, &fixed);
            let right_angle = |i: usize| {
                let ours = frame.apply(pool, &axes[i]);
                let theirs = sides.successor.rotation.apply(pool, &axes[(i + 1) % 3]);
                perpendicular_row(pool, &ours, &theirs)
            };
            (0..3).map(right_angle).collect()
        }
    }
}

/// a · b = 0 with a in the predecessor, b in the successor: δ(a·b) = (ω_P − ω_Q)·(a × b).
pub(super) fn perpendicular_row(pool: &Pool, a: &Vector, b: &Vector) -> Row {
    angle_row(pool, spatial::dot(pool, a, b), spatial::cross(pool, a, b))
}

fn angle_row(pool: &Pool, expression: Expr, moment: Vector) -> Row {
    Row { expression, direction: "angle", wrench: JointWrench::of_moment(pool, moment) }
}
