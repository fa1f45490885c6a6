//! The next step size: PI control (HNW1 §IV.2 of volume II, Gustafsson 1991).
//!
//! ```text
//! h_new = 0.9 h err^{−α} err_old^{β},  α = 1/p − 0.2 β
//! ```
//!
//! `p` is the order of the error estimate plus one, 8.

use crate::noise::Noise;

/// Weight of the last error, as a part of the exponent of this one. `DOP853` has zero; measured on the pendulum
/// at 1e-4 to 1e-10, 0.07 at the exponent 1/8 leaves 0 to 3 rejected steps of 50 to 250, where zero leaves 9
/// to 25, and a third of a digit more for the same work. Beyond 0.1 the exponents nearly cancel and the step
/// grows only far below the tolerance.
const MEMORY: f64 = 0.56;
/// 1/p.
const EXPONENT: f64 = 1.0 / 8.0;
const BETA: f64 = MEMORY * EXPONENT;
const ALPHA: f64 = EXPONENT - 0.2 * BETA;
const SAFETY: f64 = 0.9;
/// Largest growth and strongest cut of one step.
const MAX_GROWTH: f64 = 6.0;
const MAX_CUT: f64 = 1.0 / 3.0;
/// Smaller errors are not trusted to predict the next.
const MIN_REMEMBERED_ERROR: f64 = 1e-4;

/// An error that falls with a lower power of the step size than this, from one attempt to the next, is
/// noise: that of smooth equations falls with the eighth.
const OF_NOISE: f64 = 3.0;

/// State of the controller between two steps.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct PiController {
    last_error: f64,
    /// Part in the size of the next step, known before the error of the next one is.
    memory: f64,
    /// The step is tried again.
    pub(super) is_retry: bool,
    /// Size and error of the attempt that was just rejected.
    pub(super) rejected: Option<(f64, f64)>,
    pub(super) noise: Noise,
}

impl PiController {
    /// Before the first step.
    pub(super) fn new() -> Self {
        let mut controller = Self {
            last_error: 1.0,
            memory: 1.0,
            is_retry: false,
            rejected: None,
            noise: Noise::default(),
        };
        controller.remember(MIN_REMEMBERED_ERROR);
        controller
    }

    /// The error of the last accepted step, as it is remembered.
    pub(super) fn last_error(&self) -> f64 {
        self.last_error
    }

    /// Remembers the error of an accepted step.
    pub(super) fn remember(&mut self, error: f64) {
        self.last_error = error.max(MIN_REMEMBERED_ERROR);
        self.memory = self.last_error.powf(BETA);
    }

    /// Compares an attempt with the larger one before it, if that was rejected: the power of the size by which the
    /// error has fallen.
    pub(super) fn compare(&mut self, h: f64, error: f64) -> Option<f64> {
        let (larger, before) = self.rejected.take()?;
        let power = (before / error).ln() / (larger / h).ln();
        if power < OF_NOISE && error > 0.0 {
            self.noise.count(error);
        }
        Some(power)
    }

    /// The size of the step after an accepted one of size `h`.
    pub(super) fn after_accept(&mut self, h: f64, error: f64) -> f64 {
        let proposed = SAFETY * error.max(1e-12).powf(-ALPHA) * self.memory;
        let factor = proposed.clamp(MAX_CUT, if self.is_retry { 1.0 } else { MAX_GROWTH });
        self.remember(error);
        self.is_retry = false;
        h * factor
    }

    /// The size to retry with after the error test failed; an error without value cuts most.
    pub(super) fn after_reject(&mut self, h: f64, error: f64) -> f64 {
        self.rejected = error.is_finite().then_some((h, error));
        self.is_retry = true;
        let factor = SAFETY * error.powf(-ALPHA);
        h * if factor.is_finite() { factor.clamp(MAX_CUT, SAFETY) } else { MAX_CUT }
    }

    pub(super) fn after_failure(&mut self) {
        self.rejected = None;
        self.is_retry = true;
    }
}
