//! Accelerations in a singular pose, read off the motion around it.

use bksim_dae::NotFinite;

use super::{MultiplierSystem, largest};
use crate::evaluator::Evaluator;

/// Weaker than this, the rounding and drift of a state are divided by a singular value so small that
/// accelerations are taken as a limit.
const LIMIT_BELOW: f64 = 1e-10;
/// How far around a singular pose its limit is looked for, as a part of the size of the state.
const ASIDE: f64 = 1e-3;

/// Kind of the accelerations that were found.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Solution {
    /// The solution at the state.
    Regular,
    /// Limit of the accelerations in a singular pose; multipliers have none.
    Limit,
}

impl MultiplierSystem {
    /// Accelerations ([`MultiplierSystem::accelerations_into`]) in a singular pose too: they have a
    /// limit there, which is read off the motion a little before and after.
    ///
    /// ```text
    /// q(s) = q + s v + s²/2 a + s³/6 j       v(s) = v + s a + s²/2 j
    /// a = (4 (a₁ + a₋₁) − (a₂ + a₋₂))/6       j = (8 (a₁ − a₋₁) − (a₂ − a₋₂))/(12 s)
    /// ```
    ///
    /// with a₁ … a₋₂ the accelerations at s, −s, 2 s, −2 s, until a and the jerk j agree with their
    /// own motion; the error is of order s⁴.
    ///
    /// # Errors
    /// [`NotFinite`] when an entry, or the solution, is not finite.
    pub(crate) fn limit_into(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        (q, v): (&[f64], &[f64]),
        vdot: &mut [f64],
        lambda: &mut [f64],
    ) -> Result<Solution, NotFinite> {
        const PASSES: usize = 3;
        // A small mechanism has straight-line code, which answers away from singular poses.
        if self.line_into(evaluator, t, (q, v), vdot, lambda) {
            self.take_factors(evaluator);
            return Ok(Solution::Regular);
        }
        // Elsewhere the factorisation tells whether the pose is singular.
        self.accelerations_into(evaluator, t, (q, v), vdot, lambda)?;
        let fastest = largest(v);
        if self.rank_margin() > LIMIT_BELOW {
            return Ok(Solution::Regular);
        }
        if fastest == 0.0 {
            return Ok(Solution::Limit);
        }
        // There, accelerations and their rate are those at four instants close by, on a motion that they
        // themselves continue: fixed-point passes.
        let s = ASIDE * largest(q).max(1.0) / fastest;
        let n = q.len();
        let [mut a, mut jerk, mut side] = [(); 3].map(|()| vec![0.0; n]);
        let mut unused = vec![0.0; lambda.len()];
        for _ in 0..PASSES {
            let [mut next, mut next_jerk] = [(); 2].map(|()| vec![0.0; n]);
            for (k, mean, slope) in
                [(1.0, 4.0, 8.0), (-1.0, 4.0, -8.0), (2.0, -1.0, -1.0), (-2.0, -1.0, 1.0)]
            {
                let ds = k * s;
                let rate = |i: usize| v[i] + ds * (a[i] + 0.5 * ds * jerk[i]);
                let position =
                    |i: usize| q[i] + ds * (v[i] + 0.5 * ds * (a[i] + ds / 3.0 * jerk[i]));
                let (q, v): (Vec<f64>, Vec<f64>) = (0..n).map(|i| (position(i), rate(i))).unzip();
                let (side, unused) = (&mut side, &mut unused);
                self.accelerations_into(evaluator, t + ds, (&q, &v), side, unused)?;
                // A motion that is singular on both sides too has no better answer than the smallest one.
                if self.rank_margin() <= LIMIT_BELOW {
                    return Ok(Solution::Limit);
                }
                for i in 0..n {
                    next[i] += mean / 6.0 * side[i];
                    next_jerk[i] += slope / (12.0 * s) * side[i];
                }
            }
            (a, jerk) = (next, next_jerk);
        }
        vdot.copy_from_slice(&a);
        Ok(Solution::Limit)
    }
}
