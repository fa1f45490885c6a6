//! A torque on a body, and its reaction on the body it comes from.

use super::context::Context;
use super::{Action, Wrench};
use crate::spatial;
use bksim_model::{BodyId, GROUND, Vector};

/// M = `vector` on one body, −M on the other unless that is the ground.
pub(super) fn action(context: &Context<'_>, on: BodyId, from: BodyId, vector: &Vector) -> Action {
    let pool = context.pool;
    let vector = &vector.map(|component| context.resolved(component));
    let zero = spatial::zero(pool);
    let wrench = |body, moment| Wrench { body, force: zero, at: zero, moment };
    let mut wrenches = vec![wrench(on, *vector)];
    if from != GROUND {
        wrenches.push(wrench(from, spatial::neg(pool, vector)));
    }
    Action::of_applied(wrenches)
}
