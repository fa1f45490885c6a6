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

/// Coefficients `r_1 … r_7`.
const N_TERMS: usize = 7;

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

    /// Writes `u(θ)`.
    pub(crate) fn value_into(&self, theta: f64, out: &mut [f64]) {
        let n = self.y0.len();
        for (i, out) in out.iter_mut().enumerate() {
            let (value, _) = horner(theta, |k| self.terms[k * n + i]);
            *out = self.y0[i] + value;
        }
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
