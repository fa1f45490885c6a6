//! Dense output of a step by a Taylor series: the series itself, led to the end that the step was given.
//!
//! ```text
//! u(θ) = y0 + Σ c_k (θ h)^k + θ² (3 − 2 θ) δ        δ = y1 − y0 − Σ c_k h^k
//! ```

use super::sums_into;

/// The polynomial of the last accepted step; its buffers are allocated once.
#[derive(Clone, Debug)]
pub(crate) struct TaylorPolynomial {
    pub(crate) t0: f64,
    pub(crate) h: f64,
    /// State at `t0`, length `n`.
    pub(crate) y0: Vec<f64>,
    /// `c_1 … c_p`, one after the other, and what else came with them.
    pub(crate) coefficients: Vec<f64>,
    /// `δ`: by how much projection has moved the end.
    pub(crate) shift: Vec<f64>,
    /// `p`.
    pub(crate) order: usize,
}

impl TaylorPolynomial {
    pub(crate) fn new(n: usize, order: usize) -> Self {
        let (y0, shift) = (vec![0.0; n], vec![0.0; n]);
        Self { t0: 0.0, h: 0.0, y0, coefficients: vec![0.0; order * n], shift, order }
    }

    /// Writes `u(θ)`.
    pub(crate) fn value_into(&self, theta: f64, out: &mut [f64]) {
        let (time, blend) = (theta * self.h, theta * theta * (3.0 - 2.0 * theta));
        sums_into(&self.coefficients, self.order, out, |_, inner| inner * time);
        for (out, (y0, shift)) in out.iter_mut().zip(self.y0.iter().zip(&self.shift)) {
            *out = y0 + (*out + blend * shift);
        }
    }

    /// Writes `du/dt` at `θ`.
    pub(crate) fn derivative_into(&self, theta: f64, out: &mut [f64]) {
        let n = self.y0.len();
        let (time, blend) = (theta * self.h, 6.0 * theta * (1.0 - theta) / self.h);
        for (i, out) in out.iter_mut().enumerate() {
            let slope = (0..self.order)
                .rev()
                .fold(0.0, |sum, k| sum * time + (k + 1) as f64 * self.coefficients[k * n + i]);
            *out = slope + blend * self.shift[i];
        }
    }
}
