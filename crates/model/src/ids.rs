//! Handles of the parts of a model, and what all parts are made of.

use bksim_expr::Expr;

macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident),*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
        pub struct $name(pub usize);
    )*};
}

ids! {
    /// Index into [`Model::bodies`](crate::Model::bodies); [`GROUND`] is the first.
    BodyId,
    /// Index into [`Model::joints`](crate::Model::joints).
    JointId,
    /// Index into [`Model::loads`](crate::Model::loads).
    LoadId,
    /// Index into [`Model::drives`](crate::Model::drives).
    DriveId,
    /// Index into [`Model::couplings`](crate::Model::couplings).
    CouplingId,
    /// Index into [`Model::belts`](crate::Model::belts).
    BeltId,
    /// Index into [`Model::ropes`](crate::Model::ropes).
    RopeId,
    /// Index into [`Model::contacts`](crate::Model::contacts).
    ContactId,
    /// Index into [`Model::curves`](crate::Model::curves).
    CurveId,
    /// Index into [`Model::laws`](crate::Model::laws).
    LawId,
    /// Index into [`Model::parameters`](crate::Model::parameters).
    ParameterId,
    /// Index into [`Model::clocks`](crate::Model::clocks).
    ClockId,
    /// Index into [`Model::states`](crate::Model::states).
    StateId,
    /// Index into [`Body::points`](crate::Body::points) of one body.
    PointId
}

/// The body that does not move.
pub const GROUND: BodyId = BodyId(0);

/// A vector of expressions, x y z.
pub type Vector = [Expr; 3];
