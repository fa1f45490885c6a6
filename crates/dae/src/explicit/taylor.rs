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

#[cfg(test)]
mod tests;

use super::derivative;
use super::straight_line::{Eager, Recorder};
use crate::dense::TaylorPolynomial;
use crate::scale::Scale;
use crate::settings::LAST_TERM;
use crate::stats::Stats;
use crate::system::{NotFinite, Ode, StepSpan};

/// Part of the step, where numbers that the equations divide by may vanish within it, that is tried instead,
const CUT: f64 = 0.7;
/// so often.
const MOST_CUTS: usize = 8;

/// The last terms that the size of a step follows from.
const N_LOOKED_AT: usize = 6;

/// Vectors, as long as there are unknowns, of a step by a series, in the order in which [`Ode::series_step`] writes them
/// after the coefficients of the series from its end.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum SeriesVector {
    /// The end without the last term, a state near it.
    Near,
    /// `f` there.
    NearDerivative,
    /// The end before any projection.
    End,
    /// The last term.
    LastTerm,
    /// The projected end.
    ProjectedEnd,
    /// `f` there.
    EndDerivative,
}

/// The number of [`SeriesVector`]s.
pub const N_SERIES_VECTORS: usize = SeriesVector::EndDerivative as usize + 1;

/// The series at the state that the run has reached.
pub(super) struct TaylorSeries {
    n: usize,
    order: usize,
    /// ln S.
    log_size: f64,
    /// `c_1 … c_p`, one after the other, room for vectors, and what else the system wrote down with them.
    results: Vec<f64>,
    /// The vectors of the step that was tried last, with the series from its end in the same order.
    next: Vec<f64>,
    /// True where the system has taken that step as a whole, so that its end and the series there are known.
    is_whole: bool,
    /// The size of the step that the series serves for; `None` where there is none, and steps are taken by stages.
    reach: Option<f64>,
    /// The last term of the step that was tried last.
    last_term: Vec<f64>,
}

impl TaylorSeries {
    /// For `n` unknowns.
    pub(super) fn new(n: usize, order: usize, rtol: f64) -> Self {
        let results = vec![0.0; (order + N_SERIES_VECTORS) * n];
        Self {
            n,
            order,
            log_size: -(LAST_TERM * rtol).ln(),
            next: results.clone(),
            results,
            is_whole: false,
            reach: None,
            last_term: vec![0.0; n],
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

    /// A vector of the step that was tried last.
    pub(super) fn vector(&self, vector: SeriesVector) -> &[f64] {
        &self.next[(self.order + vector as usize) * self.n..][..self.n]
    }

    pub(super) fn last_term(&self) -> &[f64] {
        &self.last_term
    }

    /// Forgets the step that was tried last: the run goes on from elsewhere.
    pub(super) fn leave(&mut self) {
        self.is_whole = false;
    }

    /// Develops the solution through `(t, y)`, of which the scale knows the weights, unless the last step has; the size
    /// of the step that the series serves for, at most `longest`, or `None` where steps are taken by stages.
    pub(super) fn develop<S: Ode>(
        &mut self,
        system: &mut S,
        (t, y): (f64, &[f64]),
        scale: &Scale,
        longest: f64,
    ) -> Option<f64> {
        let Self { order, results, next, reach, is_whole, .. } = self;
        *reach = None;
        if std::mem::take(is_whole) {
            std::mem::swap(results, next);
        } else if !system.series(t, y, *order, results) {
            return None;
        }
        let mut h = self.longest_step(scale)?.min(longest);
        for _ in 0..MOST_CUTS {
            if system.series_holds(h, &self.results) {
                self.reach = Some(h);
                return self.reach;
            }
            h *= CUT;
        }
        None
    }

    /// The size of the step whose last terms are as large as they may be; `None` where they are not finite.
    fn longest_step(&self, scale: &Scale) -> Option<f64> {
        let Self { n, order: p, log_size, .. } = *self;
        // The mean squares of the last terms, side by side.
        let orders: [usize; N_LOOKED_AT] =
            std::array::from_fn(|i| (p + 1 + i).saturating_sub(N_LOOKED_AT).max(1));
        let terms = orders.map(|k| &self.results[(k - 1) * n..][..n]);
        let mean_squares = scale.mean_squares(terms);
        // The logarithm of 1/h of each term, by that of its mean square.
        let log_last_term = LAST_TERM.ln();
        let steepness = |k: usize, log: f64| {
            let k = k as f64;
            (0.5 * log - log_last_term - log_size) / k + log_size / p as f64
        };
        // The steepest of them by logarithms in a hurry, and how steep it is.
        let mut steepest = (f64::NEG_INFINITY, 0);
        for (i, (k, mean_square)) in orders.into_iter().zip(mean_squares).enumerate() {
            let steep = steepness(k, rough_ln(mean_square));
            if steep > steepest.0 {
                steepest = (steep, i);
            }
        }
        let (_, i) = steepest;
        let steep = steepness(orders[i], mean_squares[i].ln());
        (steep < f64::INFINITY).then(|| (-steep).exp())
    }

    /// The step from `y`; true where the system has taken it as a whole, so that [`TaylorSeries::finish`] knows its end.
    pub(super) fn step<S: Ode>(&mut self, system: &mut S, span: StepSpan, y: &[f64]) -> bool {
        let Self { n, order, results, next, .. } = self;
        self.is_whole = system.series_step(span, y, results, next);
        if !self.is_whole {
            let (n, p) = (*n, *order);
            next.resize(next.len().max((p + N_SERIES_VECTORS) * n), 0.0);
            let ends = &mut next[p * n..];
            for i in 0..n {
                let own = (0..p).map(|k| results[k * n + i]);
                let [near, end, last_term] = record_series_end(&mut Eager, span.h, y[i], own);
                ends[SeriesVector::Near as usize * n + i] = near;
                ends[SeriesVector::End as usize * n + i] = end;
                ends[SeriesVector::LastTerm as usize * n + i] = last_term;
            }
        }
        let last_term = &self.next[(self.order + SeriesVector::LastTerm as usize) * self.n..];
        self.last_term.iter_mut().zip(last_term).for_each(|(own, &term)| *own = term);
        self.is_whole
    }

    /// True where the end of the step and `f` there are known; otherwise `f` near it is, from now on.
    pub(super) fn finish<S: Ode>(
        &mut self,
        system: &mut S,
        t1: f64,
        stats: &mut Stats,
    ) -> Result<bool, NotFinite> {
        if !self.is_whole {
            let vectors = &mut self.next[self.order * self.n..];
            let (near, rest) = vectors.split_at_mut(self.n);
            derivative(system, t1, near, &mut rest[..self.n], stats)?;
        }
        Ok(self.is_whole)
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
        let ends = y1.iter().zip(self.vector(SeriesVector::End));
        polynomial.shift.iter_mut().zip(ends).for_each(|(shift, (y1, end))| *shift = y1 - end);
    }
}

/// The natural logarithm to a tenth: the mantissa of a positive number is its logarithm to base two nearly enough.
fn rough_ln(x: f64) -> f64 {
    const ONE: f64 = 1023.0;
    const LAST_BIT: f64 = 1.0 / (1u64 << 52) as f64;
    // Of what is no number, too, without its sign.
    std::f64::consts::LN_2 * (x.abs().to_bits().cast_signed() as f64 * LAST_BIT - ONE)
}

/// Records the end of a step of size `h` by a series: of an unknown `y` with coefficients `c_1 … c_p` the end without
/// the last term, the end, and the last term, by Horner's rule.
pub fn record_series_end<R: Recorder>(
    recorder: &mut R,
    h: R::Value,
    y: R::Value,
    coefficients: impl DoubleEndedIterator<Item = R::Value> + ExactSizeIterator,
) -> [R::Value; 3] {
    let mut rest = coefficients.len();
    let mut highest_first = coefficients.rev();
    let Some(last) = highest_first.next() else {
        let none = recorder.constant(0.0);
        return [y, y, none];
    };
    // The power of h by repeated squaring.
    let (mut power, mut square) = (None, h);
    loop {
        if rest % 2 == 1 {
            power = Some(power.map_or(square, |power| recorder.multiply(power, square)));
        }
        rest /= 2;
        if rest == 0 {
            break;
        }
        square = recorder.multiply(square, square);
    }
    let last_term = recorder.multiply(power.unwrap_or(h), last);
    let sum = highest_first.fold(None, |sum: Option<R::Value>, c| {
        Some(sum.map_or(c, |sum| {
            let higher = recorder.multiply(sum, h);
            recorder.add(higher, c)
        }))
    });
    let near = sum.map_or(y, |sum| {
        let all = recorder.multiply(sum, h);
        recorder.add(all, y)
    });
    [near, recorder.add(near, last_term), last_term]
}
