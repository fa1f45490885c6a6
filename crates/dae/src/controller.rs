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
//!
//! Near the end of the digits that numbers have, an error does not fall with the size of the step: it is rounding. No step
//! is small enough then, and the errors that follow are measured by what was found.

use crate::checkpoint::{Loader, Saver};
use crate::error::SolveError;
use crate::estimate::Filter;
use crate::noise::Noise;

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

/// Rejected attempts at a step by which it is known whether their error falls with its size,
const ENOUGH_REJECTED: usize = 4;
/// by this power of it at least: after a kink it falls with the first, that of smooth equations with the fourth or a higher
/// one.
const OF_NOISE: f64 = 0.5;
/// A larger error, in tolerances, is not rounding.
const MOST_NOISE: f64 = 30.0;
/// An error counts as one where it is so many times the largest of these,
const ABOVE_NOISE: f64 = 2.0;
/// which is forgotten at this rate.
const FORGET_NOISE: f64 = 0.97;

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
    /// The last attempts that were rejected since the last step.
    rejected: Rejected,
    /// The error, in tolerances, up to which steps are accepted: one, or more where rounding is more.
    unit: f64,
    pub(crate) noise: Noise,
}

/// The last accepted step.
#[derive(Clone, Copy, Debug)]
struct Accepted {
    h: f64,
    error: f64,
}

/// The last attempts at a step that were rejected.
#[derive(Clone, Copy, Debug, Default)]
struct Rejected {
    count: usize,
    /// Sizes, with errors in tolerances.
    attempts: [(f64, f64); ENOUGH_REJECTED],
}

impl Rejected {
    fn push(&mut self, h: f64, error: f64) {
        self.count += 1;
        self.attempts.rotate_left(1);
        self.attempts[ENOUGH_REJECTED - 1] = (h, error);
    }

    /// The size of the first of them and the largest error, where that is rounding.
    fn noise(&self) -> Option<(f64, f64)> {
        let [first, .., last] = self.attempts;
        let largest =
            self.attempts.iter().fold(0.0, |largest: f64, (_, error)| largest.max(*error));
        let fall = (first.1 / last.1).ln() / (first.0 / last.0).ln();
        let is_noise = self.count >= ENOUGH_REJECTED && largest < MOST_NOISE && fall < OF_NOISE;
        is_noise.then_some((first.0, largest))
    }
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
            rejected: Rejected::default(),
            unit: 1.0,
            noise: Noise::default(),
        }
    }

    /// An error, in tolerances, as a part of what is accepted.
    pub(crate) fn part(&self, error: f64) -> f64 {
        error / self.unit
    }

    pub(crate) fn save(&self, saver: &mut Saver) {
        saver.option(self.accepted.map(|accepted| accepted.h));
        saver.option(self.accepted.map(|accepted| accepted.error));
        saver.flag(self.is_retry);
        saver.flag(self.is_new_order);
        saver.option(self.failed);
        saver.real(self.unit);
        self.noise.save(saver);
    }

    /// All but the order, which follows from the stepper's.
    pub(crate) fn load(&mut self, loader: &mut Loader<'_>) -> Result<(), SolveError> {
        let (h, error) = (loader.option()?, loader.option()?);
        self.accepted = h.zip(error).map(|(h, error)| Accepted { h, error });
        self.is_retry = loader.flag()?;
        self.is_new_order = loader.flag()?;
        self.failed = loader.option()?;
        self.unit = loader.real()?;
        self.noise = Noise::load(loader)?;
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
        self.rejected = Rejected::default();
        self.unit = (FORGET_NOISE * self.unit).max(1.0);
        if may_keep && KEEP.contains(&factor) { h } else { h * factor }
    }

    /// The size to retry with after the error test failed; where rounding has failed it, that of an earlier attempt.
    pub(crate) fn after_reject(&mut self, h: f64, error: f64, iterations: usize) -> f64 {
        self.rejected.push(h, error * self.unit);
        if let Some((h, noise)) = self.rejected.noise() {
            self.noise.count(noise);
            self.unit = ABOVE_NOISE * noise;
            self.rejected = Rejected::default();
            self.is_retry = true;
            return h;
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The sizes that are tried after an attempt at 1, whose errors are these functions of the size.
    fn sizes(error: impl Fn(f64) -> f64, n: usize) -> (Controller, Vec<f64>) {
        let mut controller = Controller::new(3, 10);
        controller.after_accept(1.0, 0.5, 3, None, false);
        let mut sizes = vec![1.0];
        for i in 0..n {
            let h = sizes[i];
            let part = controller.part(error(h));
            if part < 1.0 {
                break;
            }
            sizes.push(controller.after_reject(h, part, 3));
        }
        (controller, sizes)
    }

    #[test]
    fn steps_do_not_shrink_for_an_error_that_is_rounding() {
        let (controller, tried) = sizes(|_| 3.0, 100);
        assert_eq!(tried.len(), ENOUGH_REJECTED + 1, "{tried:?}");
        assert_eq!(tried[ENOUGH_REJECTED], 1.0);
        assert_eq!(controller.noise.count, 1);
        assert!((controller.noise.mean_error() - 3.0).abs() < 1e-12);
        // What was found is not forgotten with the next step, but some time after.
        let mut controller = controller;
        controller.after_accept(1.0, 0.5, 3, None, false);
        assert!(controller.part(3.0) < 1.0);
        (0..200).for_each(|_| _ = controller.after_accept(1.0, 0.5, 3, None, false));
        assert_eq!(controller.part(3.0), 3.0);
    }

    #[test]
    fn steps_shrink_for_errors_of_kinks_and_of_jumps() {
        for error in [|h: f64| 1e6 * h, |h: f64| 1e9 * h * h * h, |_: f64| 1e3] {
            let (controller, tried) = sizes(error, 20);
            assert!(tried.windows(2).all(|two| two[1] < two[0]), "{tried:?}");
            assert_eq!(controller.noise.count, 0);
        }
    }
}
