//! Six-bars whose output rests while a coupler point goes nearly along a line: a block at the point slides in the slot of an
//! arm, whose pivot is on that line.
//!
//! ```text
//! ψ(φ) = arg(P(φ) − G)      G on the line, so far away that ψ swings as wanted
//! ```
//!
//! Source: Norton, Design of Machinery, ch. 3.9, dwells from straight parts of coupler curves.

use std::f64::consts::TAU;

use super::curves::{Curve, FINE, Part, Shape, places, pose, width};
use super::four_bar::{FourBar, Second, distance};
use super::{Candidate, Point};

/// A line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    at: Point,
    along: Point,
}

impl Line {
    /// The line that is nearest to points, by the sum of squares of their distances.
    fn through(points: &[Point]) -> Self {
        let share = 1.0 / points.len() as f64;
        let mean = |axis: usize| points.iter().map(|p| p[axis]).sum::<f64>() * share;
        let at = [mean(0), mean(1)];
        let moment = |i: usize, j: usize| {
            points.iter().map(|p| (p[i] - at[i]) * (p[j] - at[j])).sum::<f64>()
        };
        let angle = 0.5 * (2.0 * moment(0, 1)).atan2(moment(0, 0) - moment(1, 1));
        Self { at, along: [angle.cos(), angle.sin()] }
    }

    /// Place of a point along the line, and its distance from it.
    fn place(&self, p: Point) -> [f64; 2] {
        let off = [p[0] - self.at[0], p[1] - self.at[1]];
        let [x, y] = self.along;
        [off[0] * x + off[1] * y, (off[1] * x - off[0] * y).abs()]
    }

    fn point(&self, place: f64) -> Point {
        [self.at[0] + place * self.along[0], self.at[1] + place * self.along[1]]
    }
}

/// The straightest part of a coupler curve for a dwell.
pub(super) fn straight(shape: &Shape, dwell: f64) -> Option<Part<Line>> {
    let curve = Curve::of(shape)?;
    curve.best(dwell, |points| {
        let line = Line::through(points);
        let far = |points: &[Point]| points.iter().map(|p| line.place(*p)[1]).fold(0.0, f64::max);
        Some((line, [far(points), far(&curve.points)]))
    })
}

/// Angles of an arm over a turn, each less than half a turn from the one before.
fn angles(points: &[Point], pivot: Point) -> Vec<f64> {
    let mut all = Vec::<f64>::with_capacity(points.len());
    for p in points {
        let psi = (p[1] - pivot[1]).atan2(p[0] - pivot[0]);
        let turns = all.last().map_or(0.0, |last| ((last - psi) / TAU).round());
        all.push(psi + TAU * turns);
    }
    all
}

/// The pivot on the line from which the arm swings as wanted, on the side on which it is shorter.
fn pivot(curve: &Curve, line: &Line, swing: f64) -> Option<Point> {
    /// Distances of the pivot beyond the curve, in extents of it: room for the block, and the longest arm.
    const NEAREST: f64 = 0.1;
    const FARTHEST: f64 = 20.0;
    let on_side = |side: f64| {
        let beyond = |p: &Point| side * line.place(*p)[0];
        let edge = curve.points.iter().map(beyond).fold(f64::NEG_INFINITY, f64::max);
        let of = |away: f64| width(&angles(&curve.points, line.point(side * (edge + away))));
        let (mut near, mut far) = (NEAREST * curve.extent, FARTHEST * curve.extent);
        if of(near) < swing || of(far) > swing {
            return None;
        }
        for _ in 0..60 {
            let middle = 0.5 * (near + far);
            if of(middle) > swing { near = middle } else { far = middle }
        }
        Some((edge + far, line.point(side * (edge + far))))
    };
    let sides = [1.0, -1.0].into_iter().filter_map(on_side);
    sides.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, pivot)| pivot)
}

/// The six-bar at its size, with what a fine turn of its crank shows.
pub(super) fn candidate(
    shape: &Shape,
    part: &Part<Line>,
    swing: f64,
    (dwell, ground): (f64, f64),
) -> Option<Candidate> {
    let pivot = pivot(&Curve::of(shape)?, &part.on, swing)?;
    let bars = (0..=FINE).map(|k| pose(shape, part.from + TAU * k as f64 / FINE as f64));
    let bars = bars.collect::<Option<Vec<FourBar>>>()?;
    let points = bars.iter().map(|bar| bar.point).collect::<Option<Vec<Point>>>()?;
    let all = angles(&points, pivot);
    let n = places(dwell, FINE).min(FINE);
    let reach = |fold: fn(f64, f64) -> f64| {
        points.iter().map(|p| distance(*p, pivot)).reduce(fold).map(|reach| reach * ground)
    };
    let (nearest, farthest) = (reach(f64::min)?, reach(f64::max)?);
    let scaled = |p: Point| p.map(|x| x * ground);
    let first = &bars[0];
    let bar = FourBar {
        pivots: first.pivots.map(scaled),
        pins: first.pins.map(scaled),
        point: first.point.map(scaled),
    };
    let pivot = scaled(pivot);
    let mut found = bar.candidate("dwell");
    found.model = bar.model_with("dwell", Some(Second::Slide(pivot, farthest)));
    let least = bars.iter().map(FourBar::transmission).fold(f64::INFINITY, f64::min);
    for (name, value) in [
        ("dwell", dwell),
        ("dwell_from", part.from),
        ("dwell_error", width(&all[..=n])),
        ("swing", width(&all)),
        ("slide_from", nearest),
        ("slide_to", farthest),
        ("pivot_3_x", pivot[0]),
        ("pivot_3_y", pivot[1]),
        ("point_along_coupler", shape[3] * ground),
        ("point_left_of_coupler", shape[4] * ground),
        ("least_transmission_angle", least),
    ] {
        found.numbers.insert(name.to_owned(), value);
    }
    Some(found)
}
