//! The next step size: predictive control after Gustafsson (HW2 §IV.8, step size selection; code of
//! `RADAU5`).
//!
//! ```text
//! h_new = fac h (1/err)^{1/(s+1)}                                            classical
//! h_new = fac h (1/err)^{1/(s+1)} (h/h_old) (err_old/err)^{1/(s+1)}          predictive
//! fac   = 0.9 (2 k_max + 1)/(2 k_max + k)                                    k Newton iterations
//! ```
//!
//! The smaller of the two is taken after an accepted step.

use crate::checkpoint::{Loader, Saver};
use crate::error::SolveError;
use crate::estimate::Filter;

/// Safety factor.
const SAFETY: f64 = 0.9;
/// Largest growth and strongest cut of one step.
const MAX_GROWTH: f64 = 8.0;
const MAX_CUT: f64 = 0.2;
/// Cut after a rejected first step, whose size was a guess.
const FIRST_CUT: f64 = 0.1;
/// Contraction of Newton's iteration that the step size aims at, where the error test would allow
/// more.
///
/// With `θ ∝ h` a step takes `1/ln(1/θ)` iterations per digit, so `h ln(1/θ)` is largest at
/// `θ = 1/e`; Jacobian and factors, once per step, make somewhat larger steps better (compare
/// Gustafsson and Söderlind, SIAM J. Sci. Comput. 18 (1997) 23–40).
pub(crate) const RATE_WANTED: f64 = 0.2;
/// A growth within this range is not worth a new factorisation.
const KEEP: std::ops::RangeInclusive<f64> = 1.0..=1.2;
/// Steps stay this far below a size at which Newton's iteration failed,
const BELOW_FAILED: f64 = 0.8;
/// which is forgotten at this rate.
const FORGET_FAILED: f64 = 1.05;
/// Smaller errors of an accepted step are not trusted to predict the next.
const MIN_REMEMBERED_ERROR: f64 = 1e-2;

/// State of the controller between two steps.
#[derive(Clone, Debug)]
pub(crate) struct Controller {
    exponent: f64,
    max_iterations: usize,
    accepted: Option<Accepted>,
    is_retry: bool,
    /// The last error belongs to another order.
    is_new_order: bool,
    /// The size at which Newton's iteration failed, growing as it is forgotten.
    failed: Option<f64>,
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
        Self {
            exponent,
            max_iterations,
            accepted: None,
            is_retry: false,
            is_new_order: false,
            failed: None,
        }
    }

    pub(crate) fn save(&self, saver: &mut Saver) {
        saver.option(self.accepted.map(|accepted| accepted.h));
        saver.option(self.accepted.map(|accepted| accepted.error));
        saver.flag(self.is_retry);
        saver.flag(self.is_new_order);
        saver.option(self.failed);
    }

    /// All but the order, which follows from the stepper's.
    pub(crate) fn load(&mut self, loader: &mut Loader<'_>) -> Result<(), SolveError> {
        let (h, error) = (loader.option()?, loader.option()?);
        self.accepted = h.zip(error).map(|(h, error)| Accepted { h, error });
        self.is_retry = loader.flag()?;
        self.is_new_order = loader.flag()?;
        self.failed = loader.option()?;
        Ok(())
    }

    pub(crate) fn set_exponent(&mut self, stages: usize, max_iterations: usize) {
        self.exponent = 1.0 / (stages as f64 + 1.0);
        self.max_iterations = max_iterations;
    }

    /// Continues with another number of stages.
    pub(crate) fn set_order(&mut self, stages: usize, max_iterations: usize) {
        self.set_exponent(stages, max_iterations);
        // Errors of another order predict nothing.
        self.is_new_order = true;
    }

    /// The filter of the error estimate of the step to come.
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
        rate: Option<f64>,
        may_keep: bool,
    ) -> f64 {
        let mut factor = self.classical(error, iterations);
        if let (Some(last), false) = (self.accepted, self.is_new_order) {
            let predicted =
                SAFETY * (h / last.h).abs() * (last.error / (error * error)).powf(self.exponent);
            factor = factor.min(predicted.clamp(MAX_CUT, MAX_GROWTH));
        }
        if let Some(failed) = self.failed {
            let limit = BELOW_FAILED * (failed / h).abs();
            factor = factor.min(limit.max(1.0));
            self.failed = (limit < MAX_GROWTH).then_some(failed * FORGET_FAILED);
        }
        if let Some(rate) = rate {
            factor = factor.min((RATE_WANTED / rate).max(MAX_CUT));
        }
        if self.is_retry {
            factor = factor.min(1.0);
        }
        self.accepted = Some(Accepted { h, error: error.max(MIN_REMEMBERED_ERROR) });
        self.is_retry = false;
        self.is_new_order = false;
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
        self.failed = Some(h);
        h * shrink
    }

    fn classical(&self, error: f64, iterations: usize) -> f64 {
        let limit = 2.0 * self.max_iterations as f64;
        let fac = SAFETY * ((limit + 1.0) / (limit + iterations as f64)).min(1.0);
        // An estimate of zero is rounding, not perfection.
        (fac * error.max(1e-10).powf(-self.exponent)).clamp(MAX_CUT, MAX_GROWTH)
    }
}
