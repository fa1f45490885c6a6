//! Vectors of the plane.

use super::Point;

pub(crate) fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

pub(crate) fn scaled(a: Point, s: f64) -> Point {
    [a[0] * s, a[1] * s]
}

/// `a + s b`.
pub(crate) fn along(a: Point, s: f64, b: Point) -> Point {
    [a[0] + s * b[0], a[1] + s * b[1]]
}

pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// The z component of the cross product; positive when `b` is to the left of `a`.
pub(crate) fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(crate) fn norm(a: Point) -> f64 {
    a[0].hypot(a[1])
}

pub(crate) fn distance(a: Point, b: Point) -> f64 {
    norm(sub(a, b))
}

/// `a` at 0, `b` at 1.
pub(crate) fn between(a: Point, b: Point, t: f64) -> Point {
    [(1.0 - t) * a[0] + t * b[0], (1.0 - t) * a[1] + t * b[1]]
}

/// The unit vector at an angle, rad.
pub(crate) fn direction(angle: f64) -> Point {
    [angle.cos(), angle.sin()]
}
