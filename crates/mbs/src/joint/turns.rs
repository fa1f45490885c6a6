//! Turns in sequence: the angles of one, two or three turns from the rotation that they make up, and
//! the moments that do work in one of them alone.

use bksim_expr::{Expr, Pool};

use super::{Motion, motions};
use crate::spatial::{self, Rotation};
use bksim_model::{Joint, MotionKind, Vector};

/// The axes of the rotations among some motions, in their order.
pub(super) fn axes(motions: &[Motion]) -> Vec<Vector> {
    let rotations = motions.iter().filter(|motion| motion.kind == MotionKind::Rotation);
    rotations.map(|motion| motion.axis).collect()
}

/// The angles of turns about some axes that make up `rotation`: one axis; two that are perpendicular;
/// or x, y and z, where the second angle is within ±90°.
pub(super) fn angles(pool: &Pool, rotation: &Rotation, axes: &[Vector]) -> Vec<Expr> {
    match axes {
        [] => Vec::new(),
        [axis] => vec![rotation.angle_about(pool, axis).unwrap_or_else(|| {
            // Not one turn about the axis by form alone: measure how a normal of it has turned.
            let [e1, e2] = spatial::perpendicular(pool, axis);
            let turned = rotation.apply(pool, &e1);
            pool.atan2(spatial::dot(pool, &e2, &turned), spatial::dot(pool, &e1, &turned))
        })],
        [a, b] => {
            // R b = R(a, α) b and Rᵀ a = R(b, −β) a.
            let angle = |image: &Vector, from: &Vector, to: &Vector| {
                pool.atan2(spatial::dot(pool, to, image), spatial::dot(pool, from, image))
            };
            let c = spatial::cross(pool, a, b);
            let alpha = angle(&rotation.apply(pool, b), b, &c);
            let beta = angle(&rotation.apply_inverse(pool, a), a, &c);
            vec![alpha, beta]
        }
        _ => {
            // The third column of Rx Ry Rz, and its first row.
            let [x, _, z] = spatial::axes(pool);
            let column = rotation.apply(pool, &z);
            let row = rotation.apply_inverse(pool, &x);
            let level = pool.sqrt(pool.add(pool.powi(row[0], 2), pool.powi(row[1], 2)));
            vec![
                pool.atan2(pool.neg(column[1]), column[2]),
                pool.atan2(row[2], level),
                pool.atan2(pool.neg(row[1]), row[0]),
            ]
        }
    }
}

/// True where the angles of turns about these axes are read within ±180° from `rotation`, so that they jump there: all but
/// the angle of a rotation that is a turn about the one axis by form.
pub(super) fn are_within_turn(pool: &Pool, rotation: &Rotation, axes: &[Vector]) -> bool {
    match axes {
        [] => false,
        [axis] => rotation.angle_about(pool, axis).is_none(),
        _ => true,
    }
}

/// The axis of each rotation of a joint as the turns before it have turned it, predecessor's frame, with
/// the index of its motion.
pub(super) fn turned_axes(pool: &Pool, joint: &Joint, positions: &[Expr]) -> Vec<(usize, Vector)> {
    let mut turned = Rotation::default();
    let mut axes = Vec::new();
    for (idx, motion) in motions(pool, joint).iter().enumerate() {
        if motion.kind == MotionKind::Rotation {
            axes.push((idx, turned.apply(pool, &motion.axis)));
            turned = turned.then(pool, &Rotation::about(pool, &motion.axis, positions[idx]));
        }
    }
    axes
}

/// The moment on the successor, in the predecessor's frame, whose work in one motion of a joint is its
/// angle, and nothing in its other turns.
pub(super) fn effort_axis(
    pool: &Pool,
    joint: &Joint,
    motion_idx: usize,
    positions: &[Expr],
) -> Vector {
    let turned = turned_axes(pool, joint, positions);
    let own = turned.iter().position(|&(idx, _)| idx == motion_idx).unwrap_or_default();
    let axes: Vec<Vector> = turned.into_iter().map(|(_, axis)| axis).collect();
    // Of one axis, or of perpendicular ones, the axis itself; else the dual of it.
    let [_, second, _] = axes.as_slice() else { return axes[own] };
    if own == 1 {
        return *second;
    }
    let across = spatial::cross(pool, &axes[(own + 1) % 3], &axes[(own + 2) % 3]);
    let volume = spatial::dot(pool, &axes[own], &across);
    spatial::scale(pool, pool.div(pool.one(), volume), &across)
}
