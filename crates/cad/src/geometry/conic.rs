//! [`Conic`]: arcs of circles and ellipses alike, `centre + cos(u) major + sin(u) minor`.

use super::vector::{along, cross, direction, dot, norm, sub};
use super::{Bounds, Point};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// However small the pieces are asked for.
const MAX_PIECES: f64 = 4096.0;

/// An arc of a circle or an ellipse.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Conic {
    pub(crate) centre: Point,
    pub(crate) major: Point,
    pub(crate) minor: Point,
    pub(crate) start: f64,
    pub(crate) sweep: f64,
}

impl Conic {
    pub(crate) fn arc(centre: Point, radius: f64, start: f64, sweep: f64) -> Self {
        Self { centre, major: [radius, 0.0], minor: [0.0, radius], start, sweep }
    }

    /// The image of a point of the plane of the unit circle.
    pub(crate) fn image(&self, unit: Point) -> Point {
        along(along(self.centre, unit[0], self.major), unit[1], self.minor)
    }

    pub(crate) fn at_angle(&self, u: f64) -> Point {
        self.image(direction(u))
    }

    pub(crate) fn point(&self, t: f64) -> Point {
        self.at_angle(self.start + t * self.sweep)
    }

    /// Derivative by `t`.
    pub(crate) fn derivative(&self, t: f64) -> Point {
        let (sin, cos) = (self.start + t * self.sweep).sin_cos();
        let turned = along([0.0; 2], -sin * self.sweep, self.major);
        along(turned, cos * self.sweep, self.minor)
    }

    /// True if the parameter `u`, in whichever turn, is on the arc.
    pub(crate) fn covers(&self, u: f64) -> bool {
        let ahead = (u - self.start) * self.sweep.signum();
        ahead.rem_euclid(TAU) <= self.sweep.abs()
    }

    /// The half axes bound each coordinate; its extremes are at `tan u = minor/major`.
    pub(crate) fn bounds(&self) -> Bounds {
        let ends = Bounds::of([self.point(0.0), self.point(1.0)]);
        let mut bounds = ends;
        for k in 0..2 {
            let u = self.minor[k].atan2(self.major[k]);
            let reach = self.major[k].hypot(self.minor[k]);
            if self.covers(u) {
                bounds.max[k] = bounds.max[k].max(self.centre[k] + reach);
            }
            if self.covers(u + PI) {
                bounds.min[k] = bounds.min[k].min(self.centre[k] - reach);
            }
        }
        bounds
    }

    /// No point is further from the centre.
    pub(crate) fn reach(&self) -> f64 {
        norm([norm(self.major), norm(self.minor)])
    }

    /// The arc in pieces of at most `largest` each.
    pub(crate) fn pieces(&self, largest: f64) -> impl Iterator<Item = Self> + use<> {
        let whole = *self;
        let n = (whole.sweep.abs() / largest).ceil().clamp(1.0, MAX_PIECES);
        let step = whole.sweep / n;
        let piece =
            move |i: u32| Self { start: whole.start + f64::from(i) * step, sweep: step, ..whole };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "1 to MAX_PIECES"
        )]
        let n = n as u32;
        (0..n).map(piece)
    }

    pub(crate) fn quarters(&self) -> impl Iterator<Item = Self> + use<> {
        // A little more than a quarter, so that rounding makes no fifth piece of a full turn.
        self.pieces(FRAC_PI_2 * (1.0 + 1e-9))
    }

    /// The point where the tangents at the ends meet, when `p` lies between the arc and its chord.
    ///
    /// For pieces of at most a quarter turn.
    pub(crate) fn corner_beyond(&self, p: Point) -> Option<Point> {
        let determinant = cross(self.major, self.minor);
        let from_centre = sub(p, self.centre);
        let unit = [
            cross(from_centre, self.minor) / determinant,
            cross(self.major, from_centre) / determinant,
        ];
        let middle = direction(self.start + 0.5 * self.sweep);
        let depth = (0.5 * self.sweep).cos();
        let is_between = dot(unit, unit) < 1.0 && dot(unit, middle) > depth;
        is_between.then(|| self.image([middle[0] / depth, middle[1] / depth]))
    }
}
