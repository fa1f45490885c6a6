//! Belts and chains around any number of wheels.

use bksim_expr::Expr;

use crate::diagnostic::Span;
use crate::ids::JointId;

/// A belt or chain around wheels on which it does not slip, closed in itself.
#[derive(Clone, Debug)]
pub struct Belt {
    /// Name as written.
    pub name: String,
    /// The wheels in the order in which the belt comes to them; a strand leads from each to the next, and from
    /// the last to the first.
    pub wheels: Vec<BeltWheel>,
    /// Length of the belt, m, where the author stated it; of an elastic belt without load.
    pub length: Option<Expr>,
    /// Length of the way around the wheels, m: an expression of signals.
    pub way: Expr,
    /// Tension of each strand of an elastic belt, N: expressions of signals. None of one that does not stretch,
    /// whose strands are [couplings](crate::CouplingKind::Strand).
    pub tensions: Vec<Expr>,
    /// Position of the name, or of the length.
    pub span: Span,
}

/// A wheel of a belt.
#[derive(Clone, Copy, Debug)]
pub struct BeltWheel {
    /// The joint about whose axis it turns; the wheel is its second body, unless that is the ground.
    pub joint: JointId,
    /// Radius, m: positive where the belt turns left around the wheel, below zero where it turns right.
    pub radius: Expr,
}
