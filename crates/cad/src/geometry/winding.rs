//! How often a closed path winds about a point, on the curves as they are.
//!
//! The winding number does not change when a piece of the path is moved without passing over the
//! point. So every piece is replaced by straight lines with the same ends: by its chord when the
//! point is not between the two, else by lines beyond the piece; and the winding of the polygon is
//! counted by its crossings of a ray (Hormann & Agathos 2001).

use super::bezier::{Bezier, MAX_HALVINGS, ROUNDING};
use super::conic::Conic;
use super::curve::Piece;
use super::vector::{cross, sub};
use super::{Curve, Path, Point};

/// Draws a polygon and counts how often it winds about a point.
pub(crate) struct Pen {
    about: Point,
    first: Option<Point>,
    at: Point,
    winding: i32,
}

impl Pen {
    pub(crate) fn new(about: Point) -> Self {
        Self { about, first: None, at: about, winding: 0 }
    }

    pub(crate) fn line_to(&mut self, to: Point) {
        if self.first.is_none() {
            self.first = Some(to);
        } else {
            self.winding += crossing(self.about, self.at, to);
        }
        self.at = to;
    }

    /// Follows the curve, or lines that wind about the point as the curve does.
    pub(crate) fn follow(&mut self, curve: &Curve) {
        for piece in curve.pieces() {
            match piece {
                Piece::Line(ends) => ends.into_iter().for_each(|end| self.line_to(end)),
                Piece::Conic(conic) => conic.quarters().for_each(|quarter| self.quarter(&quarter)),
                Piece::Bezier(bezier) => self.bezier(bezier),
            }
        }
    }

    fn quarter(&mut self, quarter: &Conic) {
        self.line_to(quarter.point(0.0));
        if let Some(corner) = quarter.corner_beyond(self.about) {
            self.line_to(corner);
        }
        self.line_to(quarter.point(1.0));
    }

    /// Halves the piece while the point is in the box of its control points.
    fn bezier(&mut self, whole: Bezier) {
        self.line_to(whole.start_point());
        let mut rest = vec![whole];
        let mut n_halvings = 0;
        while let Some(piece) = rest.pop() {
            let hull = piece.hull_bounds();
            let is_small = hull.diagonal() <= ROUNDING * hull.magnitude();
            if !hull.contains(self.about) || is_small || n_halvings == MAX_HALVINGS {
                self.line_to(piece.end_point());
            } else {
                let [left, right] = piece.halves();
                rest.extend([right, left]);
                n_halvings += 1;
            }
        }
    }

    /// Closes the polygon: its winding number, positive counter-clockwise.
    pub(crate) fn close(mut self) -> i32 {
        if let Some(first) = self.first {
            self.line_to(first);
        }
        self.winding
    }
}

/// Upward crossings of the ray to the right of `p` count one, downward ones minus one; a corner on
/// the ray belongs to what is above it.
fn crossing(p: Point, a: Point, b: Point) -> i32 {
    let is_left = || cross(sub(b, a), sub(p, a));
    if a[1] <= p[1] && b[1] > p[1] && is_left() > 0.0 {
        1
    } else if a[1] > p[1] && b[1] <= p[1] && is_left() < 0.0 {
        -1
    } else {
        0
    }
}

impl Path {
    /// How often the path winds counter-clockwise about `point`, on the curves as they are; an
    /// open path is closed by a straight line. Points on the path are on either side.
    pub fn winding(&self, point: Point) -> i32 {
        let mut pen = Pen::new(point);
        self.curves.iter().for_each(|curve| pen.follow(curve));
        pen.close()
    }
}
