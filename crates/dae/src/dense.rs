//! Dense output: an accepted step as its polynomial, of either method.

mod collocation;
mod extension;

pub(crate) use self::collocation::CollocationPolynomial;
pub(crate) use self::extension::{ContinuousExtension, N_STAGES, N_TERMS};
use crate::stats::Stats;

/// The dense output of either method.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Interpolant<'a> {
    Collocation(&'a CollocationPolynomial),
    Explicit(&'a ContinuousExtension),
}

/// An accepted step, with the solution at its end and everywhere between.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    pub(crate) polynomial: Interpolant<'a>,
    pub(crate) t1: f64,
    pub(crate) y1: &'a [f64],
    pub(crate) ydot1: &'a [f64],
    pub(crate) error: Option<f64>,
    pub(crate) stats: &'a Stats,
}

impl<'a> Step<'a> {
    /// Start of the step.
    pub fn t0(&self) -> f64 {
        match self.polynomial {
            Interpolant::Collocation(polynomial) => polynomial.t0,
            Interpolant::Explicit(extension) => extension.t0,
        }
    }

    /// End of the step.
    pub fn t1(&self) -> f64 {
        self.t1
    }

    /// Signed step size, negative when integrating backwards.
    pub fn h(&self) -> f64 {
        match self.polynomial {
            Interpolant::Collocation(polynomial) => polynomial.h,
            Interpolant::Explicit(extension) => extension.h,
        }
    }

    /// State at `t0`.
    pub fn y0(&self) -> &'a [f64] {
        match self.polynomial {
            Interpolant::Collocation(polynomial) => &polynomial.y0,
            Interpolant::Explicit(extension) => &extension.y0,
        }
    }

    /// State at `t1`.
    pub fn y1(&self) -> &'a [f64] {
        self.y1
    }

    /// Derivative at `t1`; `F(t1, y1, ydot1) = 0` up to the tolerance of Newton's iteration.
    pub fn ydot1(&self) -> &'a [f64] {
        self.ydot1
    }

    /// The error estimate in units of the tolerance, below one; `None` with a fixed step size.
    pub fn error(&self) -> Option<f64> {
        self.error
    }

    /// Number of stages of the method that took the step.
    pub fn n_stages(&self) -> usize {
        match self.polynomial {
            Interpolant::Collocation(polynomial) => polynomial.n_stages(),
            Interpolant::Explicit(_) => N_STAGES,
        }
    }

    /// Degree of the polynomial of [`Step::at`].
    pub fn degree(&self) -> usize {
        match self.polynomial {
            Interpolant::Collocation(polynomial) => polynomial.n_stages(),
            Interpolant::Explicit(_) => N_TERMS,
        }
    }

    /// Work done in the run so far.
    pub fn stats(&self) -> &'a Stats {
        self.stats
    }

    /// Writes the state at `t` (length `n`) by the collocation polynomial, exact to order `s + 1`
    /// within the step, or the continuous extension, of order 7; extrapolated outside.
    pub fn at(&self, t: f64, y: &mut [f64]) {
        if t == self.t1 {
            y.copy_from_slice(self.y1);
        } else {
            let tau = (t - self.t0()) / self.h();
            match self.polynomial {
                Interpolant::Collocation(polynomial) => polynomial.value_into(tau, y),
                Interpolant::Explicit(extension) => extension.value_into(tau, y),
            }
        }
    }

    /// Writes the derivative of that polynomial at `t` (length `n`), one order less
    /// exact than [`Step::at`].
    pub fn derivative_at(&self, t: f64, ydot: &mut [f64]) {
        let tau = (t - self.t0()) / self.h();
        match self.polynomial {
            Interpolant::Collocation(polynomial) => polynomial.derivative_into(tau, ydot),
            Interpolant::Explicit(extension) => extension.derivative_into(tau, ydot),
        }
    }
}

/// Writes nested sums of vectors, from the last of `n_terms` to the first: `sum ← outer(k, term k + sum)`. Four numbers
/// are taken side by side.
fn sums_into(terms: &[f64], n_terms: usize, out: &mut [f64], outer: impl Fn(usize, f64) -> f64) {
    let n = out.len();
    let (fours, rest) = out.as_chunks_mut::<4>();
    for (block, out) in fours.iter_mut().enumerate() {
        let mut sums = [0.0; 4];
        for k in (0..n_terms).rev() {
            let term = &terms[k * n + 4 * block..][..4];
            sums = std::array::from_fn(|lane| outer(k, term[lane] + sums[lane]));
        }
        *out = sums;
    }
    let first = n - rest.len();
    for (i, out) in rest.iter_mut().enumerate() {
        *out = (0..n_terms).rev().fold(0.0, |sum, k| outer(k, terms[k * n + first + i] + sum));
    }
}
