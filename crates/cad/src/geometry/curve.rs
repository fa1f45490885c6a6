//! Ends, points, lengths and other properties of every [`Curve`].

use super::bezier::Bezier;
use super::conic::Conic;
use super::error::TURN;
use super::quadrature::adaptive;
use super::vector::{between, distance, norm};
use super::{Bounds, Curve, Point};

/// A curve cut into what the algorithms know: lines, pieces of conics, Bézier pieces.
#[derive(Clone, PartialEq, Debug)]
pub(crate) enum Piece {
    Line([Point; 2]),
    Conic(Conic),
    Bezier(Bezier),
}

impl Curve {
    /// The first end.
    pub fn start_point(&self) -> Point {
        self.point(0.0)
    }

    /// The other end.
    pub fn end_point(&self) -> Point {
        self.point(1.0)
    }

    /// The point at `t`, from 0 at the first end to 1 at the other; equal steps are equal angles on
    /// arcs and ellipses, equal steps of the parameter on splines.
    pub fn point(&self, t: f64) -> Point {
        match self {
            Self::Segment { from, .. } if t == 0.0 => *from,
            Self::Segment { to, .. } if t == 1.0 => *to,
            Self::Segment { from, to } => between(*from, *to, t),
            Self::Spline(spline) => spline.point(t),
            _ => self.conic().map_or([f64::NAN; 2], |conic| conic.point(t)),
        }
    }

    /// Curve from its other end.
    #[must_use]
    pub fn reversed(&self) -> Self {
        match self.clone() {
            Self::Segment { from, to } => Self::Segment { from: to, to: from },
            Self::Arc { centre, radius, start, sweep } => {
                Self::Arc { centre, radius, start: start + sweep, sweep: -sweep }
            }
            Self::Ellipse { centre, major, minor, start, sweep } => {
                Self::Ellipse { centre, major, minor, start: start + sweep, sweep: -sweep }
            }
            Self::Spline(spline) => Self::Spline(spline.reversed()),
        }
    }

    /// The smallest box around the curve, to rounding.
    pub fn bounds(&self) -> Bounds {
        let boxes = self.pieces().into_iter().map(|piece| match piece {
            Piece::Line(ends) => Bounds::of(ends),
            Piece::Conic(conic) => conic.bounds(),
            Piece::Bezier(bezier) => bezier.bounds(),
        });
        boxes.fold(Bounds::EMPTY, Bounds::union)
    }

    /// Length: exact for lines and circular arcs, by quadrature to near rounding for the others.
    pub fn length(&self) -> f64 {
        if let Self::Arc { radius, sweep, .. } = self {
            return radius * sweep.abs();
        }
        let lengths = self.pieces().into_iter().map(|piece| match piece {
            Piece::Line([from, to]) => distance(from, to),
            Piece::Conic(conic) => {
                conic.quarters().map(|quarter| adaptive(|t| [norm(quarter.derivative(t))])[0]).sum()
            }
            Piece::Bezier(bezier) => adaptive(|t| [norm(bezier.at(t).1)])[0],
        });
        lengths.sum()
    }

    /// Arc of a circle or an ellipse, if the curve is one.
    pub(crate) fn conic(&self) -> Option<Conic> {
        // More than a turn is no arc, and would make any number of pieces.
        let turn = |sweep: f64| sweep.clamp(-TURN, TURN);
        match *self {
            Self::Arc { centre, radius, start, sweep } => {
                Some(Conic::arc(centre, radius, start, turn(sweep)))
            }
            Self::Ellipse { centre, major, minor, start, sweep } => {
                Some(Conic { centre, major, minor, start, sweep: turn(sweep) })
            }
            Self::Segment { .. } | Self::Spline(_) => None,
        }
    }

    /// The curve in order as lines, conics and Bézier pieces.
    pub(crate) fn pieces(&self) -> Vec<Piece> {
        match self {
            Self::Segment { from, to } => vec![Piece::Line([*from, *to])],
            Self::Spline(spline) => spline.pieces().into_iter().map(Piece::Bezier).collect(),
            _ => self.conic().map(Piece::Conic).into_iter().collect(),
        }
    }
}
