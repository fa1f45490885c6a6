//! A force along the line of two points, positive when it pushes them apart.

use bksim_expr::Expr;

use super::context::Context;
use super::{Action, AlongLine};
use bksim_model::Anchor;

/// F = `value` on `b` away from `a`, and the opposite on `a`.
pub(super) fn action(context: &Context<'_>, a: Anchor, b: Anchor, value: Expr) -> Action {
    let (distance, direction) = context.line([a, b]);
    let value = context.resolved(value);
    let line = Some(AlongLine { distance, value });
    Action { line, ..Action::of_applied(context.push_apart([a, b], value, &direction)) }
}
