//! Gravity: a uniform field of acceleration on every body that has a mass.

use super::context::Context;
use super::{Action, Wrench};
use crate::spatial;
use bksim_model::{BodyId, Vector};

/// V = −Σ m a · r_c in a field of the acceleration a.
pub(super) fn action(context: &Context<'_>, acceleration: &Vector) -> Action {
    let Context { model, pool, kinematics, .. } = *context;
    let constant = acceleration.iter().all(|&component| context.is_constant(component));
    let acceleration = &acceleration.map(|component| context.resolved(component));
    let mut wrenches = Vec::new();
    let mut potential = Vec::new();
    for body_idx in 1..model.bodies.len() {
        let body = BodyId(body_idx);
        let mass = model.bodies[body_idx].mass;
        if pool.is_zero(mass) {
            continue;
        }
        let at = kinematics.position(model, body, None);
        let height = pool.neg(spatial::dot(pool, acceleration, &at));
        potential.push(pool.mul(mass, height));
        let force = spatial::scale(pool, mass, acceleration);
        wrenches.push(Wrench { body, force, at, moment: spatial::zero(pool) });
    }
    let field = constant.then_some(*acceleration);
    let parts = Action::of_parts(constant.then(|| pool.sum(potential)), wrenches, Vec::new());
    Action { field, ..parts }
}
