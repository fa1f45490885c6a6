//! Shapes of bodies that have no outline of their own: a bar about their points, a block on a slide.

use crate::geometry::Point;
use crate::write::canvas::Mark;

/// Everything within `radius` of the hull of some points: a disc, a bar, a plate with round corners.
///
/// `None` without points.
pub(super) fn rounded_hull(points: &[Point], radius: f64) -> Option<Mark> {
    let hull = hull(points);
    let (&first, rest) = hull.split_first()?;
    if rest.is_empty() {
        return Some(Mark::Circle(first, radius));
    }
    // Counter-clockwise; each corner becomes an arc between the offsets of its two edges.
    let n = hull.len();
    let angle = |i: usize| {
        let (from, to) = (hull[i % n], hull[(i + 1) % n]);
        (to[1] - from[1]).atan2(to[0] - from[0])
    };
    let offset = |[x, y]: Point, along: f64| [x + radius * along.sin(), y - radius * along.cos()];
    let corners = (0..n).flat_map(|i| {
        let (before, after) = (angle(i + n - 1), angle(i));
        let turn = (after - before).rem_euclid(std::f64::consts::TAU);
        [(offset(hull[i], before), (turn / 4.0).tan()), (offset(hull[i], after), 0.0)]
    });
    Some(Mark::Polyline { corners: corners.collect(), is_closed: true })
}

/// A block about a point, its long side along a direction.
pub(super) fn block([x, y]: Point, angle: f64, radius: f64) -> Mark {
    let (sin, cos) = angle.sin_cos();
    let corner = |(along, across): (f64, f64)| {
        let (a, b) = (along * radius, across * radius);
        [x + cos * a - sin * b, y + sin * a + cos * b]
    };
    let corners = [(-2.0, -1.3), (2.0, -1.3), (2.0, 1.3), (-2.0, 1.3)].map(corner);
    Mark::chain(&corners, true)
}

/// The corners of the convex hull, counter-clockwise.
///
/// Source: Andrew (1979), "Another efficient algorithm for convex hulls in two dimensions".
fn hull(points: &[Point]) -> Vec<Point> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let size = sorted.iter().flatten().fold(0.0, |size: f64, x| size.max(x.abs()));
    sorted.dedup_by(|a, b| (a[0] - b[0]).hypot(a[1] - b[1]) <= 1e-9 * size);
    if sorted.len() < 3 {
        return sorted;
    }
    let turn = |a: Point, b: Point, c: Point| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    // A corner that hardly turns would be an arc without length.
    let flat = 1e-12 * size * size;
    let half = |points: &mut dyn Iterator<Item = Point>| {
        let mut chain: Vec<Point> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..]
                && turn(a, b, p) <= flat
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut corners = half(&mut sorted.iter().copied());
    corners.extend(half(&mut sorted.iter().rev().copied()));
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_points_make_a_bar_with_half_circles() {
        let Some(Mark::Polyline { corners, is_closed: true }) =
            rounded_hull(&[[0.0, 0.0], [3.0, 0.0], [1.0, 0.0]], 0.5)
        else {
            panic!("not a bar");
        };
        let bulges: Vec<f64> = corners.iter().map(|(_, bulge)| *bulge).collect();
        assert_eq!(corners.len(), 4);
        for (bulge, expected) in bulges.iter().zip([1.0, 0.0, 1.0, 0.0]) {
            assert!((bulge - expected).abs() < 1e-12, "{bulge} is not {expected}");
        }
        let reach = corners.iter().all(|([_, y], _)| (y.abs() - 0.5).abs() < 1e-12);
        assert!(reach, "{corners:?}");
    }

    #[test]
    fn corners_of_a_plate_are_where_the_points_are() {
        let points = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0], [2.0, 1.0]];
        let Some(Mark::Polyline { corners, .. }) = rounded_hull(&points, 1.0) else {
            panic!("not a plate");
        };
        assert_eq!(corners.len(), 8);
        let quarter = (std::f64::consts::PI / 8.0).tan();
        for (i, (_, bulge)) in corners.iter().enumerate() {
            let expected = if i % 2 == 0 { quarter } else { 0.0 };
            assert!((bulge - expected).abs() < 1e-12, "{bulge} is not {expected}");
        }
    }
}
