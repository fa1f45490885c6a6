//! A force along the line of two points, positive when it pushes them apart.

use bksim_expr::Expr;

use super::Action;
use super::context::Context;
use bksim_model::Anchor;

/// F = `value` on `b` away from `a`, and the opposite on `a`.
pub(super) fn action(context: &Context<'_>, a: Anchor, b: Anchor, value: Expr) -> Action {
    let (_, direction) = context.line([a, b]);
    Action::of_applied(context.push_apart([a, b], context.resolved(value), &direction))
}
