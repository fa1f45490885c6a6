//! A step by the Taylor series of the solution.
//!
//! ```text
//! y1 = y0 + Σ c_k h^k,  k = 1 … p
//! h = min ρ_k S^{−1/p},  ρ_k = (S/‖c_k‖)^{1/k},  k = p − 5 … p
//! ```
//!
//! in units of the tolerance, where S is the size of the unknowns: the last term of a series that falls evenly is as large
//! as the error may be, what follows it is less. Motions from rest have terms of every second or fourth order only, hence
//! the six. À. Jorba and M. Zou, *A software package for the numerical integration of ODEs by means of high-order
//! Taylor methods*, Experimental Mathematics 14 (2005), §3. No step is tried twice for its error.

#![expect(clippy::inline_always, reason = "kernels are compiled with the registers of `run`")]

#[cfg(test)]
mod tests;

use pulp::{Simd, WithSimd};

use super::sums::{Columns, WIDTH};
use crate::dense::TaylorPolynomial;
use crate::lanes::run;
use crate::scale::Scale;
use crate::settings::LAST_TERM;
use crate::system::Ode;

/// Part of the step, where numbers that the equations divide by may vanish within it, that is tried instead,
const CUT: f64 = 0.7;
/// so often.
const MOST_CUTS: usize = 8;

/// The last terms that the size of a step follows from.
const N_LOOKED_AT: usize = 6;

/// The series at the state that the run has reached.
pub(super) struct TaylorSeries {
    n: usize,
    order: usize,
    /// ln S.
    log_size: f64,
    /// `c_1 … c_p`, one after the other, what else the system wrote down with them, and a block more.
    results: Vec<f64>,
    /// The size of the step that the series serves for; `None` where there is none, and steps are taken by stages.
    reach: Option<f64>,
    /// The end of the step without its last term, and `f` there.
    pub(super) near: Columns,
    pub(super) f_near: Vec<f64>,
    /// The end of the step, and its last term.
    pub(super) end: Columns,
    pub(super) last_term: Columns,
}

impl TaylorSeries {
    /// For `n` unknowns.
    pub(super) fn new(n: usize, order: usize, rtol: f64) -> Self {
        let zero = || Columns::new(n, 1);
        Self {
            n,
            order,
            log_size: -(LAST_TERM * rtol).ln(),
            results: vec![0.0; order * n + WIDTH],
            reach: None,
            near: zero(),
            f_near: vec![0.0; n],
            end: zero(),
            last_term: zero(),
        }
    }

    /// True where steps from here are taken by the series.
    pub(super) fn is_known(&self) -> bool {
        self.reach.is_some()
    }

    /// Steps from here are taken by stages.
    pub(super) fn forget(&mut self) {
        self.reach = None;
    }

    /// Room for the dense output of a step.
    pub(super) fn polynomial(&self) -> TaylorPolynomial {
        TaylorPolynomial::new(self.n, self.order)
    }

    /// Develops the solution through `(t, y)`, of which the scale knows the weights; the size of the step that it
    /// serves for, at most `longest`, or `None` where steps are taken by stages.
    pub(super) fn develop<S: Ode>(
        &mut self,
        system: &mut S,
        (t, y): (f64, &[f64]),
        scale: &Scale,
        longest: f64,
    ) -> Option<f64> {
        let Self { n, order, log_size, results, reach, .. } = self;
        let (n, p) = (*n, *order);
        *reach = None;
        if !system.series(t, y, p, results) {
            return None;
        }
        results.resize(results.len().max(p * n + WIDTH), 0.0);
        // The logarithm of 1/h of each term.
        let log_last_term = LAST_TERM.ln();
        let steepness = |k: usize| {
            let log = 0.5 * scale.mean_square(&results[(k - 1) * n..][..n]).ln() - log_last_term;
            (log - (1.0 - k as f64 / p as f64) * *log_size) / k as f64
        };
        let steepest = (p + 1 - N_LOOKED_AT.min(p)..=p).map(steepness);
        let steepest =
            steepest.fold(f64::NEG_INFINITY, |a, b| if b > a || b.is_nan() { b } else { a });
        if steepest.is_nan() {
            return None;
        }
        let mut h = (-steepest).exp().min(longest);
        for _ in 0..MOST_CUTS {
            if system.series_holds(h, results) {
                *reach = Some(h);
                return *reach;
            }
            h *= CUT;
        }
        None
    }

    /// The end of a step of this size from `y0`.
    pub(super) fn step(&mut self, h: f64, y0: &Columns) {
        let Self { n, order, results, near, end, last_term, .. } = self;
        let shape = (*n, *order);
        run(Sum { h, shape, coefficients: results, y0, near, end, last_term });
    }

    /// About the last term of a step of this size, as a part of what it may be.
    pub(super) fn error(&self, h: f64) -> f64 {
        /// Rounding does not reject a step.
        const BELOW: f64 = 0.99;
        let part = h.abs() / self.reach.unwrap_or(f64::INFINITY);
        BELOW * part.powi(i32::try_from(self.order).unwrap_or(i32::MAX))
    }

    /// Hands the series of the accepted step over to its dense output, whose former one it takes as room.
    pub(super) fn hand_over(&mut self, polynomial: &mut TaylorPolynomial, y1: &[f64]) {
        std::mem::swap(&mut self.results, &mut polynomial.coefficients);
        let ends = y1.iter().zip(self.end.values());
        polynomial.shift.iter_mut().zip(ends).for_each(|(shift, (y1, end))| *shift = y1 - end);
    }
}

/// Horner's rule for blocks of unknowns. What a block reads of its neighbours is not used.
struct Sum<'a> {
    h: f64,
    /// n and p.
    shape: (usize, usize),
    coefficients: &'a [f64],
    y0: &'a Columns,
    near: &'a mut Columns,
    end: &'a mut Columns,
    last_term: &'a mut Columns,
}

impl WithSimd for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { h, shape: (n, p), coefficients, y0, near, end, last_term } = self;
        let power = h.powi(i32::try_from(p).unwrap_or(i32::MAX));
        for b in 0..n.div_ceil(WIDTH) {
            let row = |k: usize| coefficients[(k - 1) * n + b * WIDTH..].first_chunk::<WIDTH>();
            let y0 = y0.block(b);
            let (mut sum, mut term) = ([0.0; WIDTH], [0.0; WIDTH]);
            for k in (1..p).rev() {
                let Some(c) = row(k) else { return };
                for lane in 0..WIDTH {
                    sum[lane] = (sum[lane] + c[lane]) * h;
                }
            }
            let Some(c) = row(p) else { return };
            let (mut before, mut at_end) = (*y0, *y0);
            for lane in 0..WIDTH {
                term[lane] = power * c[lane];
                before[lane] += sum[lane];
                at_end[lane] += sum[lane] + term[lane];
            }
            *near.block_mut(b) = before;
            *end.block_mut(b) = at_end;
            *last_term.block_mut(b) = term;
        }
    }
}
