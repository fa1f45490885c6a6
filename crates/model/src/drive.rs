//! Drives: prescribed motions of joints.

use bksim_expr::Expr;

use crate::diagnostic::Span;
use crate::ids::JointId;

/// A prescribed motion: the measure equals the function of time.
#[derive(Clone, Debug)]
pub struct Drive {
    /// Name as written.
    pub name: String,
    /// The driven joint.
    pub joint: JointId,
    /// Which of its motions: 0 unless the joint is a pin in a slot.
    pub motion_idx: usize,
    /// Prescribed position of the joint as a function of time and parameters, rad or m.
    pub motion: Expr,
    /// Position of the motion.
    pub span: Span,
}
