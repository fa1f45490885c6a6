//! Regions of the plane: unions of polygons.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::float::simplify::SimplifyShape;

type Point = [f64; 2];

/// Polygons that are united at once: few, since each may cross all others.
const AT_ONCE: usize = 4;

/// The boundary of the union of polygons; holes of the union are boundaries, too.
///
/// United by fours, and those unions again, so that what lies inside is gone early. The grid of
/// 2³² lines makes one of edges that differ by rounding alone, as those of a periodic motion do.
pub fn union(polygons: &[Vec<Point>]) -> Vec<Vec<Point>> {
    let counter_clockwise = |polygon: &Vec<Point>| {
        let mut polygon = polygon.clone();
        if doubled_area(&polygon) < 0.0 {
            polygon.reverse();
        }
        vec![polygon]
    };
    let mut regions: Vec<Vec<Vec<Point>>> = polygons.iter().map(counter_clockwise).collect();
    loop {
        let unite = |regions: &[Vec<Vec<Point>>]| -> Vec<Vec<Point>> {
            let shapes = regions.concat().simplify_shape(FillRule::NonZero);
            shapes.into_iter().flatten().collect()
        };
        regions = regions.chunks(AT_ONCE).map(unite).collect();
        if regions.len() <= 1 {
            return regions.pop().unwrap_or_default();
        }
    }
}

/// The smallest convex polygon around points, counter-clockwise: Andrew's monotone chains.
pub(crate) fn hull(points: &[Point]) -> Vec<Point> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut hull: Vec<Point> = Vec::new();
    for pass in 0..2 {
        let first = hull.len();
        for p in &sorted {
            while hull.len() >= first + 2
                && turn(hull[hull.len() - 2], hull[hull.len() - 1], *p) <= 0.0
            {
                hull.pop();
            }
            hull.push(*p);
        }
        // The last of a chain is the first of the next one.
        hull.pop();
        if pass == 0 {
            sorted.reverse();
        }
    }
    hull
}

/// Twice the area of a triangle, positive to the left.
fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Twice the area of a polygon, positive when counter-clockwise.
pub(crate) fn doubled_area(polygon: &[Point]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64) -> Vec<Point> {
        vec![[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]]
    }

    #[test]
    fn overlapping_squares_unite_whichever_way_they_turn() {
        let mut second = square(0.5);
        second.reverse();
        let united = union(&[square(0.0), second]);
        assert_eq!(united.len(), 1);
        let area = doubled_area(&united[0]).abs() / 2.0;
        assert!((area - 1.5).abs() < 1e-6, "{area}");
    }

    #[test]
    fn a_bar_that_turns_round_and_round_sweeps_a_disc() {
        let turned = |i: u32| {
            let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 120.0).sin_cos();
            let corners = [[-1.0, -0.1], [1.0, -0.1], [1.0, 0.1], [-1.0, 0.1]];
            corners.map(|[x, y]| [100.0 + cos * x - sin * y, sin * x + cos * y]).to_vec()
        };
        // Twice around: the second time, all edges lie on those of the first but for rounding.
        let outlines: Vec<Vec<Point>> = (0..240).map(turned).collect();
        let area: f64 = union(&outlines).iter().map(|edge| doubled_area(edge).abs() / 2.0).sum();
        let disc = std::f64::consts::PI * 1.01;
        assert!((0.99..1.0).contains(&(area / disc)), "{area} of {disc}");
    }

    #[test]
    fn a_ring_of_squares_keeps_its_hole() {
        let bar = |low: Point, high: Point| vec![low, [high[0], low[1]], high, [low[0], high[1]]];
        let ring = [
            bar([0.0, 0.0], [3.0, 1.0]),
            bar([2.0, 0.0], [3.0, 3.0]),
            bar([0.0, 2.0], [3.0, 3.0]),
            bar([0.0, 0.0], [1.0, 3.0]),
        ];
        let mut areas: Vec<f64> =
            union(&ring).iter().map(|edge| doubled_area(edge).abs() / 2.0).collect();
        areas.sort_by(f64::total_cmp);
        assert_eq!(areas.len(), 2);
        assert!((areas[0] - 1.0).abs() < 1e-6 && (areas[1] - 9.0).abs() < 1e-6, "{areas:?}");
    }
}
