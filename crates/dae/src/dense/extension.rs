//! The continuous extension: dense output of order 7.
//!
//! ```text
//! θ = (t − t0)/h,  θ₁ = 1 − θ
//! u(θ) = y0 + θ (r_1 + θ₁ (r_2 + θ (r_3 + θ₁ (r_4 + θ (r_5 + θ₁ (r_6 + θ r_7))))))
//! r_1 = y1 − y0,  r_2 = h f0 − r_1,  r_3 = r_1 − h f1 − r_2,  r_{4+k} = h Σ_j d_kj k_j
//! ```
//!
//! HNW1 §II.6 (E. Hairer, S. P. Nørsett, G. Wanner, *Solving Ordinary Differential Equations I*);
//! the form of `DOP853`.

use super::sums_into;

/// Stages of the method of Dormand and Prince without those of its continuous extension.
pub(crate) const N_STAGES: usize = 12;

/// Terms of the continuous extension, the degree of its polynomial.
pub(crate) const N_TERMS: usize = 7;

/// The polynomial of the last accepted step; its buffers are allocated once.
#[derive(Clone, Debug)]
pub(crate) struct ContinuousExtension {
    pub(crate) t0: f64,
    pub(crate) h: f64,
    /// State at `t0`, length `n`.
    pub(crate) y0: Vec<f64>,
    /// `r_1 … r_7`, one after the other.
    pub(crate) terms: Vec<f64>,
}

impl ContinuousExtension {
    pub(crate) fn new(n: usize) -> Self {
        Self { t0: 0.0, h: 0.0, y0: vec![0.0; n], terms: vec![0.0; N_TERMS * n] }
    }

    /// The first three terms of unknown `i`, from its derivative at the start and both at the end.
    pub(crate) fn take_ends(&mut self, i: usize, (f0, y1, f1): (f64, f64, f64)) {
        let n = self.y0.len();
        let change = y1 - self.y0[i];
        let second = self.h * f0 - change;
        self.terms[i] = change;
        self.terms[n + i] = second;
        self.terms[2 * n + i] = change - self.h * f1 - second;
    }

    /// Writes `u(θ)`.
    pub(crate) fn value_into(&self, theta: f64, out: &mut [f64]) {
        // Even terms have the factor θ, odd ones the factor 1 − θ.
        let factors = [theta, 1.0 - theta];
        sums_into(&self.terms, N_TERMS, out, |k, inner| factors[k % 2] * inner);
        out.iter_mut().zip(&self.y0).for_each(|(value, y0)| *value += y0);
    }

    /// Writes `du/dt` at `θ`.
    pub(crate) fn derivative_into(&self, theta: f64, out: &mut [f64]) {
        let n = self.y0.len();
        for (i, out) in out.iter_mut().enumerate() {
            let (_, slope) = horner(theta, |k| self.terms[k * n + i]);
            *out = slope / self.h;
        }
    }
}

/// `u(θ) − y0` and its derivative by `θ`, from the inside out.
fn horner(theta: f64, term: impl Fn(usize) -> f64) -> (f64, f64) {
    (0..N_TERMS).rev().fold((0.0, 0.0), |(value, slope), k| {
        let inner = term(k) + value;
        // Even terms have the factor θ, odd ones the factor 1 − θ.
        if k % 2 == 0 {
            (theta * inner, inner + theta * slope)
        } else {
            ((1.0 - theta) * inner, (1.0 - theta) * slope - inner)
        }
    })
}
