//! Starts of mechanisms whose conditions repeat each other up to the digits of the numbers in a model.
//!
//! Axes that are meant to be parallel and come from a file with eight digits are not quite: a flat loop in space then closes
//! to some 1e-9 m alone. Such a condition has a slope as small, and Newton's method would go far to hold it.

use super::{Closing, size};
use crate::evaluator::Evaluator;
use crate::linear::rank::dependent_rows;
use crate::linear::rows::{length, shortest_solution};
use crate::multiplier::largest;

/// Conditions that repeat others may miss by this, relative to the size of the mechanism.
const TOLERANCE: f64 = 1e-7;
/// The direct way has gone far to hold such a condition if a coordinate differs by this, relative to the size.
const FAR: f64 = 1e-4;

impl Closing<'_> {
    /// A start near `guess` in which conditions that others repeat miss by what rounded numbers of a model do, with what is left
    /// of the largest row; `None` unless the direct way, which came to `q` with `left`, fails or has gone far to hold them.
    pub(super) fn rounded_start(
        &mut self,
        evaluator: &mut Evaluator,
        (stated, left): (&[usize], f64),
        t: f64,
        (guess, q): (&[f64], &[f64]),
    ) -> Option<(Vec<f64>, f64)> {
        let is_closed = left <= self.tolerance * size(q) && self.is_aligned(t, q);
        if !self.repeats(evaluator, t, q) {
            return None;
        }
        let mut near = guess.to_vec();
        let left = self.onto_independent(evaluator, stated, t, &mut near);
        if left.is_nan() || left > TOLERANCE * size(&near) || !self.is_aligned(t, &near) {
            return None;
        }
        let far = FAR * size(&near);
        let is_far = q.iter().zip(&near).any(|(q, near)| (q - near).abs() > far);
        if is_closed && !is_far {
            return None;
        }
        self.tolerance = TOLERANCE;
        Some((near, left))
    }

    /// True where rows depend on others, not for this pose alone.
    fn repeats(&mut self, evaluator: &mut Evaluator, t: f64, q: &[f64]) -> bool {
        /// Part of a radian, or of a metre.
        const ASIDE: f64 = 1e-3;
        let mut part: f64 = 0.5;
        let aside = |value: &f64| {
            part = (part + 0.618).fract();
            value + ASIDE * (0.5 + part)
        };
        let aside: Vec<f64> = q.iter().map(aside).collect();
        let there = evaluator.constraints(t, &aside).jacobian_rows();
        !dependent_rows(&there).dependent.is_empty()
    }

    /// Leads a pose onto the rows that do not follow from others; returns what is left of all.
    fn onto_independent(
        &mut self,
        evaluator: &mut Evaluator,
        stated: &[usize],
        t: f64,
        q: &mut Vec<f64>,
    ) -> f64 {
        const MAX_STEPS: usize = 60;
        let mut at = self.position_rows(evaluator, stated, true, t, q);
        for _ in 0..MAX_STEPS {
            let dependent = dependent_rows(&at.gradients).dependent;
            let rows = (0..at.values.len()).filter(|row| !dependent.contains(row));
            let rows: Vec<usize> = rows.collect();
            let of = |values: &[f64]| -> Vec<f64> { rows.iter().map(|&row| values[row]).collect() };
            let values = of(&at.values);
            let step = shortest_solution(&at.gradients.select(&rows), &values);
            let mut damping = 1.0;
            let next = loop {
                let trial = q.iter().zip(&step).map(|(q, step)| q - damping * step);
                let trial: Vec<f64> = trial.collect();
                let there = self.position_rows(evaluator, stated, true, t, &trial);
                if length(&of(&there.values)) < length(&values) * (1.0 - 1e-4 * damping) {
                    break Some((trial, there));
                }
                damping *= 0.5;
                if damping < 1e-6 {
                    break None;
                }
            };
            let Some(next) = next else { break };
            (*q, at) = next;
        }
        largest(&at.values)
    }
}
