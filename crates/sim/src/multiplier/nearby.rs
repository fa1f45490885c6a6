//! Accelerations next to states that lie off the constraints, near a singular pose.
//!
//! A stage of an explicit step lies off the constraints by more than the end of the step does. At a distance s
//! from a singular pose a singular value is in proportion to s, and divides that gap δ: accelerations are
//! off by δ/s, and higher derivatives by higher powers of 1/s. Those of the state on the constraints
//!
//! ```text
//! a(q*, v*)       (q*, v*) by Newton's steps from (q, v), smallest in the norm of M
//! ```
//!
//! are the same on every solution, and as smooth as it through the pose. What rounding leaves of them is ε/s²;
//! nearer than that allows, they are continued from either side.

use bksim_dae::NotFinite;

use super::{MultiplierSystem, largest};
use crate::evaluator::Evaluator;

/// Rank margin, the square of a distance, below which accelerations are continued from both sides,
const CONTINUED_BELOW: f64 = 1e-5;
/// and that of the nearest states that they are continued from: ε/s² is 1e-12 there.
const ASIDE: f64 = 1e-4;
/// A pose to both sides of which the margin is not within this factor of that is none that the motion passes.
const SOUGHT: f64 = 4.0;

/// States on each side of the pose, and the terms of the polynomial through their accelerations.
const N_SIDE: usize = 3;
const N_TERMS: usize = 2 * N_SIDE;

/// Coefficients of 1, x², x⁴ by the values at x = 1, 2, 3 of an even polynomial; of x, x³, x⁵ by those of
/// an odd one over x.
const EVEN: [[f64; N_SIDE]; N_SIDE] = [
    [36.0 / 24.0, -9.0 / 15.0, 4.0 / 40.0],
    [-13.0 / 24.0, 10.0 / 15.0, -5.0 / 40.0],
    [1.0 / 24.0, -1.0 / 15.0, 1.0 / 40.0],
];

impl MultiplierSystem {
    /// Accelerations ([`MultiplierSystem::accelerations_into`]) of the state on the constraints that is next to this one.
    ///
    /// # Errors
    /// [`NotFinite`] when an entry, or the solution, is not finite.
    pub(crate) fn nearby_into(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        (q, v): (&[f64], &[f64]),
        vdot: &mut [f64],
        lambda: &mut [f64],
    ) -> Result<(), NotFinite> {
        self.factored_into(evaluator, t, (q, v), vdot, lambda)?;
        if self.rank_margin() > CONTINUED_BELOW {
            let (mut q, mut v) = (q.to_vec(), v.to_vec());
            return self.moved_into(evaluator, t, (&mut q, &mut v), vdot, lambda);
        }
        self.continued_into(evaluator, t, (q, v), vdot)
    }

    /// Accelerations ([`MultiplierSystem::accelerations_into`]) by straight-line code where that serves.
    fn factored_into(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        (q, v): (&[f64], &[f64]),
        vdot: &mut [f64],
        lambda: &mut [f64],
    ) -> Result<(), NotFinite> {
        if self.line_into(evaluator, t, (q, v), vdot, lambda) {
            self.take_factors(evaluator);
            return Ok(());
        }
        self.accelerations_into(evaluator, t, (q, v), vdot, lambda)
    }

    /// Moves a state, which has just been factored, onto the constraints; its accelerations there.
    fn moved_into(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        (q, v): (&mut [f64], &mut [f64]),
        vdot: &mut [f64],
        lambda: &mut [f64],
    ) -> Result<(), NotFinite> {
        const CLOSED: f64 = 1e-14;
        const MAX_PASSES: usize = 3;
        for _ in 0..MAX_PASSES {
            let [before, after] = self.close(evaluator, t, (q, v), 1).position;
            self.factored_into(evaluator, t, (q, v), vdot, lambda)?;
            if before <= CLOSED * largest(q).max(1.0) || after >= before {
                break;
            }
        }
        Ok(())
    }

    /// Accelerations in or next to a singular pose that the motion passes, as the polynomial through those to
    /// both sides has them, on a motion that it continues itself: fixed-point passes. Elsewhere `vdot` stays.
    fn continued_into(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        (q, v): (&[f64], &[f64]),
        vdot: &mut [f64],
    ) -> Result<(), NotFinite> {
        const PASSES: usize = 3;
        let Some(s) = self.distance(evaluator, t, (q, v)) else { return Ok(()) };
        let mut path = Path { s, terms: std::array::from_fn(|_| vec![0.0; q.len()]) };
        let mut lambda = vec![0.0; self.residual.len()];
        for _ in 0..PASSES {
            let mut values = [(); N_SIDE].map(|()| [(); 2].map(|()| vec![0.0; q.len()]));
            for (k, sides) in values.iter_mut().enumerate() {
                for (sign, a) in [1.0, -1.0].into_iter().zip(sides) {
                    let x = sign * (k + 1) as f64;
                    let (mut q, mut v) = path.state(x, (q, v));
                    let t = t + x * s;
                    self.factored_into(evaluator, t, (&q, &v), a, &mut lambda)?;
                    self.moved_into(evaluator, t, (&mut q, &mut v), a, &mut lambda)?;
                }
            }
            path.fit(&values);
        }
        vdot.copy_from_slice(&path.terms[0]);
        Ok(())
    }

    /// The time to states before and after this one whose rank margin is [`ASIDE`], s; `None` where the margin
    /// does not rise as it does around a pose that is passed.
    fn distance(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        (q, v): (&[f64], &[f64]),
    ) -> Option<f64> {
        const PASSES: usize = 4;
        const LARGEST_CHANGE: f64 = 100.0;
        let mut s = ASIDE.sqrt() / largest(v);
        for _ in 0..PASSES {
            if !s.is_finite() {
                return None;
            }
            let mut margin = |s: f64| {
                let q: Vec<f64> = q.iter().zip(v).map(|(q, v)| q + s * v).collect();
                self.rank_margin_at(&evaluator.dynamics(t + s, &q, v))
            };
            // It rises as the square of the distance.
            let larger = margin(s).max(margin(-s));
            if larger > ASIDE / SOUGHT && larger < ASIDE * SOUGHT {
                return Some(s);
            }
            s *= (ASIDE / larger).sqrt().clamp(1.0 / LARGEST_CHANGE, LARGEST_CHANGE);
        }
        None
    }
}

/// A motion through a state, x its time from there as a multiple of s.
///
/// ```text
/// a(x) = Σ c_p xᵖ     v(x) = v + s Σ c_p xᵖ⁺¹/(p + 1)     q(x) = q + s x v + s² Σ c_p xᵖ⁺²/((p + 1) (p + 2))
/// ```
struct Path {
    s: f64,
    /// c_p.
    terms: [Vec<f64>; N_TERMS],
}

impl Path {
    fn state(&self, x: f64, (q, v): (&[f64], &[f64])) -> (Vec<f64>, Vec<f64>) {
        let ds = x * self.s;
        let mut q: Vec<f64> = q.iter().zip(v).map(|(q, v)| q + ds * v).collect();
        let mut v = v.to_vec();
        let mut power = ds;
        for (p, terms) in self.terms.iter().enumerate() {
            let first = power / (p + 1) as f64;
            let second = first * ds / (p + 2) as f64;
            v.iter_mut().zip(terms).for_each(|(v, c)| *v += first * c);
            q.iter_mut().zip(terms).for_each(|(q, c)| *q += second * c);
            power *= x;
        }
        (q, v)
    }

    /// Takes the accelerations at x = 1, −1, 2, −2, 3, −3.
    fn fit(&mut self, values: &[[Vec<f64>; 2]; N_SIDE]) {
        self.terms.iter_mut().for_each(|terms| terms.fill(0.0));
        for (k, [after, before]) in values.iter().enumerate() {
            let x = (k + 1) as f64;
            for (row, pair) in EVEN.iter().zip(self.terms.chunks_exact_mut(2)) {
                let [even, odd] = pair else { unreachable!("terms come in pairs") };
                for (i, (after, before)) in after.iter().zip(before).enumerate() {
                    even[i] += row[k] * 0.5 * (after + before);
                    odd[i] += row[k] * 0.5 * (after - before) / x;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_has_the_accelerations_that_it_was_fitted_to() {
        let terms = [0.3, -1.2, 0.7, 2.1, -0.4, 0.9];
        let a = |x: f64| terms.iter().rev().fold(0.0, |sum, c| sum * x + c);
        let side = |k: usize| [1.0, -1.0].map(|sign| vec![a(sign * (k + 1) as f64)]);
        let mut path = Path { s: 0.1, terms: std::array::from_fn(|_| vec![f64::NAN]) };
        path.fit(&std::array::from_fn(side));
        for (found, expected) in path.terms.iter().zip(terms) {
            assert!((found[0] - expected).abs() < 1e-14, "{found:?} against {expected}");
        }

        // Its position and velocity are the integrals.
        let (d, x) = (1e-3, 2.5);
        let [before, here, after] = [x - d, x, x + d].map(|x| path.state(x, (&[0.2], &[-0.5])));
        let step = d * path.s;
        let slope = (after.0[0] - before.0[0]) / (2.0 * step);
        let curvature = (after.0[0] - 2.0 * here.0[0] + before.0[0]) / (step * step);
        assert!((slope - here.1[0]).abs() < 1e-5, "{slope} against {}", here.1[0]);
        assert!((curvature - a(x)).abs() < 1e-4 * a(x).abs(), "{curvature} against {}", a(x));
    }
}
