//! Accelerations where loads depend on multipliers.

use bksim_dae::NotFinite;
use nalgebra::{DMatrix, DVector};

use super::{MultiplierSystem, largest, shortest_into};
use crate::evaluator::Evaluator;

/// Newton steps that may be needed; a friction whose sense of load changes takes a few more than others.
const MAX_STEPS: usize = 40;
/// Multipliers found to this part of their size are found.
const FOUND: f64 = 4.0 * f64::EPSILON;
/// Multipliers that no longer get nearer are found too, if they are as near as this.
const NEAR: f64 = 1e-9;
/// Or as near as this part of the forces: all multipliers may be zero at once.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

impl MultiplierSystem {
    /// Solves for the multipliers that loads depend on: those that the system has under these loads.
    ///
    /// The first step takes the loads without them: from there on the friction of a pin, whose slope at zero
    /// has no value, has one.
    ///
    /// # Errors
    /// [`NotFinite`] when an entry, or the solution, is not finite, or the friction is more than any motion can
    /// bear.
    pub(super) fn pressed_into(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        (q, v): (&[f64], &[f64]),
        vdot: &mut [f64],
        lambda: &mut [f64],
    ) -> Result<(), NotFinite> {
        // Inactive rows press nothing, as open contacts.
        let rows = evaluator.pressing_rows();
        let n = rows.len();
        let own: Vec<usize> =
            (0..n).filter(|&k| self.active.binary_search(&rows[k]).is_ok()).collect();
        let own_rows: Vec<usize> = own.iter().map(|&k| rows[k]).collect();
        evaluator.pressing_mut().fill(0.0);
        self.solved_into(&evaluator.dynamics(t, q, v), vdot, lambda)?;
        if own.is_empty() {
            return Ok(());
        }
        evaluator.press(lambda);
        let mut last = f64::INFINITY;
        for _ in 0..MAX_STEPS {
            let at = evaluator.dynamics(t, q, v);
            let force = largest(at.force);
            self.solved_into(&at, vdot, lambda)?;
            let n_own = own.len();
            let found = DVector::from_iterator(n_own, own_rows.iter().map(|&row| lambda[row]));
            let pressing = evaluator.pressing_mut();
            let guess = DVector::from_iterator(n_own, own.iter().map(|&k| pressing[k]));
            let gap = &found - &guess;
            let size = largest(lambda);
            let error = gap.amax();
            let near = (NEAR * size).max(ROUNDING * force);
            if error <= FOUND * size || error >= last && error <= near {
                return Ok(());
            }
            last = error;

            // The change of the multipliers by the loads, then the step.
            let slopes = evaluator.pressing_slopes(t, q, v).iter();
            // A joint that bears nothing has no friction; its slope there has no value.
            let slopes = slopes.map(|slope| if slope.is_finite() { *slope } else { 0.0 });
            let slopes = DMatrix::from_row_iterator(self.nq, n, slopes).select_columns(&own);
            let effect = DMatrix::identity(n_own, n_own) - self.responses(&own_rows, &slopes);
            let Some(change) = effect.lu().solve(&gap) else { break };
            let next = guess + change;
            let pressing = evaluator.pressing_mut();
            own.iter().zip(next.iter()).for_each(|(&k, &next)| pressing[k] = next);
        }
        Err(NotFinite { row: 0 })
    }

    /// The multipliers of some rows by forces, one column after the other; inactive rows have none.
    fn responses(&mut self, rows: &[usize], forces: &DMatrix<f64>) -> DMatrix<f64> {
        let mut responses = DMatrix::zeros(rows.len(), forces.ncols());
        for (column, force) in forces.column_iter().enumerate() {
            self.x[..self.nq].copy_from_slice(force.as_slice());
            self.x[self.nq..].fill(0.0);
            self.solve();
            for (k, row) in rows.iter().enumerate() {
                if let Ok(at) = self.active.binary_search(row) {
                    responses[(k, column)] = self.x[self.nq + at];
                }
            }
        }
        responses
    }
}

/// Makes the smallest multipliers and the friction under them agree, for accelerations that are known; false where no such
/// multipliers balance the loads.
pub(super) fn settles(
    evaluator: &mut Evaluator,
    t: f64,
    (q, v): (&[f64], &[f64]),
    vdot: &[f64],
    lambda: &mut [f64],
) -> bool {
    let mut last = f64::INFINITY;
    for _ in 0..MAX_STEPS {
        evaluator.press(lambda);
        let before = lambda.to_vec();
        let left = shortest_into(&evaluator.dynamics(t, q, v), vdot, lambda);
        let size = largest(lambda);
        let changes = lambda.iter().zip(&before).map(|(now, before)| now - before);
        let change = largest(&changes.collect::<Vec<_>>());
        if change <= FOUND * size || change >= last && change <= NEAR * size {
            return left <= NEAR * size;
        }
        last = change;
    }
    false
}
