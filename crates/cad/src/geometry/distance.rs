//! Nearest distances from points to curves.

use super::curve::Piece;
use super::vector::{cross, distance, dot, norm, sub};
use super::{Curve, Path, Point};

/// Samples per quarter of an ellipse or span of a spline; each stretch between three samples is
/// taken to have one nearest point.
const SAMPLES: u32 = 32;

/// Golden sections of such a stretch: 0.618⁴⁵ is below the square root of rounding.
const SECTIONS: usize = 45;

impl Curve {
    /// Distance from `point` to the nearest point of the curve: exact for lines and arcs, a search
    /// along the others.
    pub fn distance(&self, point: Point) -> f64 {
        self.distance_below(point, f64::INFINITY)
    }

    /// Distance as of [`Self::distance`] if it is below `least`, otherwise `least`; pieces whose box is farther away are
    /// not searched.
    fn distance_below(&self, point: Point, least: f64) -> f64 {
        if let Self::Arc { centre, radius, .. } = self {
            let [x, y] = sub(point, *centre);
            let ends = distance(point, self.start_point()).min(distance(point, self.end_point()));
            let is_abeam = self.conic().is_some_and(|conic| conic.covers(y.atan2(x)));
            return least.min(if is_abeam { (norm([x, y]) - radius).abs() } else { ends });
        }
        let pieces = self.pieces();
        // Ends of pieces are on the curve.
        let ends = pieces.iter().filter_map(|piece| match piece {
            Piece::Bezier(bezier) => Some(distance(point, bezier.end_point())),
            _ => None,
        });
        let least = ends.fold(least, f64::min);
        pieces.into_iter().fold(least, |least, piece| {
            let found = match piece {
                Piece::Line(ends) => to_line(point, ends),
                Piece::Conic(conic) => {
                    let parts = conic.quarters();
                    parts.map(|part| search(point, |t| part.point(t))).fold(least, f64::min)
                }
                Piece::Bezier(bezier) if bezier.hull_bounds().distance(point) < least => {
                    search(point, |t| bezier.point(t))
                }
                Piece::Bezier(_) => least,
            };
            least.min(found)
        })
    }
}

impl Path {
    /// Distance from `point` to the nearest point of the path; infinite without curves.
    pub fn distance(&self, point: Point) -> f64 {
        self.distance_within(point, f64::INFINITY)
    }

    /// Distance as of [`Self::distance`] if it is below `reach`, otherwise `reach`.
    pub fn distance_within(&self, point: Point, reach: f64) -> f64 {
        self.curves.iter().fold(reach, |least, curve| curve.distance_below(point, least))
    }
}

fn to_line(p: Point, [from, to]: [Point; 2]) -> f64 {
    let (line, offset) = (sub(to, from), sub(p, from));
    let share = dot(offset, line) / dot(line, line);
    if share > 0.0 && share < 1.0 {
        cross(line, offset).abs() / norm(line)
    } else {
        distance(p, from).min(distance(p, to))
    }
}

/// The smallest distance along `0 ≤ t ≤ 1`, by samples and golden sections about the least ones.
fn search(p: Point, at: impl Fn(f64) -> Point) -> f64 {
    let away = |t: f64| distance(p, at(t));
    let t = |i: u32| f64::from(i) / f64::from(SAMPLES);
    let samples: Vec<f64> = (0..=SAMPLES).map(|i| away(t(i))).collect();
    let mut least = samples.iter().copied().fold(f64::INFINITY, f64::min);
    for i in 1..SAMPLES {
        let k = i as usize;
        if samples[k] <= samples[k - 1] && samples[k] <= samples[k + 1] {
            least = least.min(golden(&away, t(i - 1), t(i + 1)));
        }
    }
    // The nearest point may be between an end and the sample next to it.
    least.min(golden(&away, 0.0, t(1))).min(golden(&away, t(SAMPLES - 1), 1.0))
}

fn golden(f: &impl Fn(f64) -> f64, mut from: f64, mut to: f64) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let mut inner = [to - ratio * (to - from), from + ratio * (to - from)];
    let mut values = inner.map(f);
    for _ in 0..SECTIONS {
        if values[0] < values[1] {
            (to, inner[1], values[1]) = (inner[1], inner[0], values[0]);
            inner[0] = to - ratio * (to - from);
            values[0] = f(inner[0]);
        } else {
            (from, inner[0], values[0]) = (inner[0], inner[1], values[1]);
            inner[1] = from + ratio * (to - from);
            values[1] = f(inner[1]);
        }
    }
    values[0].min(values[1])
}
