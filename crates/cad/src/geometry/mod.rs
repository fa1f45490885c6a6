//! Curves of the plane, of which outlines are made, and the areas inside of them.
//!
//! Coordinates are in the units of the drawing, in the axes of the world. Whatever is asked of a
//! curve, numbers that make none ([`Curve::check`]) are answered with numbers that are none.

mod affine;
pub(crate) mod bezier;
mod bounds;
pub(crate) mod conic;
pub(crate) mod curve;
mod distance;
mod error;
mod flatten;
mod lens;
pub(crate) mod moments;
mod path;
pub(crate) mod quadrature;
mod spline;
pub mod vector;
mod winding;

pub use affine::Affine;
pub use bounds::Bounds;
pub use error::{COORDINATE_LIMIT, GeometryError, MAX_DEGREE};
pub use moments::signed_area;
pub use path::Vertex;
pub(crate) use winding::Pen;

/// A point or a vector of the plane.
pub type Point = [f64; 2];

/// A curve with a direction.
#[derive(Clone, PartialEq, Debug)]
pub enum Curve {
    /// A straight line.
    Segment {
        /// First end.
        from: Point,
        /// Second end.
        to: Point,
    },
    /// A part of a circle, or a whole one.
    Arc {
        /// Centre.
        centre: Point,
        /// Greater than zero.
        radius: f64,
        /// Angle of the first end, rad.
        start: f64,
        /// Angle to the second end, rad: positive counter-clockwise, at most 2π either way.
        sweep: f64,
    },
    /// A part of an ellipse, or a whole one: centre + cos(u) major + sin(u) minor.
    Ellipse {
        /// Centre.
        centre: Point,
        /// The half axis at u = 0.
        major: Point,
        /// The half axis at u = π/2.
        minor: Point,
        /// Parameter of the first end, rad.
        start: f64,
        /// To the parameter of the second end, rad; at most 2π either way.
        sweep: f64,
    },
    /// A rational B-spline.
    Spline(Spline),
}

/// A rational B-spline; its ends are at `knots[degree]` and `knots[control.len()]`.
#[derive(Clone, PartialEq, Debug)]
pub struct Spline {
    /// Polynomial degree, at least 1.
    pub degree: usize,
    /// Knots, not decreasing; `control.len() + degree + 1` of them.
    pub knots: Vec<f64>,
    /// Control points.
    pub control: Vec<Point>,
    /// One per control point, greater than zero.
    pub weights: Vec<f64>,
}

/// Curves that follow one another: the end of each is the beginning of the next.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Path {
    /// In order.
    pub curves: Vec<Curve>,
    /// True if the last ends where the first begins.
    pub is_closed: bool,
}
