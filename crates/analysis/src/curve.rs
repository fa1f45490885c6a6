//! [`Curve`]: positions along one free motion, followed by predictor and corrector with arc length.
//!
//! ```text
//! z = (x, s)    coordinates in units of the mechanism, and the parameter of what is prescribed, if any
//! Φ(z) = 0      one row less than unknowns
//! [ ∂Φ/∂z ]       [ 0 ]
//! [  τ̄ᵀ   ] τ  =  [ 1 ]    the tangent τ, then of length one; τ̄ the one before
//! [ ∂Φ/∂z ]        [ −Φ            ]
//! [  bᵀ   ] δz  =  [ b · (z̄ − z)   ]    the corrector; b = τ̄ keeps the arc length, b = e_s the parameter
//! ```
//!
//! Source: E. L. Allgower and K. Georg, *Introduction to Numerical Continuation Methods* (2003), chapters
//! 2, 4 and 6; H. B. Keller, *Numerical solution of bifurcation and nonlinear eigenvalue problems* (1977).

use bksim_sim::Svd;
use nalgebra::{DMatrix, DVector};

/// Equations with one row less than unknowns.
pub(crate) trait Equations {
    /// Their values, and their slopes by the unknowns.
    fn at(&mut self, z: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>);

    /// Largest residual, where they were last asked for, of rows that follow from these as long as they hold.
    fn left_out(&self) -> f64 {
        0.0
    }

    /// The direction of the first point, where the slopes alone do not show it.
    fn first_direction(&self) -> Option<DVector<f64>> {
        None
    }
}

/// Solutions of equations along the one direction that they leave free.
pub(crate) struct Curve<E> {
    pub(crate) equations: E,
}

/// A position of a curve with its direction there.
#[derive(Clone, Debug)]
pub(crate) struct Point {
    /// Coordinates in units of the mechanism, then the parameter, if there is one.
    pub(crate) z: DVector<f64>,
    /// Of length one.
    pub(crate) tangent: DVector<f64>,
}

/// Longest step, in radians and lengths of the longest link.
const LONGEST_STEP: f64 = 0.1;
/// Shortest step.
const SHORTEST_STEP: f64 = 1e-9;
/// Cosine of the angle between the directions at both ends of a step.
const STRAIGHT: f64 = 0.98;
/// Part of a step that its correction may be.
const NEAR_CURVE: f64 = 0.1;
/// Corrections below this are rounding.
const CONVERGED: f64 = 1e-11;
/// Residual of rows that follow from others up to which they do.
const FOLLOWS: f64 = 1e-8;

impl<E: Equations> Curve<E> {
    fn at(&mut self, z: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        self.equations.at(z)
    }

    /// The point at `z`, its direction nearest to `previous`; `None` where the direction is not unique.
    pub(crate) fn point(&mut self, z: DVector<f64>, previous: &DVector<f64>) -> Option<Point> {
        let (_, jacobian) = self.at(&z);
        let mut right = DVector::zeros(z.len());
        right[z.len() - 1] = 1.0;
        let tangent = bordered(&jacobian, previous).lu().solve(&right)?;
        let length = tangent.norm();
        if !(length.is_finite() && length > 0.0) {
            return None;
        }
        let tangent = tangent / length;
        Some(Point { z, tangent })
    }

    /// The first point, its direction that in which the last unknown grows.
    pub(crate) fn first_point(&mut self, z: DVector<f64>) -> Option<Point> {
        let n = z.len();
        if let Some(own) = self.equations.first_direction() {
            let tangent = if own[n - 1] < 0.0 { -own } else { own };
            return Some(Point { z, tangent });
        }
        let (_, jacobian) = self.at(&z);
        // The direction that the rows leave free.
        let mut square = DMatrix::zeros(n, n);
        square.rows_mut(0, jacobian.nrows()).copy_from(&jacobian);
        let mut free = Svd::new(&square)?.v_t.row(n - 1).transpose();
        if free[n - 1] < 0.0 {
            free.neg_mut();
        }
        self.point(z, &free)
    }

    /// Corrects `z` along all directions but those in which b · z keeps its value; gives the size of the
    /// first correction.
    pub(crate) fn correct(&mut self, z: &mut DVector<f64>, b: &DVector<f64>) -> Option<f64> {
        const MOST: usize = 12;
        let kept = b.dot(z);
        let mut first = 0.0;
        let mut last = f64::INFINITY;
        for iteration in 0..MOST {
            let (value, jacobian) = self.at(z);
            let n = z.len();
            let mut right = DVector::zeros(n);
            right.rows_mut(0, value.len()).copy_from(&(-value));
            right[n - 1] = kept - b.dot(z);
            let step = bordered(&jacobian, b).lu().solve(&right)?;
            let size = step.norm();
            if !size.is_finite() || (iteration > 1 && size > 0.5 * last && size > CONVERGED) {
                return None;
            }
            *z += step;
            if iteration == 0 {
                first = size;
            }
            if size <= CONVERGED {
                // What would tear the other rows is no pose.
                return (self.equations.left_out() <= FOLLOWS).then_some(first);
            }
            last = size;
        }
        None
    }

    /// The point at the arc length `ds` from `from`, if a step of that length keeps to the curve.
    pub(crate) fn along(&mut self, from: &Point, ds: f64) -> Option<Point> {
        let mut z = &from.z + &from.tangent * ds;
        let correction = self.correct(&mut z, &from.tangent)?;
        if correction > NEAR_CURVE * ds.abs() + 10.0 * CONVERGED {
            return None;
        }
        let to = self.point(z, &from.tangent)?;
        (to.tangent.dot(&from.tangent) > STRAIGHT).then_some(to)
    }

    /// A step from `from`, as long as keeps to the curve and at most `ds`, which becomes the proposal for
    /// the next one; `None` where no step succeeds.
    pub(crate) fn step(&mut self, from: &Point, ds: &mut f64) -> Option<(Point, f64)> {
        *ds = ds.min(LONGEST_STEP);
        while *ds > SHORTEST_STEP {
            let length = *ds;
            if let Some(to) = self.along(from, length) {
                // A curve that another one crosses goes straight on there; a jump does not.
                let turned = to.tangent.dot(&from.tangent);
                if turned > 1.0 - 0.25 * (1.0 - STRAIGHT) {
                    *ds *= 1.5;
                }
                return Some((to, length));
            }
            *ds *= 0.5;
        }
        None
    }

    /// The place within a step of length `ds` at which `f` changes its sign, as a point; the values of `f` at
    /// both ends have different signs.
    pub(crate) fn root(
        &mut self,
        from: &Point,
        ds: f64,
        (at_from, at_to): (f64, f64),
        f: &mut dyn FnMut(&mut Self, &Point) -> f64,
    ) -> Option<Point> {
        let (mut a, mut fa, mut b, mut fb) = (0.0, at_from, ds, at_to);
        let mut best = from.clone();
        let mut last_side = 0;
        // Regula falsi, Illinois; bisection where that stalls.
        for iteration in 0..100 {
            let secant = (a * fb - b * fa) / (fb - fa);
            let is_inside = secant > a.min(b) && secant < a.max(b);
            let c = if is_inside && iteration % 4 != 3 { secant } else { 0.5 * (a + b) };
            let mut z = &from.z + &from.tangent * c;
            self.correct(&mut z, &from.tangent)?;
            best = self.point(z, &from.tangent)?;
            let fc = f(self, &best);
            if fc == 0.0 || (b - a).abs() <= 4.0 * f64::EPSILON * (1.0 + ds.abs()) {
                break;
            }
            if (fc > 0.0) == (fa > 0.0) {
                (a, fa) = (c, fc);
                if last_side == 1 {
                    fb *= 0.5;
                }
                last_side = 1;
            } else {
                (b, fb) = (c, fc);
                if last_side == 2 {
                    fa *= 0.5;
                }
                last_side = 2;
            }
        }
        Some(best)
    }
}

/// The matrix with one more row.
fn bordered(jacobian: &DMatrix<f64>, row: &DVector<f64>) -> DMatrix<f64> {
    let (m, n) = jacobian.shape();
    let mut square = DMatrix::zeros(m + 1, n);
    square.rows_mut(0, m).copy_from(jacobian);
    square.row_mut(m).copy_from(&row.transpose());
    square
}

/// Rows that span all others, found by taking the longest remainder again and again.
pub(crate) fn independent_rows(matrix: &DMatrix<f64>) -> Vec<usize> {
    let mut rest: Vec<DVector<f64>> = matrix.row_iter().map(|row| row.transpose()).collect();
    let size: Vec<f64> = rest.iter().map(DVector::norm).collect();
    let mut chosen = Vec::new();
    while chosen.len() < matrix.ncols() {
        let share = |row: usize| if size[row] > 0.0 { rest[row].norm() / size[row] } else { 0.0 };
        let free = (0..rest.len()).filter(|row| !chosen.contains(row));
        let Some(next) = free.max_by(|&a, &b| share(a).total_cmp(&share(b))) else { break };
        if share(next) < 1e-7 {
            break;
        }
        let direction = rest[next].normalize();
        for row in &mut rest {
            let along = direction.dot(row);
            *row -= &direction * along;
        }
        chosen.push(next);
    }
    chosen.sort_unstable();
    chosen
}
