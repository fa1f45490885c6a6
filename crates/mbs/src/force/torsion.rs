//! Torsion spring and damper on a rotation of a joint.

use bksim_expr::Expr;

use super::context::Context;
use super::{Action, Wrench};
use crate::joint;
use crate::spatial;
use bksim_model::{JointId, Load, LoadKind, Vector};

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
    let positions = kinematics.joint_positions(model, joint_id);
    let law = Law::of(context, positions[motion_idx], [stiffness, angle, damping]);
    if joint.kind.curve().is_some() {
        return Action::of_parts(law.potential, Vec::new(), Vec::new());
    }

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
    Action::of_parts(law.potential, pair(law.elastic), pair(law.viscous))
}

/// The law of a torsion spring and damper, as for those between two points.
struct Law {
    /// N m.
    elastic: Expr,
    /// N m.
    viscous: Expr,
    /// J, of the elastic part.
    potential: Option<Expr>,
}

impl Law {
    fn of(context: &Context<'_>, position: Expr, [stiffness, angle, damping]: [Expr; 3]) -> Self {
        let Context { model, pool, kinematics, .. } = *context;
        let has_potential = !pool.is_zero(stiffness)
            && context.is_constant(stiffness)
            && context.is_constant(angle);
        let [stiffness, angle, damping] = [stiffness, angle, damping].map(|e| context.resolved(e));
        let twist = pool.sub(position, angle);
        Self {
            elastic: pool.neg(pool.mul(stiffness, twist)),
            viscous: pool.neg(pool.mul(damping, kinematics.rate(model, position))),
            potential: has_potential.then(|| context.half_square(stiffness, twist)),
        }
    }
}

/// The efforts of torsion springs and dampers on parameters of curves, each with its joint; those with a potential
/// are its gradient.
pub(super) fn efforts_on_curves(context: &Context<'_>) -> Vec<(JointId, Expr)> {
    let Context { model, pool, kinematics, .. } = *context;
    let effort = |load: &Load| {
        let LoadKind::Torsion { joint, motion_idx, stiffness, angle, damping } = load.kind else {
            return None;
        };
        model.joints[joint.0].kind.curve()?;
        let position = kinematics.joint_positions(model, joint)[motion_idx];
        let law = Law::of(context, position, [stiffness, angle, damping]);
        let elastic = if law.potential.is_some() { pool.zero() } else { law.elastic };
        Some((joint, pool.add(elastic, law.viscous)))
    };
    model.loads.iter().filter_map(effort).collect()
}
