//! What each kind of joint allows, and what it forbids when it is cut.
//!
//! A joint is a list of elementary motions of the successor relative to the predecessor, after a
//! fixed turn. In the tree, each motion is a generalised coordinate. Cut, the joint forbids every
//! other relative motion by constraint rows g = 0, *predecessor minus successor*. Each row carries
//! the wrench that a unit multiplier puts on the successor, so that −Gᵀλ and the joint reaction are
//! the same force by construction. In a plane, the rows of the third dimension fold to 0 = 0 and
//! are dropped.

use bksim_expr::{Expr, Pool};

use crate::pose::Pose;
use crate::spatial::{self, Rotation, z_axis};
use bksim_model::{Joint, JointKind, MotionKind, Vector};

/// One elementary motion, with its axis in the frame it starts from.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// Turning or sliding.
    pub kind: MotionKind,
    /// Unit vector.
    pub axis: Vector,
}

/// One constraint row of a cut joint.
#[derive(Clone, Debug)]
pub struct Row {
    /// g, zero when the joint holds.
    pub constraint: Expr,
    /// `x`, `y`, `z` in world axes; `normal` to a slot; `angle`, `length`.
    pub direction: &'static str,
    /// Force on the successor at its joint point for λ = 1, world axes.
    pub force: Vector,
    /// Moment on the successor about its joint point for λ = 1, world axes.
    pub moment: Vector,
}

/// The two sides of a joint in the world: the poses of its bodies and the places of its points.
pub struct Sides<'a> {
    /// Pose of the first body.
    pub predecessor: &'a Pose,
    /// Pose of the second body.
    pub successor: &'a Pose,
    /// Joint point on the first body, world axes.
    pub p_world_predecessor: Vector,
    /// Joint point on the second body, world axes.
    pub p_world_successor: Vector,
}

/// The motions that `joint` allows, in the order of its coordinates.
pub fn motions(pool: &Pool, joint: &Joint) -> Vec<Motion> {
    let rotation = |axis| Motion { kind: MotionKind::Rotation, axis };
    let translation = Motion { kind: MotionKind::Translation, axis: joint.axis };
    match joint.kind {
        JointKind::Revolute => vec![rotation(joint.axis)],
        JointKind::Prismatic { .. } => vec![translation],
        JointKind::PinInSlot => vec![translation, rotation(z_axis(pool))],
        JointKind::Weld { .. } | JointKind::Link { .. } => Vec::new(),
    }
}

/// The fixed turn of the successor against the predecessor, before any motion.
pub fn fixed_turn(pool: &Pool, joint: &Joint) -> Rotation {
    match joint.kind {
        JointKind::Prismatic { angle } | JointKind::Weld { angle } => {
            Rotation::about(pool, &z_axis(pool), angle)
        }
        _ => Rotation::default(),
    }
}

/// The position of each motion of a joint as the two poses show it, whether or not it is cut.
pub fn positions(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Expr> {
    let offset = spatial::sub(pool, &sides.p_world_successor, &sides.p_world_predecessor);
    let relative = relative_rotation(pool, joint, sides);
    let position = |motion: Motion| match motion.kind {
        MotionKind::Translation => {
            let along = sides.predecessor.rotation.apply(pool, &motion.axis);
            spatial::dot(pool, &along, &offset)
        }
        MotionKind::Rotation => relative.angle_about(pool, &motion.axis).unwrap_or_else(|| {
            // Not one turn about the axis by form alone: measure how a normal of it has turned.
            let [e1, e2] = spatial::perpendicular(pool, &motion.axis);
            let turned = relative.apply(pool, &e1);
            pool.atan2(spatial::dot(pool, &e2, &turned), spatial::dot(pool, &e1, &turned))
        }),
    };
    motions(pool, joint).into_iter().map(position).collect()
}

/// Wrench on the successor, at its joint point, of a unit effort in the given motion.
pub fn effort(pool: &Pool, motion: Motion, sides: &Sides) -> (Vector, Vector) {
    let axis_world = sides.predecessor.rotation.apply(pool, &motion.axis);
    match motion.kind {
        MotionKind::Translation => (axis_world, spatial::zero(pool)),
        MotionKind::Rotation => (spatial::zero(pool), axis_world),
    }
}

/// The constraint rows of `joint` when it is cut.
pub fn constraints(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let z = z_axis(pool);
    let mut rows = match joint.kind {
        JointKind::Revolute => {
            let mut rows = points_together(pool, sides);
            rows.extend(axes_parallel(pool, &joint.axis, sides));
            rows
        }
        JointKind::Weld { .. } => {
            let mut rows = points_together(pool, sides);
            rows.extend(frames_locked(pool, joint, sides));
            rows
        }
        JointKind::Prismatic { .. } => {
            let mut rows = point_on_line(pool, &joint.axis, sides);
            rows.extend(frames_locked(pool, joint, sides));
            rows
        }
        JointKind::PinInSlot => {
            let mut rows = point_on_line(pool, &joint.axis, sides);
            rows.extend(axes_parallel(pool, &z, sides));
            rows
        }
        JointKind::Link { length } => vec![distance(pool, length, sides)],
    };
    rows.retain(|row| !pool.is_zero(pool.simplify(row.constraint)));
    rows
}

/// r_P − r_Q = 0 along the world axes.
fn points_together(pool: &Pool, sides: &Sides) -> Vec<Row> {
    let gap = spatial::sub(pool, &sides.p_world_predecessor, &sides.p_world_successor);
    let unit = |i: usize| {
        let mut axis = spatial::zero(pool);
        axis[i] = pool.one();
        axis
    };
    let row = |i: usize| Row {
        constraint: gap[i],
        direction: ["x", "y", "z"][i],
        force: unit(i),
        moment: spatial::zero(pool),
    };
    (0..3).map(row).collect()
}

/// e · (r_P − r_Q) = 0 for the normals e of a line fixed in the predecessor.
///
/// The force acts where the pin is, so its moment on the predecessor is about that place.
fn point_on_line(pool: &Pool, axis: &Vector, sides: &Sides) -> Vec<Row> {
    let gap = spatial::sub(pool, &sides.p_world_predecessor, &sides.p_world_successor);
    let row = |normal: Vector| {
        let normal_world = sides.predecessor.rotation.apply(pool, &normal);
        Row {
            constraint: spatial::dot(pool, &normal_world, &gap),
            direction: "normal",
            force: normal_world,
            moment: spatial::zero(pool),
        }
    };
    spatial::perpendicular(pool, axis).into_iter().map(row).collect()
}

/// e · n = 0 for the normals e of the axis in the predecessor and the axis n in the successor.
fn axes_parallel(pool: &Pool, axis: &Vector, sides: &Sides) -> Vec<Row> {
    let n_world = sides.successor.rotation.apply(pool, axis);
    let row = |normal: Vector| {
        let normal_world = sides.predecessor.rotation.apply(pool, &normal);
        perpendicular_row(pool, &normal_world, &n_world)
    };
    spatial::perpendicular(pool, axis).into_iter().map(row).collect()
}

/// No relative rotation: one angle where the axes are parallel by form, else three right angles
/// between unlike axes of the two frames.
fn frames_locked(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let relative = relative_rotation(pool, joint, sides);
    match relative.turns() {
        [] => Vec::new(),
        [turn] => {
            let axis_world = sides.predecessor.rotation.apply(pool, &turn.axis);
            vec![Row {
                constraint: pool.neg(turn.angle),
                direction: "angle",
                force: spatial::zero(pool),
                moment: axis_world,
            }]
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
fn perpendicular_row(pool: &Pool, a: &Vector, b: &Vector) -> Row {
    Row {
        constraint: spatial::dot(pool, a, b),
        direction: "angle",
        force: spatial::zero(pool),
        moment: spatial::cross(pool, a, b),
    }
}

/// (d·d − L²) / (2L) = 0, whose multiplier is the pull of the link in newtons and which needs no
/// square root; the caller guarantees L > 0.
fn distance(pool: &Pool, length: Expr, sides: &Sides) -> Row {
    let d = spatial::sub(pool, &sides.p_world_predecessor, &sides.p_world_successor);
    let excess = pool.sub(spatial::dot(pool, &d, &d), pool.mul(length, length));
    Row {
        constraint: pool.div(excess, pool.mul(pool.int(2), length)),
        direction: "length",
        force: spatial::scale(pool, pool.div(pool.one(), length), &d),
        moment: spatial::zero(pool),
    }
}

/// r_P-frame-after-the-fixed-turn from r_Q: the rotation that the motions make up.
fn relative_rotation(pool: &Pool, joint: &Joint, sides: &Sides) -> Rotation {
    let undo = sides.predecessor.rotation.then(pool, &fixed_turn(pool, joint)).inverse(pool);
    undo.then(pool, &sides.successor.rotation)
}
