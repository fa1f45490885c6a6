//! Rigid bodies and their points.

use bksim_expr::Expr;

use crate::diagnostic::Span;
use crate::ids::{BodyId, PointId, Vector};

/// A rigid body.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name as written; `ground` for the first.
    pub name: String,
    /// Mass, kg; zero for a massless link.
    pub mass: Expr,
    /// Centre of mass in the body frame, m.
    pub com: Vector,
    /// Moment of inertia, kg m².
    pub inertia: Inertia,
    /// Named points in the body frame, m.
    pub points: Vec<Point>,
    /// Outlines for drawing, body frame, m; each a closed polygon.
    pub outline: Vec<Vec<[Expr; 2]>>,
    /// Names the author gave to this body's own coordinates: x, y, angle (planar).
    pub coordinate_names: Vec<String>,
    /// Position of the name.
    pub span: Span,
    /// Position of the mass, when stated.
    pub mass_span: Option<Span>,
    /// Position of the inertia, when stated.
    pub inertia_span: Option<Span>,
}

/// Moments and products of inertia in the axes of the body frame.
#[derive(Clone, Debug)]
pub struct Inertia {
    /// Ixx, Iyy, Izz.
    pub moments: Vector,
    /// Ixy, Iyz, Izx (the off-diagonal entries of the tensor itself, so −∫xy dm).
    pub products: Vector,
    /// The point they refer to; `None` for the centre of mass.
    pub about: Option<PointId>,
}

/// A named point of a body.
#[derive(Clone, Debug)]
pub struct Point {
    /// Name as written.
    pub name: String,
    /// Position in the body frame, m.
    pub position: Vector,
    /// Orientation of its frame against the body frame: turns by fixed angles, each about an axis that
    /// those before it have turned; none where the frames are parallel.
    pub orientation: Vec<FixedTurn>,
}

/// A turn by a constant angle.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct FixedTurn {
    /// Unit vector.
    pub axis: Vector,
    /// Angle, rad.
    pub angle: Expr,
}

/// A body and one of its points; `None` is the origin of the body frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Anchor {
    /// The body.
    pub body: BodyId,
    /// The point.
    pub point: Option<PointId>,
}
