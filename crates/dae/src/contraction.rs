//! Convergence of Newton's iteration: its rate, the error left, and whether it will suffice.
//!
//! ```text
//! θ_k = ‖ΔW_k‖ / ‖ΔW_{k−1}‖,   error left ≈ θ/(1 − θ) ‖ΔW_k‖      HW2 §IV.8, stopping criterion
//! ```

/// Corrections allowed to decide by their size alone come after this many iterations.
const SETTLED_AFTER: usize = 3;

/// The rate of another step is not trusted to be better than this.
const MIN_INHERITED_ETA: f64 = 0.03;

/// Rates at or above this count as divergence.
const DIVERGING: f64 = 0.99;

/// Assessment of one iteration.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Progress {
    /// Another iteration is worth its cost.
    Continue,
    /// The error left is below the tolerance.
    Converged,
    /// The tolerance will not be reached; a step cut by this factor has a chance.
    Hopeless {
        /// Factor for the step size, below one.
        shrink: f64,
    },
}

/// Remedy of a step against slow convergence.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Retreat {
    /// A smaller step: give up as soon as the rate predicts failure.
    Shrink,
    /// No retreat, as the size is fixed: use up the iterations; rates are not monotone.
    None,
}

/// Monitors the corrections of one iteration; `η = θ/(1 − θ)` survives from step to step.
#[derive(Clone, Debug)]
pub(crate) struct Contraction {
    tolerance: f64,
    /// Tolerance where rounding keeps the corrections from shrinking further.
    lax_tolerance: f64,
    max_iterations: usize,
    retreat: Retreat,
    iterations: usize,
    last_norm: f64,
    last_ratio: f64,
    rate: Option<f64>,
    eta: f64,
}

impl Contraction {
    pub(crate) fn new(
        tolerance: f64,
        lax_tolerance: f64,
        max_iterations: usize,
        retreat: Retreat,
    ) -> Self {
        Self {
            tolerance,
            lax_tolerance,
            max_iterations,
            retreat,
            iterations: 0,
            last_norm: 0.0,
            last_ratio: 0.0,
            rate: None,
            eta: 1.0,
        }
    }

    /// `η`, which survives from step to step.
    pub(crate) fn eta(&self) -> f64 {
        self.eta
    }

    pub(crate) fn set_eta(&mut self, eta: f64) {
        self.eta = eta;
    }

    /// Prepares for a new iteration; with `is_same_matrix` the last `η` still holds for the first
    /// correction.
    ///
    /// HW2 §IV.8 takes `η^0.8` of it, which accepts large first corrections after a step that
    /// happened to converge at once; the error they leave in the constraints then fails every
    /// later error test. Hence the floor.
    pub(crate) fn start(&mut self, is_same_matrix: bool) {
        self.iterations = 0;
        self.rate = None;
        self.eta = if is_same_matrix { self.eta.powf(0.8).max(MIN_INHERITED_ETA) } else { 1.0 };
    }

    /// The rate observed, once there were two corrections.
    pub(crate) fn rate(&self) -> Option<f64> {
        self.rate
    }

    pub(crate) fn iterations(&self) -> usize {
        self.iterations
    }

    /// Takes the norm of a correction.
    pub(crate) fn observe(&mut self, norm: f64) -> Progress {
        self.iterations += 1;
        if !norm.is_finite() {
            return Progress::Hopeless { shrink: 0.5 };
        }
        if norm == 0.0 {
            return Progress::Converged;
        }

        // The rate is the geometric mean of the last two ratios.
        if self.iterations > 1 {
            let ratio = norm / self.last_norm;
            let rate = if self.iterations == 2 { ratio } else { (ratio * self.last_ratio).sqrt() };
            self.last_ratio = ratio;
            if rate >= DIVERGING {
                self.last_norm = norm;
                return self.give_up(norm, 0.5);
            }
            self.rate = Some(rate);
            self.eta = rate / (1.0 - rate);
        }
        self.last_norm = norm;

        if self.eta * norm <= self.tolerance {
            return Progress::Converged;
        }
        self.predict(norm)
    }

    /// Whether the rate promises convergence within the iterations left.
    fn predict(&self, norm: f64) -> Progress {
        let left = self.max_iterations.saturating_sub(self.iterations);
        let Some(rate) = self.rate else {
            return Progress::Continue;
        };
        let exponent = i32::try_from(left).unwrap_or(i32::MAX);
        let excess = self.eta * norm * rate.powi(exponent) / self.tolerance;
        if left > 0 && excess <= 1.0 {
            return Progress::Continue;
        }
        // Code of `RADAU5`: the cut that would have made the prediction end at the tolerance.
        let shrink = 0.8 * excess.clamp(1e-4, 20.0).powf(-1.0 / (4.0 + left as f64));
        self.give_up(self.eta * norm, shrink)
    }

    /// Corrections that stop shrinking when already small are rounding, and a smaller step would
    /// only raise it: of unknowns of index 3 it grows like `h⁻²`.
    fn give_up(&self, error: f64, shrink: f64) -> Progress {
        let is_rounding = self.iterations >= SETTLED_AFTER && error <= self.lax_tolerance;
        if is_rounding {
            Progress::Converged
        } else if self.retreat == Retreat::None && self.iterations < self.max_iterations {
            Progress::Continue
        } else {
            Progress::Hopeless { shrink }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(tolerance: f64, limit: usize, norms: &[f64]) -> Progress {
        let mut contraction = Contraction::new(tolerance, 10.0 * tolerance, limit, Retreat::Shrink);
        contraction.start(false);
        norms.iter().fold(Progress::Continue, |_, &norm| contraction.observe(norm))
    }

    #[test]
    fn a_geometric_series_converges_when_its_tail_is_below_the_tolerance() {
        assert_eq!(run(1e-3, 7, &[1.0, 1e-1]), Progress::Continue);
        assert_eq!(run(1e-3, 7, &[1.0, 1e-1, 1e-2]), Progress::Continue);
        assert_eq!(run(1.2e-3, 7, &[1.0, 1e-1, 1e-2]), Progress::Converged);
    }

    #[test]
    fn growth_and_nan_are_hopeless() {
        assert_eq!(run(1e-3, 7, &[1.0, 1.1]), Progress::Hopeless { shrink: 0.5 });
        assert_eq!(run(1e-3, 7, &[f64::NAN]), Progress::Hopeless { shrink: 0.5 });
    }

    #[test]
    fn a_rate_too_slow_for_the_iterations_left_is_hopeless_at_once() {
        assert!(matches!(run(1e-6, 7, &[1.0, 0.5]), Progress::Hopeless { shrink } if shrink < 0.8));
        assert_eq!(run(1e-6, 40, &[1.0, 0.5]), Progress::Continue);
    }

    #[test]
    fn a_fixed_step_uses_all_its_iterations() {
        let mut contraction = Contraction::new(1e-6, 1e-6, 4, Retreat::None);
        contraction.start(false);
        let progress = [1.0, 1.1, 1.0, 0.9].map(|norm| contraction.observe(norm));
        assert_eq!(progress[..3], [Progress::Continue; 3]);
        assert!(matches!(progress[3], Progress::Hopeless { .. }), "{progress:?}");
    }

    #[test]
    fn a_stall_at_rounding_is_convergence() {
        // The tests allow ten times the tolerance there.
        let stall = |size: f64| [2.5 * size, size, size, size];
        assert_eq!(run(1e-12, 40, &stall(8e-12)), Progress::Converged);
        assert_eq!(run(1e-12, 40, &stall(12e-12)), Progress::Hopeless { shrink: 0.5 });
    }
}
