//! [`Path`]: made from the polylines and circles of a drawing.

use super::error::check_points;
use super::vector::{along, between, distance, sub};
use super::{Bounds, Curve, GeometryError, Path, Point};
use std::f64::consts::TAU;

/// A vertex of a polyline and the bulge of what follows it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Vertex {
    /// Where it is.
    pub at: Point,
    /// The tangent of a quarter of the sweep of the arc to the next vertex: 0 for a straight line,
    /// 1 for a half circle; positive counter-clockwise.
    pub bulge: f64,
}

/// Below this bulge an arc is drawn straight: it leaves its chord by less than the rounding of a
/// centre as far away as `chord/(4 bulge)` would move it.
const STRAIGHT: f64 = 1e-8;

impl Path {
    /// One curve by itself.
    pub fn of(curve: Curve) -> Self {
        Self { curves: vec![curve], is_closed: false }
    }

    /// A whole circle, counter-clockwise.
    pub fn circle(centre: Point, radius: f64) -> Self {
        let circle = Curve::Arc { centre, radius, start: 0.0, sweep: TAU };
        Self { curves: vec![circle], is_closed: true }
    }

    /// A polyline of lines and arcs; vertices that repeat make no curve.
    ///
    /// The arc over the chord `p q` with bulge `b` has its centre at
    /// `(p + q)/2 + (1 − b²)/(4b) n`, where `n` is `q − p` turned by a quarter to the left, and
    /// sweeps `4 arctan b`.
    ///
    /// # Errors
    /// [`GeometryError`] for numbers that are none, and when no two vertices differ.
    pub fn from_bulges(vertices: &[Vertex], is_closed: bool) -> Result<Self, GeometryError> {
        check_points(vertices.iter().flat_map(|v| [v.at, [v.bulge, 0.0]]))?;
        let following = vertices.iter().cycle().skip(1);
        let n_pieces = if is_closed { vertices.len() } else { vertices.len().saturating_sub(1) };
        let curves: Vec<Curve> = vertices
            .iter()
            .zip(following)
            .take(n_pieces)
            .filter(|(vertex, next)| vertex.at != next.at)
            .map(|(vertex, next)| over_chord(vertex.at, next.at, vertex.bulge))
            .collect();
        let path = Self { curves, is_closed };
        path.check()?;
        Ok(path)
    }

    /// The beginning of the first curve; `None` without curves.
    pub fn start_point(&self) -> Option<Point> {
        self.curves.first().map(Curve::start_point)
    }

    /// The end of the last curve; `None` without curves.
    pub fn end_point(&self) -> Option<Point> {
        self.curves.last().map(Curve::end_point)
    }

    /// Path from its other end.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self {
            curves: self.curves.iter().rev().map(Curve::reversed).collect(),
            is_closed: self.is_closed,
        }
    }

    /// The smallest box around the path, to rounding.
    pub fn bounds(&self) -> Bounds {
        self.curves.iter().map(Curve::bounds).fold(Bounds::EMPTY, Bounds::union)
    }

    /// The sum of the lengths of its curves.
    pub fn length(&self) -> f64 {
        self.curves.iter().map(Curve::length).sum()
    }
}

fn over_chord(p: Point, q: Point, bulge: f64) -> Curve {
    if bulge.abs() < STRAIGHT {
        return Curve::Segment { from: p, to: q };
    }
    let [dx, dy] = sub(q, p);
    // (1 − b²)/(4b) written so that half circles have their centre exactly on the chord.
    let offset = (1.0 - bulge) * (1.0 + bulge) / (4.0 * bulge);
    let centre = along(between(p, q, 0.5), offset, [-dy, dx]);
    let radius = distance(p, q) * (1.0 + bulge * bulge) / (4.0 * bulge.abs());
    let [ex, ey] = sub(p, centre);
    Curve::Arc { centre, radius, start: ey.atan2(ex), sweep: 4.0 * bulge.atan() }
}
