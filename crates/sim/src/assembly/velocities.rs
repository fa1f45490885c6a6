//! Velocities on the constraints: the least change of the guessed ones.

use super::equations::Equations;
use super::{CLOSURE_TOLERANCE, Closing, size};
use crate::evaluator::Evaluator;
use crate::linear::rows::shortest_solution;
use crate::multiplier::largest;
use crate::start_error::{Conflict, StartError};

impl Closing<'_> {
    pub(crate) fn fit_velocities(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        q: &[f64],
    ) -> Result<Vec<f64>, StartError> {
        let stated = self.select(|i| i.measure.is_velocity() && !i.is_guess);
        let guessed = self.select(|i| i.measure.is_velocity() && i.is_guess);
        let zero = vec![0.0; q.len()];
        let wish = self.rows(&guessed, t, q, &zero);
        let missing: Vec<f64> = wish.values.iter().map(|value| -value).collect();
        let guess = shortest_solution(&wish.gradients, &missing);

        let (v, left) = self.velocities(evaluator, &stated, t, q, &guess);
        if left <= CLOSURE_TOLERANCE * size(&v) {
            return Ok(v);
        }
        let (_, without) = self.velocities(evaluator, &[], t, q, &guess);
        if without > CLOSURE_TOLERANCE * size(&v) {
            return Err(match self.of.drives.first() {
                Some(&(_, drive_idx)) => StartError::DriveCannotMove { drive_idx },
                None => StartError::NotFinite { q: q.to_vec(), v },
            });
        }
        let mut conflicts = Vec::new();
        for &k in &stated {
            let others: Vec<usize> = stated.iter().copied().filter(|&o| o != k).collect();
            let (v, left) = self.velocities(evaluator, &others, t, q, &guess);
            let found = self.rows(&[k], t, q, &v).values[0] + self.stated[k];
            let consistent = left <= CLOSURE_TOLERANCE * size(&v);
            conflicts.push(Conflict {
                initial_idx: k,
                stated: self.stated[k],
                consistent: consistent.then_some(found),
            });
        }
        Err(StartError::StatedVelocities { conflicts })
    }

    /// The velocities nearest to `guess` on the constraints and the stated rates, and what is left.
    fn velocities(
        &mut self,
        evaluator: &mut Evaluator,
        stated: &[usize],
        t: f64,
        q: &[f64],
        guess: &[f64],
    ) -> (Vec<f64>, f64) {
        let at_guess = self.rows(stated, t, q, guess);
        let at = evaluator.constraints(t, q);
        let rows = Equations { values: at.rate_of(guess), gradients: at.jacobian_rows() };
        let mut rows = rows.with(&at_guess);
        let shapes = &self.of.shapes[1];
        if !shapes.is_empty() {
            // Beams keep their shapes where the rest can move so.
            let all = rows.gradients.clone();
            rows.gradients.clear_columns(shapes);
            let (v, left) = nearest(&rows, guess);
            if left <= CLOSURE_TOLERANCE * size(&v) {
                return (v, left);
            }
            rows.gradients = all;
        }
        nearest(&rows, guess)
    }
}

/// The velocities nearest to `guess` with which the rows vanish, and what is left.
fn nearest(rows: &Equations, guess: &[f64]) -> (Vec<f64>, f64) {
    let step = shortest_solution(&rows.gradients, &rows.values);
    let done = rows.gradients.times(&step);
    let left: Vec<f64> = rows.values.iter().zip(done).map(|(value, done)| value - done).collect();
    (guess.iter().zip(&step).map(|(v, step)| v - step).collect(), largest(&left))
}
