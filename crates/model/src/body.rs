//! Rigid bodies and their points.

use bksim_expr::Expr;

use crate::diagnostic::Span;
use crate::flexible::Flexible;
use crate::ids::{BodyId, PointId, Vector};
use crate::mesh::Mesh;

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
    /// Solids for drawing, whose masses make that of the body where it has a density.
    pub solids: Vec<Solid>,
    /// Set where the body bends: its frame is at the root of a beam.
    pub flexible: Option<Flexible>,
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

/// A solid fixed to a body.
#[derive(Clone, PartialEq, Debug)]
pub struct Solid {
    /// Form of the solid, about the origin of its own frame.
    pub form: SolidForm,
    /// Origin of its frame in the body frame, m.
    pub position: Vector,
    /// Orientation of its frame against the body frame, as that of a [`Point`].
    pub orientation: Vec<FixedTurn>,
}

/// The form of a solid in its own frame; lengths in m.
#[derive(Clone, PartialEq, Debug)]
pub enum SolidForm {
    /// A box with its middle at the origin, of these lengths along x, y and z.
    Box(Vector),
    /// A circular cylinder about z, as long to either side of the origin.
    Cylinder {
        /// Radius.
        radius: Expr,
        /// Length.
        length: Expr,
    },
    /// A ball of this radius about the origin.
    Sphere(Expr),
    /// A plate, as thick to either side of the plane z = 0.
    Plate {
        /// Corners (x, y) in order, counter-clockwise.
        corners: Vec<[Expr; 2]>,
        /// Thickness.
        thickness: Expr,
    },
    /// Triangles between corners.
    Mesh(Mesh),
}

/// Space in which bodies move: a plane z = const, or all three dimensions.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Space {
    /// All rotation axes along z, all translations in the plane.
    Planar,
    /// No restriction.
    Spatial,
}
