//! Spring and damper between two points.

use bksim_expr::Expr;

use super::Action;
use super::context::Context;
use bksim_model::Anchor;

/// V = ½ k (l − l₀)²; the damper pulls with −c l′.
pub(super) fn action(
    context: &Context<'_>,
    ends: [Anchor; 2],
    stiffness: Expr,
    length: Expr,
    damping: Expr,
) -> Action {
    let Context { model, pool, kinematics, .. } = *context;
    let has_potential =
        !pool.is_zero(stiffness) && context.is_constant(stiffness) && context.is_constant(length);
    let [stiffness, length, damping] = [stiffness, length, damping].map(|e| context.resolved(e));
    let (distance, direction) = context.line(ends);
    let stretch = pool.sub(distance, length);
    let elastic = pool.neg(pool.mul(stiffness, stretch));
    let viscous = pool.neg(pool.mul(damping, kinematics.rate(model, distance)));
    let pair = |value| {
        if pool.is_zero(value) {
            return Vec::new();
        }
        context.push_apart(ends, value, &direction)
    };
    let potential = has_potential.then(|| context.half_square(stiffness, stretch));
    Action::of_parts(potential, pair(elastic), pair(viscous))
}
