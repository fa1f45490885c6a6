//! Counters of the work done, in Hairer's sense (header of `RADAU5`).

use std::fmt;
use std::ops::AddAssign;

/// Work of a run, or of a part of it: parts add up.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Stats {
    /// Steps tried: accepted, rejected by the error test, and failed in Newton's method.
    pub n_step: usize,
    /// Steps accepted.
    pub n_accept: usize,
    /// Steps rejected by the error test; rejections of the very first step size are included.
    pub n_reject: usize,
    /// Steps given up because Newton's iteration diverged, was too slow, met a singular iteration
    /// matrix or a value that is not finite.
    pub n_newton_failed: usize,
    /// Newton iterations over all steps; each evaluates the residual at every stage.
    pub n_newton: usize,
    /// Evaluations of the residual, those of the error estimate included.
    pub n_residual: usize,
    /// Evaluations of the Jacobian (`∂F/∂y` and `∂F/∂y′` together count once).
    pub n_jacobian: usize,
    /// Factorisations of the set of iteration matrices (one real, `(s − 1)/2` complex count once).
    pub n_factor: usize,
    /// Solves with the set of iteration matrices, those of the error estimate included.
    pub n_solve: usize,
}

impl Stats {
    /// All counters, in the order of the fields.
    pub(crate) fn counters(&mut self) -> [&mut usize; 9] {
        // Taken apart, so that no counter can be forgotten.
        let Self {
            n_step: a,
            n_accept: b,
            n_reject: c,
            n_newton_failed: d,
            n_newton: e,
            n_residual: f,
            n_jacobian: g,
            n_factor: h,
            n_solve: i,
        } = self;
        [a, b, c, d, e, f, g, h, i]
    }
}

impl AddAssign for Stats {
    fn add_assign(&mut self, mut other: Self) {
        self.counters().into_iter().zip(other.counters()).for_each(|(sum, own)| *sum += *own);
    }
}

impl fmt::Display for Stats {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} steps ({} accepted, {} rejected, {} Newton failures), {} Newton iterations, \
             {} residuals, {} Jacobians, {} factorisations, {} solves",
            self.n_step,
            self.n_accept,
            self.n_reject,
            self.n_newton_failed,
            self.n_newton,
            self.n_residual,
            self.n_jacobian,
            self.n_factor,
            self.n_solve
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counters that are all different: `first`, `first + step`, ….
    fn counters(first: usize, step: usize) -> Stats {
        let mut stats = Stats::default();
        let own = stats.counters().into_iter().enumerate();
        own.for_each(|(k, counter)| *counter = first + k * step);
        stats
    }

    #[test]
    fn every_counter_adds_to_its_own() {
        let mut sum = counters(1, 1);
        sum += counters(100, 10);
        assert_eq!(sum, counters(101, 11));
    }
}
