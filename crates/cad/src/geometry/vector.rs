//! Vectors of the plane.

use super::Point;

/// `a − b`.
pub fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

/// `s a`.
pub fn scaled(a: Point, s: f64) -> Point {
    [a[0] * s, a[1] * s]
}

/// `a + s b`.
pub fn along(a: Point, s: f64, b: Point) -> Point {
    [a[0] + s * b[0], a[1] + s * b[1]]
}

/// The scalar product.
pub fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// The z component of the cross product; positive when `b` is to the left of `a`.
pub fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// The length.
pub fn norm(a: Point) -> f64 {
    a[0].hypot(a[1])
}

/// How far two points are apart.
pub fn distance(a: Point, b: Point) -> f64 {
    norm(sub(a, b))
}

/// `a` at 0, `b` at 1.
pub fn between(a: Point, b: Point, t: f64) -> Point {
    [(1.0 - t) * a[0] + t * b[0], (1.0 - t) * a[1] + t * b[1]]
}

/// The unit vector at an angle, rad.
pub fn direction(angle: f64) -> Point {
    [angle.cos(), angle.sin()]
}
