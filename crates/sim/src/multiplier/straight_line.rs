//! Solutions and factors by straight-line code, which small mechanisms have: taken over where their pivots are regular.

use super::projection::PROJECTED_ABOVE;
use super::{Factors, MultiplierSystem, REFINED_BELOW};
use crate::evaluator::Evaluator;
use crate::linear::elimination::n_padded;

impl MultiplierSystem {
    /// Accelerations and multipliers by straight-line code, which small mechanisms have; false where there
    /// is none, or they need a closer look. Their factors are left with the evaluator.
    pub(crate) fn line_into(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        (q, v): (&[f64], &[f64]),
        vdot: &mut [f64],
        lambda: &mut [f64],
    ) -> bool {
        if self.active.len() != lambda.len() || self.augmented.is_some() {
            return false;
        }
        let Some(line) = evaluator.unrolled(t, q, v) else { return false };
        let (solution, factors) = line.split_at(vdot.len() + lambda.len());
        let (a, multipliers) = solution.split_at(vdot.len());
        vdot.copy_from_slice(a);
        lambda.copy_from_slice(multipliers);
        let pivots = &factors[..solution.len()];
        self.factors = Factors::Recorded;
        self.elimination.accept_pivots(pivots)
            && self.elimination.rank_margin() > REFINED_BELOW
            // Without a branch at each entry, several are looked at together.
            && solution.iter().fold(true, |all, value| all & value.is_finite())
    }

    /// Straight-line evaluation ([`MultiplierSystem::line_into`]) with the factors taken from the evaluator.
    pub(crate) fn factored_line_into(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        state: (&[f64], &[f64]),
        vdot: &mut [f64],
        lambda: &mut [f64],
    ) -> bool {
        let is_line = self.line_into(evaluator, t, state, vdot, lambda);
        if is_line {
            self.take_factors(evaluator);
        }
        is_line
    }

    /// Takes the factors that straight-line code has left with the evaluator.
    pub(crate) fn take_factors(&mut self, evaluator: &Evaluator) {
        self.elimination.take(evaluator.unrolled_factors().iter().copied());
    }

    /// Looks at accelerations and multipliers of several states at once, and the factors they come from;
    /// false where one of them needs a closer look.
    pub(crate) fn accept_lanes<const N: usize>(
        &mut self,
        solution: &[[f64; N]],
        factors: &[[f64; N]],
    ) -> bool {
        if self.active.len() + self.nq != solution.len() || self.augmented.is_some() {
            return false;
        }
        self.factors = Factors::Recorded;
        self.elimination.accept_lanes(factors[..solution.len()].iter().copied())
            && self.elimination.rank_margin() > REFINED_BELOW
            && solution.as_flattened().iter().fold(true, |all, value| all & value.is_finite())
    }

    /// Looks at the pivots of the stages of a step, each [`padded`](crate::linear::elimination::padded), and shows their
    /// rank margins to `observe`: as one, the least, where that is `regular`. False, as if they had never been seen, where
    /// one of them needs a closer look.
    pub(crate) fn accept_stages(
        &mut self,
        pivots: &[f64],
        regular: f64,
        mut observe: impl FnMut(f64),
    ) -> bool {
        self.factors = Factors::Recorded;
        let n = n_padded(self.x.len());
        let Self { elimination, .. } = self;
        elimination.keep_best();
        if elimination.accept_states(pivots) && elimination.rank_margin() >= regular {
            observe(elimination.rank_margin());
            return true;
        }
        elimination.restore_best();
        for stage in pivots.chunks_exact(n) {
            let is_regular = elimination.accept_states(stage);
            if !is_regular || elimination.rank_margin() <= REFINED_BELOW {
                elimination.restore_best();
                return false;
            }
            observe(elimination.rank_margin());
        }
        true
    }

    /// Looks at the pivots of a sample, those near it and there, each [`padded`](crate::linear::elimination::padded). False,
    /// as if they had never been seen, where one of them needs a closer look or states are not projected.
    pub(crate) fn accept_sample(&mut self, pivots: &[f64]) -> bool {
        self.factors = Factors::Recorded;
        let Self { elimination, .. } = self;
        elimination.keep_best();
        let are_regular = elimination.accept_states(pivots)
            && elimination.rank_margin() >= PROJECTED_ABOVE.max(REFINED_BELOW);
        if !are_regular {
            elimination.restore_best();
        }
        are_regular
    }

    /// Rank margin ([`MultiplierSystem::rank_margin_at`]) by straight-line code where that serves.
    pub(crate) fn rank_margin_of(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        (q, v): (&[f64], &[f64]),
    ) -> f64 {
        let n = self.x.len();
        if self.is_whole(evaluator.shape().nc)
            && let Some(line) = evaluator.unrolled(t, q, v)
        {
            let is_regular = self.elimination.accept_pivots(&line[n..2 * n]);
            if is_regular && self.elimination.rank_margin() > REFINED_BELOW {
                return self.elimination.rank_margin();
            }
        }
        self.rank_margin_at(&evaluator.dynamics(t, q, v))
    }

    /// Takes factors that were computed elsewhere, see [`Elimination::take`](crate::linear::elimination::Elimination::take).
    pub(crate) fn take_stage(&mut self, factors: &[f64]) {
        self.elimination.take(factors.iter().copied());
    }
}
