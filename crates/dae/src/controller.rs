//! The next step size: predictive control after Gustafsson (HW2 §IV.8, step size selection; code of `RADAU5`).
//!
//! ```text
//! h_new = fac h (1/err)^{1/(s+1)}                                            classical
//! h_new = fac h (1/err)^{1/(s+1)} (h/h_old) (err_old/err)^{1/(s+1)}          predictive
//! fac   = 0.9 (2 k_max + 1)/(2 k_max + k)                                    k Newton iterations
//! ```
//!
//! The smaller of the two is taken after an accepted step.

use crate::estimate::Filter;

/// Safety factor.
const SAFETY: f64 = 0.9;
/// Largest growth and strongest cut of one step.
const MAX_GROWTH: f64 = 8.0;
const MAX_CUT: f64 = 0.2;
/// Cut after a rejected first step, whose size was a guess.
const FIRST_CUT: f64 = 0.1;
/// A growth within this range is not worth a new factorisation.
const KEEP: std::ops::RangeInclusive<f64> = 1.0..=1.2;
/// Smaller errors of an accepted step are not trusted to predict the next.
const MIN_REMEMBERED_ERROR: f64 = 1e-2;

/// What the controller remembers from step to step.
#[derive(Clone, Debug)]
pub(crate) struct Controller {
    exponent: f64,
    max_iterations: usize,
    accepted: Option<Accepted>,
    is_retry: bool,
}

/// The last accepted step.
#[derive(Clone, Copy, Debug)]
struct Accepted {
    h: f64,
    error: f64,
}

impl Controller {
    pub(crate) fn new(stages: usize, max_iterations: usize) -> Self {
        let exponent = 1.0 / (stages as f64 + 1.0);
        Self { exponent, max_iterations, accepted: None, is_retry: false }
    }

    /// How the error estimate of the step to come is to be filtered.
    pub(crate) fn filter(&self) -> Filter {
        if self.accepted.is_none() || self.is_retry { Filter::Twice } else { Filter::Once }
    }

    /// The size of the step after an accepted one of size `h`.
    ///
    /// `may_keep` says that Jacobian and factors are still good for the same `h`.
    pub(crate) fn after_accept(
        &mut self,
        h: f64,
        error: f64,
        iterations: usize,
        may_keep: bool,
    ) -> f64 {
        let mut factor = self.classical(error, iterations);
        if let Some(last) = self.accepted {
            let predicted =
                SAFETY * (h / last.h).abs() * (last.error / (error * error)).powf(self.exponent);
            factor = factor.min(predicted.clamp(MAX_CUT, MAX_GROWTH));
        }
        if self.is_retry {
            factor = factor.min(1.0);
        }
        self.accepted = Some(Accepted { h, error: error.max(MIN_REMEMBERED_ERROR) });
        self.is_retry = false;
        if may_keep && KEEP.contains(&factor) { h } else { h * factor }
    }

    /// The size to retry with after the error test failed.
    pub(crate) fn after_reject(&mut self, h: f64, error: f64, iterations: usize) -> f64 {
        let factor = match self.accepted {
            None => FIRST_CUT,
            Some(_) => self.classical(error, iterations).min(SAFETY),
        };
        self.is_retry = true;
        h * factor
    }

    /// The size to retry with after Newton's iteration failed; `shrink` comes from its rate.
    pub(crate) fn after_failure(&mut self, h: f64, shrink: f64) -> f64 {
        self.is_retry = true;
        h * shrink
    }

    fn classical(&self, error: f64, iterations: usize) -> f64 {
        let limit = 2.0 * self.max_iterations as f64;
        let fac = SAFETY * ((limit + 1.0) / (limit + iterations as f64)).min(1.0);
        // An estimate of zero is rounding, not perfection.
        (fac * error.max(1e-10).powf(-self.exponent)).clamp(MAX_CUT, MAX_GROWTH)
    }
}
