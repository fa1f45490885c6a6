//! Levenberg–Marquardt's method on the rows of a part: from any shape down to one where they hold,
//! or to where no small change makes them hold better.
//!
//! Source: K. Madsen, H. B. Nielsen, O. Tingleff, *Methods for Non-Linear Least Squares Problems*
//! (2004), §3.2, algorithm 3.16: damping follows the ratio of gained to promised decrease.

use super::equations::Numbers;
use super::normal::Normal;
use super::weighted::Weighted;

/// Sum of squares below which all rows hold, in units of the mechanism and radians.
const HOLDING: f64 = 1e-26;

/// Walk of one part.
pub(super) struct Walk {
    rows: Weighted,
    wish_weight: f64,
    normal: Normal,
    damping: f64,
    growth: f64,
    step: Vec<f64>,
    /// Decrease of Σ r² that the linear rows promise of the step.
    promised: f64,
    /// Steps in a row that gained next to nothing.
    n_idle: usize,
    is_over: bool,
}

impl Walk {
    /// Room for the walks of a part of `n` coordinates.
    pub(super) fn new(rows: Weighted, n: usize) -> Self {
        Self {
            wish_weight: 0.0,
            normal: Normal::new(n, &rows.unknowns()),
            rows,
            damping: 0.0,
            growth: 2.0,
            step: vec![0.0; n],
            promised: 0.0,
            n_idle: 0,
            is_over: true,
        }
    }

    /// Begins where the rows have these numbers.
    pub(super) fn begin(&mut self, at: &Numbers, wish_weight: f64) {
        const FIRST_DAMPING: f64 = 1e-2;
        self.wish_weight = wish_weight;
        self.take(at);
        self.damping = FIRST_DAMPING * self.normal.largest();
        self.growth = 2.0;
        self.n_idle = 0;
        let is_held = self.normal.cost() <= HOLDING;
        self.is_over = is_held || self.damping.is_nan() || self.damping <= 0.0;
    }

    /// The step to be tried, in units of the columns, at most a radian or the size of the mechanism
    /// in each; `None` at the end of the walk.
    pub(super) fn next_step(&mut self) -> Option<&[f64]> {
        const LARGEST_DAMPING: f64 = 1e12;
        const LONGEST: f64 = 1.0;
        // Part of the cost that its own rounding hides.
        const HIDDEN: f64 = 1e-13;
        while !self.is_over {
            if self.normal.solve_into(self.damping, &mut self.step)
                && largest(&self.step) <= LONGEST
            {
                let gain = |(s, slope): (&f64, &f64)| s * (slope + self.damping * s);
                self.promised = self.step.iter().zip(self.normal.slope()).map(gain).sum();
                if self.promised <= HIDDEN * self.normal.cost() {
                    break;
                }
                return Some(&self.step);
            }
            self.damping *= 4.0;
            self.is_over = self.damping.is_nan() || self.damping >= LARGEST_DAMPING;
        }
        self.is_over = true;
        None
    }

    /// Ends the walk where it is.
    pub(super) fn end(&mut self) {
        self.is_over = true;
    }

    /// True if the step tried last is taken; `at` has the rows at its end.
    pub(super) fn judge(&mut self, at: &Numbers) -> bool {
        const IDLE: f64 = 1e-3;
        const MAX_IDLE: usize = 4;
        const SMALLEST_STEP: f64 = 1e-14;
        if self.is_over {
            return false;
        }
        let reached = self.rows.cost(at, self.wish_weight);
        let gained = self.normal.cost() - reached;
        if gained.is_nan() || gained <= 0.0 {
            self.damping *= self.growth;
            self.growth *= 2.0;
            self.is_over = largest(&self.step) < SMALLEST_STEP || !self.damping.is_finite();
            return false;
        }
        self.n_idle = if gained < IDLE * self.normal.cost() { self.n_idle + 1 } else { 0 };
        let ratio = 2.0 * gained / self.promised - 1.0;
        self.damping *= (1.0 - ratio.powi(3)).clamp(1.0 / 3.0, 2.0);
        self.growth = 2.0;
        self.take(at);
        self.is_over = self.normal.cost() <= HOLDING || self.n_idle >= MAX_IDLE;
        true
    }

    /// The normal equations at a point.
    fn take(&mut self, at: &Numbers) {
        self.rows.write_to(&mut self.normal, at, self.wish_weight);
    }
}

fn largest(step: &[f64]) -> f64 {
    step.iter().fold(0.0, |largest, s| if s.is_nan() { *s } else { largest.max(s.abs()) })
}
