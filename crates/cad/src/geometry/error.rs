//! [`GeometryError`]: numbers that make no curve.

use super::{Curve, Path, Point, Spline};
use thiserror::Error;

/// Coordinates beyond this are refused: their fourth powers must stay far from overflow.
pub const COORDINATE_LIMIT: f64 = 1e30;

/// The highest degree of a spline that is read; programs write 3, and at most 11.
pub const MAX_DEGREE: usize = 25;

/// A full turn with room for rounding.
pub(super) const TURN: f64 = std::f64::consts::TAU * (1.0 + 1e-9);

/// Why numbers make no curve.
#[derive(Clone, Copy, PartialEq, Debug, Error)]
#[non_exhaustive]
pub enum GeometryError {
    /// A coordinate that is no number or too large.
    #[error("a coordinate is {value}, not a number within ±1e30")]
    Coordinate {
        /// Value as it was read.
        value: f64,
    },
    /// A circle without size.
    #[error("the radius is {radius}, not greater than zero")]
    Radius {
        /// Radius as it was read.
        radius: f64,
    },
    /// An ellipse without size.
    #[error("an axis of the ellipse has no length")]
    Axis,
    /// Angles of an arc that make none.
    #[error("the arc sweeps {sweep} rad")]
    Sweep {
        /// Sweep as it was read.
        sweep: f64,
    },
    /// A polyline or spline of too few points.
    #[error("{found} points where at least {needed} are needed")]
    Points {
        /// How many there are.
        found: usize,
        /// How many there should be.
        needed: usize,
    },
    /// A degree out of range.
    #[error("the degree of the spline is {degree}, not within 1 to {max}", max = MAX_DEGREE)]
    Degree {
        /// Degree as it was read.
        degree: usize,
    },
    /// Knots in a wrong number.
    #[error("{found} knots where degree and control points need {needed}")]
    KnotCount {
        /// How many there are.
        found: usize,
        /// How many there should be.
        needed: usize,
    },
    /// Knots that decrease, or an inner one so often that the curve breaks.
    #[error("knot {index} of the spline is {value}, which breaks the curve")]
    Knot {
        /// From zero.
        index: usize,
        /// Value as it was read.
        value: f64,
    },
    /// Weights in a wrong number.
    #[error("{found} weights for {needed} control points")]
    WeightCount {
        /// How many there are.
        found: usize,
        /// How many there should be.
        needed: usize,
    },
    /// A weight that is not a number greater than zero.
    #[error("weight {index} of the spline is {value}, not greater than zero")]
    Weight {
        /// From zero.
        index: usize,
        /// Value as it was read.
        value: f64,
    },
}

/// Whether all numbers are finite and within [`COORDINATE_LIMIT`].
pub(super) fn check_points(points: impl IntoIterator<Item = Point>) -> Result<(), GeometryError> {
    let bad = |value: &f64| !value.is_finite() || value.abs() > COORDINATE_LIMIT;
    match points.into_iter().flatten().find(bad) {
        Some(value) => Err(GeometryError::Coordinate { value }),
        None => Ok(()),
    }
}

fn check_sweep(start: f64, sweep: f64) -> Result<(), GeometryError> {
    check_points([[start, 0.0]])?;
    if sweep != 0.0 && sweep.abs() <= TURN { Ok(()) } else { Err(GeometryError::Sweep { sweep }) }
}

impl Curve {
    /// Whether the numbers make a curve.
    ///
    /// # Errors
    /// The first thing wrong with them.
    pub fn check(&self) -> Result<(), GeometryError> {
        match self {
            Self::Segment { from, to } => check_points([*from, *to]),
            Self::Arc { centre, radius, start, sweep } => {
                check_points([*centre, [*radius, 0.0]])?;
                if *radius <= 0.0 {
                    return Err(GeometryError::Radius { radius: *radius });
                }
                check_sweep(*start, *sweep)
            }
            Self::Ellipse { centre, major, minor, start, sweep } => {
                check_points([*centre, *major, *minor])?;
                if *major == [0.0; 2] || *minor == [0.0; 2] {
                    return Err(GeometryError::Axis);
                }
                check_sweep(*start, *sweep)
            }
            Self::Spline(spline) => spline.check(),
        }
    }
}

impl Path {
    /// Whether the numbers of all curves make curves.
    ///
    /// # Errors
    /// The first thing wrong with them; a path without curves is wrong too.
    pub fn check(&self) -> Result<(), GeometryError> {
        if self.curves.is_empty() {
            return Err(GeometryError::Points { found: 0, needed: 2 });
        }
        self.curves.iter().try_for_each(Curve::check)
    }
}

impl Spline {
    /// Whether the numbers make a spline that hangs together.
    ///
    /// # Errors
    /// The first thing wrong with them.
    pub fn check(&self) -> Result<(), GeometryError> {
        let (degree, n) = (self.degree, self.control.len());
        if degree == 0 || degree > MAX_DEGREE {
            return Err(GeometryError::Degree { degree });
        }
        if n <= degree {
            return Err(GeometryError::Points { found: n, needed: degree + 1 });
        }
        if self.knots.len() != n + degree + 1 {
            return Err(GeometryError::KnotCount {
                found: self.knots.len(),
                needed: n + degree + 1,
            });
        }
        if self.weights.len() != n {
            return Err(GeometryError::WeightCount { found: self.weights.len(), needed: n });
        }
        check_points(self.control.iter().copied())?;
        check_points(self.knots.iter().map(|knot| [*knot, 0.0]))?;
        for (index, &value) in self.weights.iter().enumerate() {
            if !(value > 0.0 && value.is_finite()) {
                return Err(GeometryError::Weight { index, value });
            }
        }
        self.check_knots()
    }

    /// True if the control points on either side of an inner knot of full multiplicity are one.
    fn meets_at(&self, knot_idx: usize) -> bool {
        /// Points nearer than this part of the largest coordinate are one.
        const SAME: f64 = 1e-9;
        let Some(before) = knot_idx.checked_sub(1) else { return false };
        let size = self.control.iter().flatten().fold(0.0, |size: f64, x| size.max(x.abs()));
        let [a, b] = [self.control[before], self.control[knot_idx]];
        (a[0] - b[0]).abs().max((a[1] - b[1]).abs()) <= SAME * size
    }

    fn check_knots(&self) -> Result<(), GeometryError> {
        let (degree, n) = (self.degree, self.control.len());
        let wrong = |index: usize| Err(GeometryError::Knot { index, value: self.knots[index] });
        if let Some(i) = self.knots.windows(2).position(|pair| pair[1] < pair[0]) {
            return wrong(i + 1);
        }
        // The curve needs a stretch of the parameter, and hangs together only where no inner
        // knot stands more often than the degree, or once more where one point ends the curve before it
        // and begins the curve after it: Bézier pieces, one after the other.
        if self.knots[degree] == self.knots[n] {
            return wrong(n);
        }
        let (first, last) = (self.knots[degree], self.knots[n]);
        let breaks = |i: &usize| {
            let knot = self.knots[*i];
            let is_full = first < knot && knot < last && knot == self.knots[i + degree];
            is_full && !(knot < self.knots[i + degree + 1] && self.meets_at(*i))
        };
        match (0..n).find(breaks) {
            Some(i) => wrong(i + degree),
            None => Ok(()),
        }
    }
}
