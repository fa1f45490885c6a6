//! States and signals: quantities of controllers, motors and other parts that are not bodies.

use bksim_expr::Expr;

use crate::diagnostic::Span;

/// A quantity of first order, integrated together with the motion.
#[derive(Clone, Debug)]
pub struct State {
    /// Name as written.
    pub name: String,
    /// Its rate: an expression of time, parameters and signals.
    pub rate: Expr,
    /// SI units as text of its integral, of the state and of its rate; of a state without unit as of a pure
    /// number.
    pub units: [String; 3],
    /// Position of the rate.
    pub span: Span,
}

/// An expression of the motion that the author gave a name.
#[derive(Clone, Debug)]
pub struct NamedSignal {
    /// Name as written.
    pub name: String,
    /// Its value, SI.
    pub value: Expr,
    /// SI unit as text, empty of a pure number and where the author gave none.
    pub unit: String,
    /// Position of the value.
    pub span: Span,
}
