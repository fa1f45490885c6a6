//! Curves as polygons, for pictures.

use super::bezier::Bezier;
use super::curve::Piece;
use super::vector::{cross, distance, sub};
use super::{Curve, Path, Point};
use std::f64::consts::FRAC_PI_2;

/// The most corners one arc or Bézier piece is given, however small the tolerance.
const MAX_CORNERS: usize = 4096;

impl Curve {
    /// Corners after the first end, up to the other one, such that no point of the curve is further
    /// than `tolerance` from the polygon (but at most 4096 corners for an arc or a span).
    pub(crate) fn corners_into(&self, tolerance: f64, corners: &mut Vec<Point>) {
        for piece in self.pieces() {
            match piece {
                Piece::Line([_, to]) => corners.push(to),
                Piece::Conic(conic) => {
                    // The sagitta of a circle, r (1 − cos(δ/2)); an ellipse has less.
                    let ratio = (1.0 - tolerance / conic.reach()).clamp(-1.0, 1.0);
                    let smallest = conic.sweep.abs() / MAX_CORNERS as f64;
                    let largest = (2.0 * ratio.acos()).min(FRAC_PI_2).max(smallest);
                    corners.extend(conic.pieces(largest).map(|part| part.point(1.0)));
                }
                Piece::Bezier(bezier) => bezier_corners_into(bezier, tolerance, corners),
            }
        }
    }
}

impl Path {
    /// Corners of a polygon that no point of the path is further from than `tolerance`, the first
    /// end first and the last one last; a closed path ends where it begins.
    pub fn flattened(&self, tolerance: f64) -> Vec<Point> {
        let mut corners: Vec<Point> = self.start_point().into_iter().collect();
        for curve in &self.curves {
            curve.corners_into(tolerance, &mut corners);
        }
        corners
    }
}

/// Halves until the control points are near the chord: the curve is in their hull.
fn bezier_corners_into(whole: Bezier, tolerance: f64, corners: &mut Vec<Point>) {
    let mut rest = vec![whole];
    let mut n_corners = 0;
    while let Some(piece) = rest.pop() {
        if n_corners + rest.len() < MAX_CORNERS && !is_flat(&piece, tolerance) {
            let [left, right] = piece.halves();
            rest.extend([right, left]);
        } else {
            corners.push(piece.end_point());
            n_corners += 1;
        }
    }
}

fn is_flat(piece: &Bezier, tolerance: f64) -> bool {
    let (from, to) = (piece.start_point(), piece.end_point());
    let (chord, length) = (sub(to, from), distance(from, to));
    piece.hull().all(|p| {
        let is_beside = cross(chord, sub(p, from)).abs() <= tolerance * length;
        // Beyond the ends of the chord its line says nothing.
        let reach = distance(p, from).max(distance(p, to));
        distance(p, from) <= tolerance || (is_beside && reach <= length)
    })
}
