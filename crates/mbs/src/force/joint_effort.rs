//! A force or torque in one motion of a joint, as a motor or a piston in it has.

use bksim_expr::Expr;

use super::context::Context;
use super::{Action, Wrench};
use crate::joint;
use bksim_model::{JointId, Load};

/// The effort on the successor, and its opposite on the predecessor; on the parameter of a curve it has no wrench.
pub(super) fn action(
    context: &Context<'_>,
    (joint_id, motion_idx): (JointId, usize),
    value: Expr,
) -> Action {
    let Context { model, pool, kinematics, .. } = *context;
    let joint = &model.joints[joint_id.0];
    if joint.kind.curve().is_some() {
        return Action::default();
    }
    let positions = kinematics.joint_positions(model, joint_id);
    let sides = kinematics.sides(model, joint);
    let unit = joint::effort(pool, joint, motion_idx, &positions, &sides);
    let value = context.resolved(value);
    let unit = Wrench::within_joint(model, kinematics, joint_id, &unit);
    Action::of_applied(unit.iter().map(|wrench| wrench.scaled(pool, value)).collect())
}

/// The effort of a load on the parameter of a curve, with the joint that follows it.
pub(super) fn effort_on_curve(
    context: &Context<'_>,
    load: &Load,
) -> Option<(JointId, usize, Expr)> {
    let (joint, motion_idx) = load.kind.joint_motion()?;
    let value = load.kind.stated_effort()?;
    context.model.joints[joint.0].kind.curve()?;
    Some((joint, motion_idx, context.resolved(value)))
}
