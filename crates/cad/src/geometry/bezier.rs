//! [`Bezier`]: one span of a rational B-spline.
//!
//! ```text
//! r(t) = Σ B_i(t) w_i p_i / Σ B_i(t) w_i,   0 ≤ t ≤ 1
//! ```
//!
//! Points are kept as `(w x, w y, w)`. With weights greater than zero the curve lies in the convex
//! hull of its control points, which is what bounds, windings and flattening lean on
//! (Piegl & Tiller, The NURBS Book, chapter 1).

use super::{Bounds, Point};

/// A control point `(w x, w y, w)`.
pub(crate) type Homogeneous = [f64; 3];

pub(crate) fn mix(a: Homogeneous, b: Homogeneous, t: f64) -> Homogeneous {
    [0, 1, 2].map(|k| (1.0 - t) * a[k] + t * b[k])
}

pub(crate) fn projected(p: Homogeneous) -> Point {
    [p[0] / p[2], p[1] / p[2]]
}

/// One rational polynomial piece; at least two control points.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Bezier {
    pub(crate) points: Vec<Homogeneous>,
}

impl Bezier {
    pub(crate) fn start_point(&self) -> Point {
        projected(self.points[0])
    }

    pub(crate) fn end_point(&self) -> Point {
        projected(self.points[self.points.len() - 1])
    }

    /// The control points.
    pub(crate) fn hull(&self) -> impl Iterator<Item = Point> {
        self.points.iter().map(|p| projected(*p))
    }

    /// The box of the control points; the curve stays within.
    pub(crate) fn hull_bounds(&self) -> Bounds {
        Bounds::of(self.hull())
    }

    /// Point and derivative at `t`, by de Casteljau.
    pub(crate) fn at(&self, t: f64) -> (Point, Point) {
        let mut row = self.points.clone();
        let degree = row.len() - 1;
        while row.len() > 2 {
            shrink(&mut row, t);
        }
        let velocity = [0, 1, 2].map(|k| degree as f64 * (row[1][k] - row[0][k]));
        let at = mix(row[0], row[1], t);
        let point = projected(at);
        (point, [0, 1].map(|k| (velocity[k] - point[k] * velocity[2]) / at[2]))
    }

    pub(crate) fn point(&self, t: f64) -> Point {
        self.at(t).0
    }

    /// The pieces before and after `t = ½`.
    pub(crate) fn halves(&self) -> [Self; 2] {
        let mut row = self.points.clone();
        let (mut left, mut right) = (vec![row[0]], vec![row[row.len() - 1]]);
        while row.len() > 1 {
            shrink(&mut row, 0.5);
            left.push(row[0]);
            right.push(row[row.len() - 1]);
        }
        right.reverse();
        [Self { points: left }, Self { points: right }]
    }

    /// The smallest box around the curve, to rounding.
    ///
    /// Halves whatever piece could still reach beyond the points known to be on the curve; hulls
    /// close in with the square of the piece's length, so few pieces are halved.
    pub(crate) fn bounds(&self) -> Bounds {
        let mut known = Bounds::of([self.start_point(), self.end_point()]);
        let slack = ROUNDING * self.hull_bounds().magnitude();
        let mut rest = vec![self.clone()];
        for _ in 0..MAX_HALVINGS {
            let Some(piece) = rest.pop() else { break };
            let hull = piece.hull_bounds();
            let reach = known.grown(slack);
            if reach.contains(hull.min) && reach.contains(hull.max) {
                continue;
            }
            let [left, right] = piece.halves();
            known = known.with(left.end_point());
            rest.extend([left, right]);
        }
        known
    }
}

/// The size of rounding, relative to the coordinates.
pub(crate) const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Ends the search on pieces too small for their coordinates to differ.
pub(crate) const MAX_HALVINGS: usize = 4096;

fn shrink(row: &mut Vec<Homogeneous>, t: f64) {
    for i in 1..row.len() {
        row[i - 1] = mix(row[i - 1], row[i], t);
    }
    row.pop();
}
