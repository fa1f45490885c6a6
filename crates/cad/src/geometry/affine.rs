//! [`Affine`]: maps of the plane, such as an insert makes of its block.

use super::vector::{along, cross, dot, norm, scaled};
use super::{Curve, Path, Point, Spline};

/// The map `p ↦ origin + p₀ x + p₁ y`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Affine {
    /// Where the unit vector of the first axis goes.
    pub x: Point,
    /// Where the unit vector of the second axis goes.
    pub y: Point,
    /// Where the origin goes.
    pub origin: Point,
}

/// How far, relative to its size, a map may be from a similarity for arcs to stay arcs.
const SIMILAR: f64 = 1e-12;

impl Affine {
    /// The map that changes nothing.
    pub const IDENTITY: Self = Self { x: [1.0, 0.0], y: [0.0, 1.0], origin: [0.0, 0.0] };

    /// Moves by a vector.
    pub fn translation(by: Point) -> Self {
        Self { origin: by, ..Self::IDENTITY }
    }

    /// Turns about the origin, rad.
    pub fn rotation(angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { x: [cos, sin], y: [-sin, cos], origin: [0.0, 0.0] }
    }

    /// Scales along the axes.
    pub fn scaling(x: f64, y: f64) -> Self {
        Self { x: [x, 0.0], y: [0.0, y], origin: [0.0, 0.0] }
    }

    /// Where a point goes.
    pub fn point(&self, p: Point) -> Point {
        along(along(self.origin, p[0], self.x), p[1], self.y)
    }

    /// Where a vector goes.
    pub fn vector(&self, v: Point) -> Point {
        along(scaled(self.x, v[0]), v[1], self.y)
    }

    /// This map, then `next`.
    #[must_use]
    pub fn then(&self, next: &Self) -> Self {
        Self { x: next.vector(self.x), y: next.vector(self.y), origin: next.point(self.origin) }
    }

    /// How areas scale; negative for reflections.
    pub fn determinant(&self) -> f64 {
        cross(self.x, self.y)
    }

    /// True if circles stay circles.
    pub fn is_similarity(&self) -> bool {
        let (a, b) = (norm(self.x), norm(self.y));
        (a - b).abs() <= SIMILAR * a && dot(self.x, self.y).abs() <= SIMILAR * a * b
    }
}

impl Curve {
    /// The image of the curve; an arc becomes an ellipse unless the map is a similarity.
    #[must_use]
    pub fn transformed(&self, map: &Affine) -> Self {
        match self {
            Self::Segment { from, to } => {
                Self::Segment { from: map.point(*from), to: map.point(*to) }
            }
            Self::Arc { centre, radius, start, sweep } if map.is_similarity() => {
                let turned = map.vector([start.cos(), start.sin()]);
                Self::Arc {
                    centre: map.point(*centre),
                    radius: radius * norm(map.x),
                    // A pure translation leaves the angle as it was written.
                    start: if map.x == [1.0, 0.0] && map.y == [0.0, 1.0] {
                        *start
                    } else {
                        turned[1].atan2(turned[0])
                    },
                    sweep: sweep * map.determinant().signum(),
                }
            }
            Self::Arc { centre, radius, start, sweep } => principal(
                map.point(*centre),
                [scaled(map.x, *radius), scaled(map.y, *radius)],
                *start,
                *sweep,
            ),
            Self::Ellipse { centre, major, minor, start, sweep } => principal(
                map.point(*centre),
                [map.vector(*major), map.vector(*minor)],
                *start,
                *sweep,
            ),
            Self::Spline(spline) => Self::Spline(Spline {
                control: spline.control.iter().map(|p| map.point(*p)).collect(),
                ..spline.clone()
            }),
        }
    }
}

/// The ellipse of two conjugate half diameters `a`, `b`, written with its perpendicular axes.
///
/// With `u = u₀ + w` the ellipse is `cos w (a cos u₀ + b sin u₀) + sin w (b cos u₀ − a sin u₀)`,
/// and the two are perpendicular for `tan 2u₀ = 2 a·b / (a·a − b·b)`.
fn principal(centre: Point, [a, b]: [Point; 2], start: f64, sweep: f64) -> Curve {
    let skew = 2.0 * dot(a, b);
    // Axes that are perpendicular already stay as they are written.
    let u0 = if skew.abs() <= SIMILAR * norm(a) * norm(b) {
        0.0
    } else {
        0.5 * skew.atan2(dot(a, a) - dot(b, b))
    };
    let (sin, cos) = u0.sin_cos();
    Curve::Ellipse {
        centre,
        major: along(scaled(a, cos), sin, b),
        minor: along(scaled(b, cos), -sin, a),
        start: start - u0,
        sweep,
    }
}

impl Path {
    /// The image of the path.
    #[must_use]
    pub fn transformed(&self, map: &Affine) -> Self {
        Self {
            curves: self.curves.iter().map(|curve| curve.transformed(map)).collect(),
            is_closed: self.is_closed,
        }
    }
}
