//! Choice among 3, 5 and 7 stages for the next step: the least predicted work per unit of time.
//!
//! ```text
//! h u′(τ) = Σ_k p_k P_k(2τ − 1)                      Legendre coefficients of the last step
//! err_s   = (2/γ_s) ‖p_s‖                            the embedded formula on a term of degree s
//! ‖p_k‖ ≈ C ρ^k,  ρ ∝ h                              smooth solutions
//! err_{s±2} = err_s ρ^{±2} γ_s/γ_{s±2}
//! h_s = h err_s^{−1/(s+1)},  h_s ≤ h θ_ref/θ         error test, Newton's iteration
//! work per unit of time ∝ s/h_s
//! ```
//!
//! `2/γ_s`: the embedded formula adds `h y′(t0)/γ` (see `tableau`) and is exact below degree `s`;
//! at the Radau nodes `P_s = P_{s−1}`, at the start they have opposite signs. Cost grows like `s`:
//! one residual per stage, and solves of `1 + 4 (s − 1)/2` real ones.
//!
//! `RADAU` (Hairer and Wanner, *Stiff differential equations solved by Radau methods*, J. Comput.
//! Appl. Math. 111 (1999) 93–111) raises the order when Newton's iteration contracts faster than
//! 0.002 for ten steps. That waits until the steps are far too small for the solution's
//! smoothness; here the contraction only bounds the step.

use crate::checkpoint::{Loader, Saver};
use crate::controller::RATE_WANTED;
use crate::error::SolveError;
use crate::settings::Stages;

/// Accepted steps between two changes of order.
const MIN_STEPS: usize = 3;
/// A change must promise this much less work.
const WORTHWHILE: f64 = 1.15;
/// Largest growth of the step with a change.
const MAX_GROWTH: f64 = 4.0;

/// Smoothness of the solution, as one accepted step shows it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Smoothness {
    pub(crate) h: f64,
    /// Error estimate in units of the tolerance.
    pub(crate) error: f64,
    /// Norms of the Legendre coefficients of degree `s − 2` and `s − 1` in the same units.
    pub(crate) tail: [f64; 2],
    /// Contraction of Newton's iteration, if it took two.
    pub(crate) rate: Option<f64>,
}

/// State of the choice between two steps.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(crate) struct OrderChoice {
    /// Smoothed `ρ/|h|`; zero before the first step.
    pub(crate) decay: f64,
    /// Accepted steps since the last change.
    pub(crate) steps: usize,
}

/// The real eigenvalues `γ` of 3, 5 and 7 stages.
pub(crate) type Gammas = [f64; 3];

const ORDERS: [Stages; 3] = [Stages::Three, Stages::Five, Stages::Seven];

/// Position among [`ORDERS`].
fn position(stages: Stages) -> usize {
    let k = ORDERS.iter().position(|&s| s == stages);
    k.expect("variable order uses three, five or seven stages")
}

/// The next lower number of stages that [`crate::Order::Auto`] uses.
pub(crate) fn lower(stages: Stages) -> Option<Stages> {
    position(stages).checked_sub(1).map(|k| ORDERS[k])
}

impl OrderChoice {
    pub(crate) fn save(&self, saver: &mut Saver) {
        saver.real(self.decay);
        saver.count(self.steps);
    }

    pub(crate) fn load(&mut self, loader: &mut Loader<'_>) -> Result<(), SolveError> {
        *self = Self { decay: loader.real()?, steps: loader.count()? };
        Ok(())
    }

    /// Takes note of how fast the coefficients of an accepted step decay.
    pub(crate) fn observe(&mut self, gamma: f64, smoothness: Smoothness) {
        // Two ratios of three successive coefficients, then smoothed over the steps.
        let last = smoothness.error * gamma / 2.0;
        let ratio = (last / smoothness.tail[0]).sqrt();
        if ratio.is_finite() && ratio > 0.0 {
            let decay = ratio / smoothness.h.abs();
            self.decay = if self.decay > 0.0 { (self.decay * decay).sqrt() } else { decay };
        }
        self.steps += 1;
    }

    /// After an accepted step with `stages`, returns a better number of stages and the size
    /// of the next step with it.
    pub(crate) fn after_accept(
        &mut self,
        stages: Stages,
        gammas: &Gammas,
        smoothness: Smoothness,
    ) -> Option<(Stages, f64)> {
        if self.steps < MIN_STEPS || self.decay == 0.0 {
            return None;
        }
        let k = position(stages);
        let h = smoothness.h.abs();

        // Step sizes of the neighbours, and their gain.
        let rho = (self.decay * h).min(0.9);
        let newton = h * RATE_WANTED / smoothness.rate.unwrap_or(0.0).max(0.01);
        let size = |j: usize| {
            let degrees = 2.0 * (j as f64 - k as f64);
            let error = smoothness.error.max(1e-10) * rho.powf(degrees) * gammas[k] / gammas[j];
            let exponent = -1.0 / (ORDERS[j].count() as f64 + 1.0);
            (h * error.powf(exponent)).min(newton)
        };
        let speed = |j: usize| size(j) / ORDERS[j].count() as f64;
        let neighbours = [k.checked_sub(1), (k + 1 < ORDERS.len()).then_some(k + 1)];
        let best = neighbours
            .into_iter()
            .flatten()
            .max_by(|&a, &b| speed(a).total_cmp(&speed(b)))
            .filter(|&j| speed(j) > WORTHWHILE * speed(k))?;
        self.steps = 0;
        let next = (0.9 * size(best)).clamp(0.2 * h, MAX_GROWTH * h);
        Some((ORDERS[best], next.copysign(smoothness.h)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// γ of 3, 5 and 7 stages, roughly.
    const GAMMAS: Gammas = [3.64, 6.29, 8.94];

    /// The choice after ten steps whose coefficients decay by `rho` from one to the next.
    fn choice(stages: Stages, error: f64, rho: f64, rate: f64) -> Option<Stages> {
        let gamma = GAMMAS[stages.count() / 2 - 1];
        let last = error * gamma / 2.0;
        let smoothness =
            Smoothness { h: 0.1, error, tail: [last / (rho * rho), last / rho], rate: Some(rate) };
        let mut choice = OrderChoice::default();
        for _ in 0..10 {
            choice.observe(gamma, smoothness);
        }
        choice.after_accept(stages, &GAMMAS, smoothness).map(|(stages, _)| stages)
    }

    #[test]
    fn smooth_solutions_raise_the_order_and_rough_ones_lower_it() {
        assert_eq!(choice(Stages::Three, 0.5, 0.01, 0.01), Some(Stages::Five));
        assert_eq!(choice(Stages::Five, 0.5, 0.01, 0.01), Some(Stages::Seven));
        assert_eq!(choice(Stages::Three, 0.5, 0.8, 0.01), None);
        assert_eq!(choice(Stages::Seven, 0.5, 0.8, 0.01), Some(Stages::Five));
        assert_eq!(choice(Stages::Five, 0.5, 0.8, 0.01), Some(Stages::Three));
    }

    #[test]
    fn steps_bounded_by_newtons_iteration_lower_the_order() {
        assert_eq!(choice(Stages::Three, 0.5, 0.01, 0.3), None);
        assert_eq!(choice(Stages::Seven, 1e-6, 0.1, 0.3), Some(Stages::Five));
    }

    #[test]
    fn a_change_is_not_followed_by_another_at_once() {
        let mut choice = OrderChoice::default();
        let smoothness = Smoothness { h: 0.1, error: 0.5, tail: [1e4, 1e2], rate: None };
        choice.observe(GAMMAS[0], smoothness);
        assert_eq!(choice.after_accept(Stages::Three, &GAMMAS, smoothness), None);
    }
}
