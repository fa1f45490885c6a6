//! Levenberg–Marquardt's method on the rows of a part: from any shape down to one where they hold,
//! or to where no small change makes them hold better.
//!
//! Source: K. Madsen, H. B. Nielsen, O. Tingleff, *Methods for Non-Linear Least Squares Problems*
//! (2004), §3.2, algorithm 3.16: damping follows the ratio of gained to promised decrease.

use nalgebra::{DMatrix, DVector};

use super::equations::Equations;
use super::parts::Part;

/// Sum of squares below which all rows hold, in units of the mechanism and radians.
const HOLDING: f64 = 1e-26;

/// Equations with the units of their rows and columns.
pub(super) struct Scaled<'a> {
    pub(super) equations: &'a Equations,
    /// 1 for an angle, 1 by the size of the mechanism for a length.
    pub(super) weight_of_row: &'a [f64],
    /// 1 rad, or the size of the mechanism.
    pub(super) unit_of_column: &'a [f64],
}

/// Walk of one part.
pub(super) struct Walk<'a> {
    pub(super) part: &'a Part,
    wish_weight: f64,
    /// Σ r².
    cost: f64,
    /// JᵀJ and Jᵀr.
    normal: DMatrix<f64>,
    slope: DVector<f64>,
    damping: f64,
    growth: f64,
    step: DVector<f64>,
    /// Steps in a row that gained next to nothing.
    n_idle: usize,
    is_over: bool,
}

impl<'a> Walk<'a> {
    pub(super) fn begin(
        part: &'a Part,
        place: &[usize],
        at: &Scaled<'_>,
        wish_weight: f64,
    ) -> Self {
        const FIRST_DAMPING: f64 = 1e-2;
        let n = part.columns.len();
        let mut walk = Self {
            part,
            wish_weight,
            cost: 0.0,
            normal: DMatrix::zeros(n, n),
            slope: DVector::zeros(n),
            damping: 0.0,
            growth: 2.0,
            step: DVector::zeros(n),
            n_idle: 0,
            is_over: false,
        };
        walk.take(place, at);
        walk.damping = FIRST_DAMPING * walk.normal.diagonal().max();
        walk.is_over = walk.cost <= HOLDING || walk.damping.is_nan() || walk.damping <= 0.0;
        walk
    }

    /// The step to be tried, in units of the columns, at most a radian or the size of the mechanism
    /// in each; `None` at the end of the walk.
    pub(super) fn next_step(&mut self) -> Option<&DVector<f64>> {
        const LARGEST_DAMPING: f64 = 1e12;
        const LONGEST: f64 = 1.0;
        while !self.is_over {
            let mut damped = self.normal.clone();
            for i in 0..damped.nrows() {
                damped[(i, i)] += self.damping;
            }
            if let Some(factors) = damped.cholesky() {
                self.step.copy_from(&self.slope);
                factors.solve_mut(&mut self.step);
                if self.step.amax() <= LONGEST {
                    return Some(&self.step);
                }
            }
            self.damping *= 4.0;
            self.is_over = self.damping.is_nan() || self.damping >= LARGEST_DAMPING;
        }
        None
    }

    /// Whether the step tried last is taken; `at` has the rows at its end.
    pub(super) fn judge(&mut self, place: &[usize], at: &Scaled<'_>) -> bool {
        const IDLE: f64 = 1e-3;
        const MAX_IDLE: usize = 4;
        const SMALLEST_STEP: f64 = 1e-14;
        if self.is_over {
            return false;
        }
        let reached = cost(self.part, at, self.wish_weight);
        let promised = self.step.dot(&self.slope) + self.damping * self.step.norm_squared();
        let gained = self.cost - reached;
        if gained.is_nan() || gained <= 0.0 {
            self.damping *= self.growth;
            self.growth *= 2.0;
            self.is_over = self.step.amax() < SMALLEST_STEP || !self.damping.is_finite();
            return false;
        }
        self.n_idle = if gained < IDLE * self.cost { self.n_idle + 1 } else { 0 };
        let ratio = 2.0 * gained / promised - 1.0;
        self.damping *= (1.0 - ratio.powi(3)).clamp(1.0 / 3.0, 2.0);
        self.growth = 2.0;
        self.take(place, at);
        self.is_over = self.cost <= HOLDING || self.n_idle >= MAX_IDLE;
        true
    }

    /// The normal equations at a point.
    fn take(&mut self, place: &[usize], at: &Scaled<'_>) {
        self.cost = cost(self.part, at, self.wish_weight);
        self.normal.fill(0.0);
        self.slope.fill(0.0);
        let mut add = |row: usize, weight: f64| {
            let weight = weight * at.weight_of_row[row];
            let value = weight * at.equations.values[row];
            let entries = at.equations.gradients.row(row);
            let entry = |&(column, g): &(usize, f64)| {
                let i = place[column];
                (i != usize::MAX).then(|| (i, weight * g * at.unit_of_column[column]))
            };
            for (i, a) in entries.iter().filter_map(entry) {
                self.slope[i] += a * value;
                for (j, b) in entries.iter().filter_map(entry) {
                    self.normal[(i, j)] += a * b;
                }
            }
        };
        self.part.rows.iter().for_each(|&row| add(row, 1.0));
        self.part.wishes.iter().for_each(|&row| add(row, self.wish_weight));
    }
}

/// Σ r² of a part.
fn cost(part: &Part, at: &Scaled<'_>, wish_weight: f64) -> f64 {
    let square = |&row: &usize| (at.weight_of_row[row] * at.equations.values[row]).powi(2);
    let held: f64 = part.rows.iter().map(square).sum();
    let wished: f64 = part.wishes.iter().map(square).sum();
    held + wish_weight * wish_weight * wished
}
