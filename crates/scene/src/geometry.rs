//! Polygons in a plane: circles, blocks, rounded hulls; and planes in space.

use std::f64::consts::{FRAC_PI_2, TAU};

/// A point of a plane.
pub(crate) type Point = [f64; 2];

/// Corners of the polygon that stands for a full circle: its edges deviate by a thousandth of the
/// radius.
const CORNERS: f64 = 64.0;

/// A plane of a body's frame, with its axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    pub(crate) origin: [f64; 3],
    pub(crate) u: [f64; 3],
    pub(crate) v: [f64; 3],
}

impl Plane {
    /// The plane z = 0, of planar mechanisms.
    pub(crate) const XY: Self = Self { origin: [0.0; 3], u: [1.0, 0.0, 0.0], v: [0.0, 1.0, 0.0] };

    /// A point of the plane in the frame of the body.
    pub(crate) fn lift(&self, [x, y]: Point) -> [f64; 3] {
        std::array::from_fn(|i| self.origin[i] + x * self.u[i] + y * self.v[i])
    }

    /// The foot of a point in the plane.
    pub(crate) fn foot(&self, p: [f64; 3]) -> Point {
        let d = std::array::from_fn(|i| p[i] - self.origin[i]);
        [dot3(d, self.u), dot3(d, self.v)]
    }

    /// Points of the plane in the frame of the body.
    pub(crate) fn lifted(&self, points: &[Point]) -> Vec<[f64; 3]> {
        points.iter().map(|&p| self.lift(p)).collect()
    }
}

pub(crate) fn dot3(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross3(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = a;
    let [p, q, r] = b;
    [y * r - z * q, z * p - x * r, x * q - y * p]
}

pub(crate) fn sub3(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

/// `a` and `factor` times `b`.
pub(crate) fn along3(a: [f64; 3], factor: f64, b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + factor * b[i])
}

pub(crate) fn length3([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

pub(crate) fn distance3(a: [f64; 3], b: [f64; 3]) -> f64 {
    length3(sub3(a, b))
}

/// The unit vector along `a`, if it has a direction.
pub(crate) fn unit3(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = length3(a);
    let unit = a.map(|x| x / length);
    (unit.iter().all(|x| x.is_finite())).then_some(unit)
}

/// `v` turned by an angle (rad) about a unit vector: Rodrigues' formula.
pub(crate) fn turned3(v: [f64; 3], axis: [f64; 3], angle: f64) -> [f64; 3] {
    let (sin, cos) = angle.sin_cos();
    let turned = along3(scaled3(cos, v), sin, cross3(axis, v));
    along3(turned, (1.0 - cos) * dot3(axis, v), axis)
}

/// `factor` times `v`.
fn scaled3(factor: f64, v: [f64; 3]) -> [f64; 3] {
    v.map(|x| factor * x)
}

/// A unit vector across the unit vector `along`: across `other` too, where that has another
/// direction.
pub(crate) fn across3(along: [f64; 3], other: [f64; 3]) -> [f64; 3] {
    let across = |other| {
        let normal = cross3(other, along);
        if length3(normal) > 1e-6 { unit3(normal) } else { None }
    };
    let axes = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
    let found = std::iter::once(other).chain(axes).find_map(across);
    found.unwrap_or([0.0, 1.0, 0.0])
}

pub(crate) fn add(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1]]
}

pub(crate) fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

pub(crate) fn scaled(factor: f64, a: Point) -> Point {
    [factor * a[0], factor * a[1]]
}

pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(crate) fn length(a: Point) -> f64 {
    a[0].hypot(a[1])
}

pub(crate) fn distance(a: Point, b: Point) -> f64 {
    length(sub(a, b))
}

/// A quarter turn to the left.
pub(crate) fn left(a: Point) -> Point {
    [-a[1], a[0]]
}

/// The unit vector along `a`, or along x when there is none.
pub(crate) fn unit(a: Point) -> Point {
    let unit = scaled(1.0 / length(a), a);
    if unit.iter().all(|x| x.is_finite()) { unit } else { [1.0, 0.0] }
}

/// The unit vector at an angle.
pub(crate) fn direction(angle: f64) -> Point {
    [angle.cos(), angle.sin()]
}

/// The arc from one angle to another, both ends included.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 10 000")]
pub(crate) fn arc(centre: Point, radius: f64, from: f64, to: f64) -> Vec<Point> {
    let n = ((to - from).abs() / TAU * CORNERS).ceil().clamp(1.0, 1e4) as usize;
    let at = |i: usize| from + (to - from) * i as f64 / n as f64;
    (0..=n).map(|i| add(centre, scaled(radius, direction(at(i))))).collect()
}

/// A circle as a polygon.
pub(crate) fn circle(centre: Point, radius: f64) -> Vec<Point> {
    let mut ring = arc(centre, radius, 0.0, TAU);
    ring.pop();
    ring
}

/// A rectangle about its centre, `along` being the unit vector of its length.
pub(crate) fn block(centre: Point, along: Point, half: [f64; 2]) -> Vec<Point> {
    let across = left(along);
    let corner =
        |x: f64, y: f64| add(centre, add(scaled(x * half[0], along), scaled(y * half[1], across)));
    vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]
}

/// The convex hull, anticlockwise, without points on its edges: Andrew's monotone chain.
pub(crate) fn hull(points: &[Point]) -> Vec<Point> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let half = |points: &mut dyn Iterator<Item = &Point>| {
        let mut chain: Vec<Point> = Vec::new();
        for &p in points {
            while let [.., a, b] = chain[..]
                && dot(left(sub(b, a)), sub(p, b)) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut ring = half(&mut sorted.iter());
    ring.extend(half(&mut sorted.iter().rev()));
    ring
}

/// The outline of all points within `radius` of the convex hull: a circle around one point, a
/// capsule around two.
pub(crate) fn rounded_hull(points: &[Point], radius: f64) -> Vec<Point> {
    let corners = hull(points);
    let n = corners.len();
    match corners[..] {
        [] => return Vec::new(),
        [centre] => return circle(centre, radius),
        _ => (),
    }
    let normal = |i: usize| {
        let [x, y] = sub(corners[(i + 1) % n], corners[i]);
        y.atan2(x) - FRAC_PI_2
    };
    let mut ring = Vec::new();
    for i in 0..n {
        let from = normal((i + n - 1) % n);
        let turn = (normal(i) - from).rem_euclid(TAU);
        // A straight corner may turn back by a rounding error: not once around.
        let turn = if turn > TAU - 1e-6 { 0.0 } else { turn };
        ring.extend(arc(corners[i], radius, from, from + turn));
    }
    ring
}

/// Twice the area inside a ring, positive when it runs anticlockwise.
#[cfg(test)]
pub(crate) fn doubled_area(ring: &[Point]) -> f64 {
    let next = |i: usize| ring[(i + 1) % ring.len()];
    (0..ring.len()).map(|i| dot(left(ring[i]), next(i))).sum()
}

/// Distance of a point from the edges of a ring.
pub(crate) fn distance_from_edges(p: Point, ring: &[Point]) -> f64 {
    let n = ring.len();
    let from_edge = |i: usize| {
        let (a, b) = (ring[i], ring[(i + 1) % n]);
        let ab = sub(b, a);
        let part = (dot(sub(p, a), ab) / dot(ab, ab)).clamp(0.0, 1.0);
        let foot = if part.is_finite() { add(a, scaled(part, ab)) } else { a };
        distance(p, foot)
    };
    (0..n).map(from_edge).fold(f64::INFINITY, f64::min)
}

/// True if a point is inside rings, by the even–odd rule.
pub(crate) fn is_inside([x, y]: Point, rings: &[Vec<Point>]) -> bool {
    let mut is_inside = false;
    for ring in rings {
        for (i, a) in ring.iter().enumerate() {
            let b = ring[(i + 1) % ring.len()];
            let is_between = (a[1] > y) != (b[1] > y);
            if is_between && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
                is_inside = !is_inside;
            }
        }
    }
    is_inside
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn check_area(ring: &[Point], expected: f64) {
        let area = 0.5 * doubled_area(ring);
        // An inscribed polygon is smaller, by 2π²/3n² of the round parts.
        assert!(area <= expected && area > 0.998 * expected, "{area} against {expected}");
    }

    #[test]
    fn round_shapes_have_the_areas_of_the_formulas() {
        check_area(&circle([3.0, -1.0], 2.0), 4.0 * PI);
        check_area(&rounded_hull(&[[1.0, 1.0], [4.0, 5.0]], 0.5), 0.25 * PI + 5.0);
        // A triangle: area, perimeter times radius, and one circle.
        let triangle = [[0.0, 0.0], [3.0, 0.0], [0.0, 4.0], [1.0, 1.0]];
        check_area(&rounded_hull(&triangle, 0.5), 6.0 + 12.0 * 0.5 + 0.25 * PI);
    }

    #[test]
    fn a_hull_keeps_its_points_inside_by_the_radius() {
        let points = [[0.0, 0.0], [1.0, 0.0], [2.0, 1e-17], [0.7, 0.9], [0.5, 0.1], [2.0, 0.0]];
        let ring = rounded_hull(&points, 0.25);
        for p in points {
            let gap = distance_from_edges(p, &ring);
            assert!(gap >= 0.25 * (1.0 - 2e-3), "{p:?} is {gap} from the edge");
        }
    }

    #[test]
    fn a_hole_is_outside() {
        let rings = [circle([0.0; 2], 2.0), circle([0.5, 0.0], 1.0)];
        for (p, expected) in [([-1.0, 0.1], true), ([0.5, 0.1], false), ([3.0, 0.1], false)] {
            assert_eq!(is_inside(p, &rings), expected, "{p:?}");
        }
    }

    #[test]
    fn points_in_line_and_points_together_make_a_capsule_and_a_circle() {
        let line: Vec<Point> = (0..9).map(|i| [0.1 * f64::from(i), 0.3 * f64::from(i)]).collect();
        let capsule = rounded_hull(&line, 0.1);
        check_area(&capsule, 0.01 * PI + 0.2 * distance(line[0], line[8]));
        check_area(&rounded_hull(&[[1.0, 2.0]; 4], 0.1), 0.01 * PI);
        assert!(rounded_hull(&[], 1.0).is_empty());
    }
}
