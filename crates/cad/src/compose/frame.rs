//! [`Frame`]: where the axes of a body lie in the drawing.

use crate::geometry::Point;

/// A frame in world axes: origin in drawing units, angle in rad.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Frame {
    /// Origin.
    pub origin: Point,
    /// Angle of its x axis to that of the world.
    pub angle: f64,
}

impl Frame {
    /// A frame with its x axis along a vector.
    pub fn along(origin: Point, axis: Point) -> Self {
        Self { origin, angle: axis[1].atan2(axis[0]) }
    }

    /// A point of the world in this frame.
    pub fn point_inward(&self, p_world: Point) -> Point {
        self.vector_inward([p_world[0] - self.origin[0], p_world[1] - self.origin[1]])
    }

    /// A vector of the world in this frame.
    pub fn vector_inward(&self, [x, y]: Point) -> Point {
        let (sin, cos) = self.angle.sin_cos();
        [cos * x + sin * y, cos * y - sin * x]
    }
}
