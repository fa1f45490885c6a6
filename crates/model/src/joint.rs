//! Joints: what connects two bodies, and the motions that it allows.

use bksim_expr::Expr;

use crate::body::Anchor;
use crate::diagnostic::Span;
use crate::ids::Vector;

/// A connection of two bodies, from `predecessor` to `successor`.
///
/// Joint coordinates measure the successor relative to the predecessor.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Name as written.
    pub name: String,
    /// The kind, which fixes its motions.
    pub kind: JointKind,
    /// The first body named.
    pub predecessor: Anchor,
    /// The second body named.
    pub successor: Anchor,
    /// Unit vector in the predecessor's frame: rotation axis of a revolute (z in a plane),
    /// direction of a prismatic joint or of a slot. Unused by weld and link.
    pub axis: Vector,
    /// The author's word on cutting this joint.
    pub cut: Option<bool>,
    /// Names the author gave to its coordinates, in the order of its motion.
    pub coordinate_names: Vec<String>,
    /// Position of the name.
    pub span: Span,
}

/// The kinds of joint.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum JointKind {
    /// One rotation about `axis`.
    Revolute,
    /// One translation along `axis`; the frames keep the angle (rad, about z).
    Prismatic {
        /// Fixed angle of the successor relative to the predecessor.
        angle: Expr,
    },
    /// No motion; the frames keep the angle (rad, about z).
    Weld {
        /// Fixed angle of the successor relative to the predecessor.
        angle: Expr,
    },
    /// A pin of the successor in a straight slot of the predecessor: translation along `axis`,
    /// then rotation about the normal of the plane.
    PinInSlot,
    /// Rigid massless link of the given length between the two points; always a constraint.
    Link {
        /// Length, m, greater than zero.
        length: Expr,
    },
}

/// Turning or sliding.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum MotionKind {
    /// About the axis, rad.
    Rotation,
    /// Along the axis, m.
    Translation,
}

impl JointKind {
    /// The elementary motions that a joint of this kind allows, in the order of its coordinates.
    pub fn motions(&self) -> &'static [MotionKind] {
        match self {
            Self::Revolute => &[MotionKind::Rotation],
            Self::Prismatic { .. } => &[MotionKind::Translation],
            Self::PinInSlot => &[MotionKind::Translation, MotionKind::Rotation],
            Self::Weld { .. } | Self::Link { .. } => &[],
        }
    }
}
