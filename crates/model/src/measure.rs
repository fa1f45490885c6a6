//! Measures: the one way to name something of the motion, in loads, initial values and outputs.

use bksim_expr::{Expr, SymbolId};

use crate::diagnostic::Span;
use crate::ids::{BodyId, JointId, PointId};

/// World axis.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Axis {
    /// First.
    X,
    /// Second.
    Y,
    /// Third.
    Z,
}

/// Something of the motion that has a value at every instant.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Measure {
    /// A coordinate of a joint, rad or m; the second is its position in the joint's motion.
    JointPosition(JointId, usize),
    /// Its rate.
    JointVelocity(JointId, usize),
    /// World coordinate of a body's point, m; `None` is the centre of mass.
    PointPosition(BodyId, Option<PointId>, Axis),
    /// Its rate.
    PointVelocity(BodyId, Option<PointId>, Axis),
    /// Angle of a body against the ground about z, rad (planar).
    BodyAngle(BodyId),
    /// Its rate.
    BodyRate(BodyId),
}

/// A symbol that stands for a measure.
#[derive(Clone, Copy, Debug)]
pub struct Signal {
    /// The symbol used in expressions.
    pub symbol: SymbolId,
    /// The measure it stands for.
    pub measure: Measure,
}

/// One stated or guessed value of the start.
#[derive(Clone, Debug)]
pub struct Initial {
    /// The measure whose value is stated.
    pub measure: Measure,
    /// Its value in SI, an expression of parameters.
    pub value: Expr,
    /// Whether it may move to close the mechanism.
    pub is_guess: bool,
    /// Name as written, for messages: `A.angle`.
    pub name: String,
    /// Position of the value.
    pub span: Span,
}
