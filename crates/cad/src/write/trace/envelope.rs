//! The region that a body sweeps: the union of the places it takes.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::float::simplify::SimplifyShape;

use crate::geometry::Point;

/// The boundary of the union of polygons; holes of the union are boundaries, too.
pub(super) fn union(polygons: &[Vec<Point>]) -> Vec<Vec<Point>> {
    let counter_clockwise = |polygon: &Vec<Point>| {
        let mut polygon = polygon.clone();
        if doubled_area(&polygon) < 0.0 {
            polygon.reverse();
        }
        polygon
    };
    let all: Vec<Vec<Point>> = polygons.iter().map(counter_clockwise).collect();
    // A grid of 2⁶⁴ lines over the extent: what is rounded is far below the digits of a drawing.
    let shapes = all.simplify_shape_as::<i64>(FillRule::NonZero);
    shapes.into_iter().flatten().collect()
}

/// Twice the area of a polygon, positive when counter-clockwise.
pub(super) fn doubled_area(polygon: &[Point]) -> f64 {
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
        assert!((area - 1.5).abs() < 1e-9, "{area}");
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
        assert!((areas[0] - 1.0).abs() < 1e-9 && (areas[1] - 9.0).abs() < 1e-9, "{areas:?}");
    }
}
