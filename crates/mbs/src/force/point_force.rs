//! A force at a point of a body, in world axes or in those of the body.

use super::context::Context;
use super::{Action, Wrench};
use crate::spatial;
use bksim_model::{Anchor, Vector};

/// F = `vector`, turned with the body when it follows the body.
pub(super) fn action(
    context: &Context<'_>,
    on: Anchor,
    vector: &Vector,
    follows_body: bool,
) -> Action {
    let Context { model, pool, kinematics, .. } = *context;
    let rotation = &kinematics.poses[on.body.0].rotation;
    let vector = vector.map(|component| context.resolved(component));
    let force = if follows_body { rotation.apply(pool, &vector) } else { vector };
    let at = kinematics.anchor(model, on);
    let moment = spatial::zero(pool);
    Action::of_applied(vec![Wrench { body: on.body, force, at, moment }])
}
