//! The collocation polynomial: dense output, its derivative, and starting values of the next step.
//!
//! ```text
//! u(τ) = y0 + Σ_i z_i ℓ_i(τ),  τ = (t − t0)/h
//! ```
//!
//! with the Lagrange polynomials `ℓ_i` on the nodes `0, c_1, …, c_s` (HW2 §IV.8). It has
//! degree `s` and error `O(h^{s+1})` between the nodes.

use crate::checkpoint::{Loader, Saver};
use crate::error::SolveError;
use crate::newton::Point;

/// Stages of the largest method.
const MAX_STAGES: usize = 7;

/// The polynomial of the last accepted step; its buffers are allocated once.
#[derive(Clone, Debug)]
pub(crate) struct CollocationPolynomial {
    pub(crate) t0: f64,
    pub(crate) h: f64,
    /// State at `t0`, length `n`.
    pub(crate) y0: Vec<f64>,
    /// Stage increments `z_1 … z_s`, one after the other, length `s n`.
    pub(crate) z: Vec<f64>,
    c: Vec<f64>,
    /// 1 over the products of `c_i − c_m` over all other nodes.
    scales: [f64; MAX_STAGES],
}

impl CollocationPolynomial {
    /// With room for the nodes `c`, and thereby for any method with fewer.
    pub(crate) fn new(n: usize, c: &[f64]) -> Self {
        let (y0, z) = (vec![0.0; n], vec![0.0; n * c.len()]);
        Self { t0: 0.0, h: 0.0, y0, z, c: c.to_vec(), scales: scales(c) }
    }

    /// Takes the step from `at` with stage increments `z` at the nodes `c`.
    pub(crate) fn set(&mut self, at: Point<'_>, c: &[f64], z: &[f64]) {
        self.t0 = at.t;
        self.h = at.h;
        self.y0.copy_from_slice(at.y);
        self.take_nodes(c);
        self.z.clear();
        self.z.extend_from_slice(z);
    }

    fn take_nodes(&mut self, c: &[f64]) {
        if self.c != c {
            self.c.clear();
            self.c.extend_from_slice(c);
            self.scales = scales(c);
        }
    }

    pub(crate) fn save(&self, saver: &mut Saver) {
        saver.real(self.t0);
        saver.real(self.h);
        saver.slice(&self.y0);
        saver.slice(&self.c);
        saver.slice(&self.z);
    }

    pub(crate) fn load(&mut self, loader: &mut Loader<'_>) -> Result<(), SolveError> {
        self.t0 = loader.real()?;
        self.h = loader.real()?;
        loader.fill(&mut self.y0)?;
        let (c, z) = (loader.slice()?, loader.slice()?);
        if c.len() > MAX_STAGES || z.len() != c.len() * self.y0.len() {
            return Err(SolveError::Checkpoint { reason: "saved for a system of another size" });
        }
        self.take_nodes(c);
        self.z.clear();
        self.z.extend_from_slice(z);
        Ok(())
    }

    /// Number of stages of the method that took the step.
    pub(crate) fn n_stages(&self) -> usize {
        self.c.len()
    }

    /// Writes `u(τ)`.
    pub(crate) fn value_into(&self, tau: f64, out: &mut [f64]) {
        out.copy_from_slice(&self.y0);
        self.add_combination(&self.lagrange(tau), out);
    }

    /// Writes `u(τ) − y0 − z_s`, the change after the end of the step.
    pub(crate) fn change_after_end_into(&self, tau: f64, out: &mut [f64]) {
        let mut weights = self.lagrange(tau);
        weights[self.c.len() - 1] -= 1.0;
        out.fill(0.0);
        self.add_combination(&weights, out);
    }

    /// Writes `du/dt` at `τ`.
    pub(crate) fn derivative_into(&self, tau: f64, out: &mut [f64]) {
        out.fill(0.0);
        self.add_combination(&self.lagrange_derivative(tau).map(|x| x / self.h), out);
    }

    fn add_combination(&self, weights: &[f64; MAX_STAGES], out: &mut [f64]) {
        for (z, weight) in self.z.chunks_exact(out.len().max(1)).zip(weights) {
            for (value, z) in out.iter_mut().zip(z) {
                *value += weight * z;
            }
        }
    }

    /// Node `m` of `0, c_1, …, c_s`.
    fn node(&self, m: usize) -> f64 {
        if m == 0 { 0.0 } else { self.c[m - 1] }
    }

    /// `ℓ_1(τ) … ℓ_s(τ)`.
    fn lagrange(&self, tau: f64) -> [f64; MAX_STAGES] {
        let s = self.c.len();
        // The products of τ − c_m over the nodes before each one, then over those after it.
        let mut values = [0.0; MAX_STAGES];
        let mut product = tau;
        for (value, c) in values.iter_mut().zip(&self.c) {
            *value = product;
            product *= tau - c;
        }
        product = 1.0;
        for i in (0..s).rev() {
            values[i] *= product * self.scales[i];
            product *= tau - self.c[i];
        }
        values
    }

    /// `ℓ_1′(τ) … ℓ_s′(τ)`, by the product rule.
    fn lagrange_derivative(&self, tau: f64) -> [f64; MAX_STAGES] {
        let s = self.c.len();
        let mut values = [0.0; MAX_STAGES];
        for i in 1..=s {
            let factor = |m: usize| (tau - self.node(m)) / (self.node(i) - self.node(m));
            values[i - 1] = (0..=s)
                .filter(|&k| k != i)
                .map(|k| {
                    let others: f64 = (0..=s).filter(|&m| m != i && m != k).map(factor).product();
                    others / (self.node(i) - self.node(k))
                })
                .sum();
        }
        values
    }
}

/// 1 over the products of `c_i − c_m` over all other nodes, zero among them.
fn scales(c: &[f64]) -> [f64; MAX_STAGES] {
    let mut scales = [0.0; MAX_STAGES];
    for (i, scale) in scales.iter_mut().enumerate().take(c.len()) {
        let others = c.iter().enumerate().filter(|&(m, _)| m != i);
        *scale = 1.0 / (c[i] * others.map(|(_, other)| c[i] - other).product::<f64>());
    }
    scales
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_of_degree_three_is_reproduced() {
        let u = |t: f64| 2.0 - t + 3.0 * t * t - 0.5 * t * t * t;
        let du = |t: f64| -1.0 + 6.0 * t - 1.5 * t * t;
        let c = [0.2, 0.7, 1.0];
        let (t0, h) = (0.4, 0.3);
        let mut polynomial = CollocationPolynomial::new(1, &c);
        (polynomial.t0, polynomial.h, polynomial.y0[0]) = (t0, h, u(t0));
        for (z, c) in polynomial.z.iter_mut().zip(c) {
            *z = u(t0 + c * h) - u(t0);
        }
        for tau in [-0.5, 0.0, 0.35, 0.7, 1.0, 1.8] {
            let t = t0 + tau * h;
            let mut out = [0.0];
            polynomial.value_into(tau, &mut out);
            assert!((out[0] - u(t)).abs() < 1e-13, "value at {tau}: {} {}", out[0], u(t));
            polynomial.derivative_into(tau, &mut out);
            assert!((out[0] - du(t)).abs() < 1e-12, "slope at {tau}: {} {}", out[0], du(t));
            polynomial.change_after_end_into(tau, &mut out);
            assert!((out[0] - (u(t) - u(t0 + h))).abs() < 1e-13, "change at {tau}");
        }
    }
}
