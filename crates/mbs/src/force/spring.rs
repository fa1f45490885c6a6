//! Spring and damper between two points.

use bksim_expr::Expr;

use super::context::Context;
use super::{Action, AlongLine};
use crate::folding::short;
use crate::spatial;
use bksim_model::{Anchor, Vector};

/// V = ½ k (l − l₀)²; the damper pulls with −c l′.
///
/// With l₀ = 0 there is a force where the ends meet, too: it is −k d there as everywhere, d being the vector
/// between them, and −c d′ is the limit of the damper's along every motion through that place.
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
    if pool.is_zero(length) && !pool.is_zero(stiffness) {
        return of_no_length(context, ends, [stiffness, damping], has_potential);
    }
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
    // The potential stands for the elastic part.
    let value = if has_potential { viscous } else { pool.add(elastic, viscous) };
    let line = Some(AlongLine { distance, value });
    Action { line, ..Action::of_parts(potential, pair(elastic), pair(viscous)) }
}

/// A spring whose ends pull each other together, by the vector between them instead of its direction.
fn of_no_length(
    context: &Context<'_>,
    ends: [Anchor; 2],
    [stiffness, damping]: [Expr; 2],
    has_potential: bool,
) -> Action {
    let Context { pool, kinematics, .. } = *context;
    let d = context.vector(ends);
    let square = short(pool, spatial::dot(pool, &d, &d));
    let potential = has_potential.then(|| pool.product([pool.rational(1, 2), stiffness, square]));
    let elastic = context.pull_together(ends, &spatial::scale(pool, stiffness, &d));
    if pool.is_zero(damping) {
        return Action::of_parts(potential, elastic, Vec::new());
    }
    // The square itself as condition: a comparison would be an event of the run.
    let rate = d.map(|e| kinematics.rate(context.model, e));
    let along = pool.div(spatial::dot(pool, &d, &rate), square);
    let viscous: Vector = std::array::from_fn(|i| {
        pool.mul(damping, pool.select(square, pool.mul(along, d[i]), rate[i]))
    });
    Action::of_parts(potential, elastic, context.pull_together(ends, &viscous))
}
