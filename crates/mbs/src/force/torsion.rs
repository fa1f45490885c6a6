//! Torsion spring and damper on a rotation of a joint.

use bksim_expr::Expr;

use super::context::Context;
use super::{Action, Wrench};
use crate::joint;
use crate::spatial;
use bksim_model::{JointId, Vector};

/// V = ½ k (θ − θ₀)² about one rotation of the joint; the damper resists with −c θ′.
pub(super) fn action(
    context: &Context<'_>,
    (joint_id, motion_idx): (JointId, usize),
    stiffness: Expr,
    angle: Expr,
    damping: Expr,
) -> Action {
    let Context { model, pool, kinematics, .. } = *context;
    let joint = &model.joints[joint_id.0];

    // The law, as for a spring between two points.
    let has_potential =
        !pool.is_zero(stiffness) && context.is_constant(stiffness) && context.is_constant(angle);
    let [stiffness, angle, damping] = [stiffness, angle, damping].map(|e| context.resolved(e));
    let positions = kinematics.joint_positions(model, joint_id);
    let position = positions[motion_idx];
    let twist = pool.sub(position, angle);
    let elastic = pool.neg(pool.mul(stiffness, twist));
    let viscous = pool.neg(pool.mul(damping, kinematics.rate(model, position)));

    // The torque on the successor about the axis, and its opposite on the predecessor.
    let sides = kinematics.sides(model, joint);
    let axis = joint::effort(pool, joint, motion_idx, &positions, &sides).moment;
    let opposite = spatial::neg(pool, &axis);
    let zero = spatial::zero(pool);
    let turn = |body, torque, axis: &Vector| {
        let moment = spatial::scale(pool, torque, axis);
        Wrench { body, force: zero, at: zero, moment }
    };
    let pair = |torque| {
        if pool.is_zero(torque) {
            return Vec::new();
        }
        vec![
            turn(joint.successor.body, torque, &axis),
            turn(joint.predecessor.body, torque, &opposite),
        ]
    };
    let potential = has_potential.then(|| context.half_square(stiffness, twist));
    Action::of_parts(potential, pair(elastic), pair(viscous))
}
