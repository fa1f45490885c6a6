//! Contacts: outlines of two bodies that may touch, taken apart into places.
//!
//! A place is a point, corner or disc of one body against an edge, a ring, a disc or a corner of the other. All places on
//! one straight edge rub along it together: they share a [`Track`]. In space a place is a point or ball of one body against
//! a plane, a ball or the inside of a sphere of the other, and rubs by itself, in every direction of its tangent plane.

use bksim_expr::Expr;

use crate::body::Anchor;
use crate::diagnostic::Span;
use crate::ids::{JointId, Vector};

/// Two outlines, or surfaces in space, that may touch.
#[derive(Clone, Debug)]
pub struct ContactPair {
    /// Name as written.
    pub name: String,
    /// The outlines, as the author named them.
    pub shapes: [Shape; 2],
    /// Where they may touch.
    pub places: Vec<Place>,
    /// The places that rub together, by their numbers.
    pub tracks: Vec<Vec<usize>>,
    /// The joint whose play it is, if one has a clearance.
    pub play_of: Option<JointId>,
    /// Position of the shapes.
    pub span: Span,
}

impl ContactPair {
    /// True of surfaces in space.
    pub fn is_spatial(&self, zero: Expr) -> bool {
        self.shapes.iter().any(|shape| shape.is_spatial(zero) == Some(true))
    }
}

/// The outline of a body.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A point, or a disc with a radius.
    Round(Round),
    /// The inside of a circle.
    Ring(Round),
    /// A ball, from outside.
    Ball(Round),
    /// The inside of a sphere.
    Bowl(Round),
    /// Points of a body in space.
    Points(Vec<Anchor>),
    /// A plane without ends.
    Plane(Flat),
    /// The curve that a joint of this kind lifts off; what lifts off it is the other shape.
    Curve {
        /// The joint.
        joint: JointId,
        /// The point in whose frame the curve is.
        anchor: Anchor,
    },
    /// Straight edges from corner to corner; what touches them is to their left.
    Edges {
        /// The corners in order.
        corners: Vec<Anchor>,
        /// Form of the whole.
        form: EdgesForm,
    },
}

/// The form of some straight edges.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum EdgesForm {
    /// One line without ends.
    Line,
    /// An open chain.
    Chain,
    /// A closed outline.
    Outline,
}

impl Shape {
    /// Every point that it is given by.
    pub fn anchors(&self) -> Vec<Anchor> {
        match self {
            Self::Round(round) | Self::Ring(round) | Self::Ball(round) | Self::Bowl(round) => {
                vec![round.center]
            }
            Self::Plane(plane) => vec![plane.anchor],
            Self::Points(points) => points.clone(),
            Self::Curve { anchor, .. } => vec![*anchor],
            Self::Edges { corners, .. } => corners.clone(),
        }
    }
}

impl Shape {
    /// True of what is for models in space, false of what is for those in the plane; `None` of a point.
    pub fn is_spatial(&self, zero: Expr) -> Option<bool> {
        match self {
            Self::Round(round) if round.radius == zero => None,
            Self::Ball(_) | Self::Bowl(_) | Self::Points(_) | Self::Plane(_) => Some(true),
            Self::Round(_) | Self::Ring(_) | Self::Curve { .. } | Self::Edges { .. } => Some(false),
        }
    }
}

/// A plane through a point; what touches it is on the side of its normal.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Flat {
    /// A point of it.
    pub anchor: Anchor,
    /// Unit vector across it, in the axes of the point.
    pub normal: Vector,
}

/// A circle or sphere; a point has the radius zero.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Round {
    /// Centre of the circle, or the point.
    pub center: Anchor,
    /// Radius, m.
    pub radius: Expr,
}

/// A place where two bodies may touch.
#[derive(Clone, Debug)]
pub struct Place {
    /// Point, corner or disc of one body.
    pub mover: Round,
    /// The corners next to it, where it is a corner itself.
    pub neighbors: Vec<Anchor>,
    /// Edge, ring or disc of the other body.
    pub base: Base,
    /// True if the mover belongs to the second shape.
    pub is_second: bool,
}

/// Part of an outline that a point, corner or disc touches.
#[derive(Clone, Debug)]
pub enum Base {
    /// A straight edge, with the free side to its left.
    Edge {
        /// Both ends, in order.
        ends: [Anchor; 2],
        /// How far it reaches.
        reach: Reach,
    },
    /// The inside of a circle, or of a sphere.
    Ring(Round),
    /// A plane.
    Plane(Flat),
    /// The curve of a joint that lifts off it, at the place nearest to what lifts off, which is a coordinate of the joint.
    Curve {
        /// The joint.
        joint: JointId,
        /// The point in whose frame the curve is.
        anchor: Anchor,
    },
    /// The outside of a circle or sphere, or a corner between the edges that come from and lead to these.
    Round {
        /// The circle or corner.
        round: Round,
        /// The corners before and after it.
        wedge: [Option<Anchor>; 2],
    },
}

/// How far an edge reaches.
#[derive(Clone, Debug)]
pub enum Reach {
    /// Without end.
    Endless,
    /// From one end to the other.
    Ends,
    /// Up to these edges of one convex outline.
    Within(Vec<[Anchor; 2]>),
}

impl Base {
    /// A point of it.
    pub fn anchor(&self) -> Anchor {
        match self {
            Self::Edge { ends, .. } => ends[0],
            Self::Curve { anchor, .. } => *anchor,
            Self::Plane(plane) => plane.anchor,
            Self::Ring(round) | Self::Round { round, .. } => round.center,
        }
    }
}
