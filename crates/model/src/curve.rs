//! Curves that points follow.

use bksim_expr::{Expr, SymbolId};

use crate::ids::Vector;

/// A curve in the frame of a point of a body, by a parameter.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name as written.
    pub name: String,
    /// The parameter, a pure number.
    pub parameter: SymbolId,
    /// The point at each value of the parameter, m.
    pub position: Vector,
    /// The values between which it is drawn.
    pub range: [Expr; 2],
}
