//! Linear spring and damper in one motion of a joint, along a translation or about the axis of a rotation.

use bksim_expr::Expr;

use super::context::Context;
use super::{Action, Wrench};
use crate::joint::{self, JointWrench};
use bksim_model::{JointId, Load};

/// V = ½ k (s − s₀)² for one position s of the joint; the damper resists with −c s′.
pub(super) fn action(
    context: &Context<'_>,
    (joint_id, motion_idx): (JointId, usize),
    stiffness: Expr,
    unloaded: Expr,
    damping: Expr,
) -> Action {
    let Context { model, pool, kinematics, .. } = *context;
    let joint = &model.joints[joint_id.0];
    let positions = kinematics.joint_positions(model, joint_id);
    let law = Law::of(context, positions[motion_idx], [stiffness, unloaded, damping]);
    if joint.kind.curve().is_some() {
        return Action::of_parts(law.potential, Vec::new(), Vec::new());
    }

    // The effort on the successor, and its opposite on the predecessor.
    let sides = kinematics.sides(model, joint);
    let unit = joint::effort(pool, joint, motion_idx, &positions, &sides);
    let pair = |unit: &JointWrench, effort| {
        if pool.is_zero(effort) {
            return Vec::new();
        }
        let unit = Wrench::within_joint(model, kinematics, joint_id, unit);
        unit.iter().map(|wrench| wrench.scaled(pool, effort)).collect()
    };
    let (elastic, viscous) = (pair(&unit, law.elastic), pair(&unit, law.viscous));
    let by_poses = law.potential.is_some() && !kinematics.has_coordinates(joint_id);
    match joint::gradient(pool, joint, &sides).filter(|_| by_poses) {
        // The effort is what V stands for and a wrench that does no work; without it, the rows would bear that.
        Some(gradient) => Action {
            potential: law.potential,
            conservative: pair(&gradient, law.elastic),
            applied: [elastic, pair(&gradient, pool.neg(law.elastic)), viscous].concat(),
            ..Action::default()
        },
        None => Action::of_parts(law.potential, elastic, viscous),
    }
}

/// The law of a spring and damper in a joint, as for those between two points.
struct Law {
    /// N or N m.
    elastic: Expr,
    /// N or N m.
    viscous: Expr,
    /// J, of the elastic part.
    potential: Option<Expr>,
}

impl Law {
    fn of(
        context: &Context<'_>,
        position: Expr,
        [stiffness, unloaded, damping]: [Expr; 3],
    ) -> Self {
        let Context { model, pool, kinematics, .. } = *context;
        let has_potential = !pool.is_zero(stiffness)
            && context.is_constant(stiffness)
            && context.is_constant(unloaded);
        let [stiffness, unloaded, damping] =
            [stiffness, unloaded, damping].map(|e| context.resolved(e));
        let stretch = pool.sub(position, unloaded);
        Self {
            elastic: pool.neg(pool.mul(stiffness, stretch)),
            viscous: pool.neg(pool.mul(damping, kinematics.rate(model, position))),
            potential: has_potential.then(|| context.half_square(stiffness, stretch)),
        }
    }
}

/// The effort of a load on the parameter of a curve, with the joint that follows it; of a spring with a potential
/// this is the gradient.
pub(super) fn effort_on_curve(
    context: &Context<'_>,
    load: &Load,
) -> Option<(JointId, usize, Expr)> {
    let Context { model, pool, kinematics, .. } = *context;
    let (joint, motion_idx) = load.kind.joint_motion()?;
    let law = load.kind.spring()?;
    model.joints[joint.0].kind.curve()?;
    let position = kinematics.joint_positions(model, joint)[motion_idx];
    let law = Law::of(context, position, law);
    let elastic = if law.potential.is_some() { pool.zero() } else { law.elastic };
    Some((joint, motion_idx, pool.add(elastic, law.viscous)))
}
