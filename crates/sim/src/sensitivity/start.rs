//! Sensitivities of the consistent start, level by level, as [`crate::start`] finds it.
//!
//! Stated values hold exactly, or change by one where the sensitivity is to them; the rest follows
//! the constraints. Where these leave a choice, positions change by the least amount from the
//! changes of the guesses, and velocities are the nearest to the guessed ones, differentiated.

use nalgebra::{DMatrix, DVector};

use super::direction::Change;
use super::tangent::{Nearest, TangentPoint, Tangents};
use super::{Sensitive, SensitivityEquations, SensitivityError};
use crate::compiled::CompiledSystem;
use crate::linear::dense::least_squares;
use crate::run::StateSensitivity;
use crate::start::Start;
use crate::state::{AccelerationRef, StateRef};
use bksim_model::{Initial, Model};

/// Sensitivities of the start, one per quantity.
///
/// # Errors
/// [`SensitivityError`] when no start exists for other values near these, or a derivative is not
/// finite.
pub fn start(
    equations: &SensitivityEquations,
    model: &Model,
    compiled: &CompiledSystem,
    start: &Start,
    parameters: &[f64],
) -> Result<Vec<StateSensitivity>, SensitivityError> {
    start_by_each(equations, &model.initial, compiled, start, parameters).collect()
}

/// Start ([`start`]), quantity by quantity.
pub(super) fn start_by_each<'a>(
    equations: &'a SensitivityEquations,
    initial: &'a [Initial],
    compiled: &'a CompiledSystem,
    start: &'a Start,
    parameters: &'a [f64],
) -> impl Iterator<Item = Result<StateSensitivity, SensitivityError>> + 'a {
    // Contacts leave the neighbours of a start alone; accelerations follow those that hold.
    let parameters = start.parameters_with_modes(parameters);
    let tangents = Tangents::with_contacts_open(equations, compiled, &parameters, start);
    let held = Tangents::new(equations, compiled, &parameters, start.inactive_rows());
    let Start { t, q, v, a, lambda, .. } = start;
    let state = StateRef { t: *t, q, v };
    let at = TangentPoint { state, acceleration: AccelerationRef { a, lambda } };
    let mut opening = Opening { equations, initial, tangents, held, parameters, at };
    (0..equations.sensitive.len()).map(move |k| opening.by(k))
}

/// The start whose changes are looked for.
struct Opening<'a> {
    equations: &'a SensitivityEquations,
    initial: &'a [Initial],
    /// With all contacts open, and as they are.
    tangents: Tangents<'a>,
    held: Tangents<'a>,
    parameters: Vec<f64>,
    at: TangentPoint<'a>,
}

/// Some initial values: what they measure less what is stated, its change, the gradient of the
/// measure, its change.
struct Measured {
    off: DVector<f64>,
    change: DVector<f64>,
    gradient: DMatrix<f64>,
    turned: DMatrix<f64>,
}

impl Opening<'_> {
    fn by(&mut self, k: usize) -> Result<StateSensitivity, SensitivityError> {
        let by = self.equations.sensitive[k];
        let dq = self.positions(k)?;
        let dv = self.velocities(k, dq.as_slice())?;
        let change = self.equations.change(k);
        let (dq, dv) = (dq.as_slice(), dv.as_slice());
        let mut offset = vec![0.0; self.at.acceleration.lambda.len()];
        if !self.held.take_offset(self.at, change, dq, &mut offset) {
            return Err(SensitivityError::Touching(by));
        }
        self.held
            .complete(self.at, (change, &offset), (dq, dv))
            .map_err(|_| SensitivityError::NotFinite(by))
    }

    fn positions(&mut self, k: usize) -> Result<DVector<f64>, SensitivityError> {
        let (at, nq) = (self.at, self.at.state.q.len());
        let zero = vec![0.0; nq];
        let all = self.measured(k, |i| !i.measure.is_velocity(), at.state.v, &zero);
        let stated =
            self.measured(k, |i| !i.measure.is_velocity() && !i.is_guess, at.state.v, &zero);

        // Towards all stated and guessed values, then onto the constraints.
        let (target, _) = least_squares(&all.gradient, &-all.change);
        let gap = self.tangents.of_positions(at, self.equations.change(k), &zero).to_vec();
        let jacobian = self.tangents.jacobian_at(at);
        let rows = below(&jacobian, &stated.gradient);
        let nearest = Nearest {
            turned: DMatrix::zeros(rows.nrows(), nq),
            residual: joined(&gap, &stated.change),
            rows,
        };
        self.checked(k, &nearest, nearest.change(&DVector::zeros(nq), &target))
    }

    fn velocities(&mut self, k: usize, dq: &[f64]) -> Result<DVector<f64>, SensitivityError> {
        let (at, nq) = (self.at, self.at.state.q.len());
        let zero = vec![0.0; nq];
        let is_guess = |i: &Initial| i.measure.is_velocity() && i.is_guess;

        // The guessed velocities are the smallest ones with the guessed rates.
        let at_rest = self.measured(k, is_guess, &zero, dq);
        let (guess, _) = least_squares(&at_rest.gradient, &-at_rest.off);
        let Measured { gradient, turned, change, .. } =
            self.measured(k, is_guess, guess.as_slice(), dq);
        let target = Nearest { rows: gradient, turned, residual: change };
        let target = target.change(&guess, &DVector::zeros(nq));

        let stated = self.measured(k, |i| i.measure.is_velocity() && !i.is_guess, at.state.v, dq);
        let gap = self.tangents.of_velocities(at, self.equations.change(k), (dq, &zero)).to_vec();
        let jacobian = self.tangents.jacobian_at(at);
        let nearest = Nearest {
            rows: below(&jacobian, &stated.gradient),
            turned: below(
                &self.tangents.of_jacobian(at, self.equations.change(k), dq),
                &stated.turned,
            ),
            residual: joined(&gap, &stated.change),
        };
        let moved = DVector::from_column_slice(at.state.v) - guess;
        self.checked(k, &nearest, nearest.change(&moved, &target))
    }

    fn checked(
        &self,
        k: usize,
        nearest: &Nearest,
        dx: DVector<f64>,
    ) -> Result<DVector<f64>, SensitivityError> {
        let by = self.equations.sensitive[k];
        if dx.iter().any(|value| !value.is_finite()) {
            return Err(SensitivityError::NotFinite(by));
        }
        let v = self.at.state.v.iter().fold(0.0, |largest: f64, v| largest.max(v.abs()));
        if nearest.is_met_by(&dx, v) { Ok(dx) } else { Err(SensitivityError::NoNeighbour(by)) }
    }

    /// The initial values that `which` selects, at velocities `v`, along ∂q and p_k.
    fn measured(
        &self,
        k: usize,
        which: impl Fn(&Initial) -> bool,
        v: &[f64],
        dq: &[f64],
    ) -> Measured {
        let (at, nq) = (self.at, dq.len());
        let zero = vec![0.0; nq];
        let function = &self.equations.closing;
        let mut buffers = function.buffers(&self.parameters[..]);
        let Change { dt, dp } = self.equations.change(k);
        let arguments = [&[at.state.t], at.state.q, v, &[dt], dq, &zero, dp];
        let outputs = function.evaluate(&mut buffers, &arguments);
        let by_initial = outputs.chunks_exact(4 + 2 * nq).enumerate();
        let chosen: Vec<(usize, &[f64])> =
            by_initial.filter(|&(i, _)| which(&self.initial[i])).collect();
        let n = chosen.len();
        let stated_change =
            |i: usize| f64::from(u8::from(self.equations.sensitive[k] == Sensitive::Initial(i)));
        Measured {
            off: DVector::from_fn(n, |row, _| chosen[row].1[0] - chosen[row].1[1]),
            change: DVector::from_fn(n, |row, _| {
                let (i, numbers) = chosen[row];
                numbers[2] - numbers[3] - stated_change(i)
            }),
            gradient: DMatrix::from_fn(n, nq, |row, col| chosen[row].1[4 + col]),
            turned: DMatrix::from_fn(n, nq, |row, col| chosen[row].1[4 + nq + col]),
        }
    }
}

fn below(above: &DMatrix<f64>, rows: &DMatrix<f64>) -> DMatrix<f64> {
    let n = above.nrows();
    let mut all = DMatrix::zeros(n + rows.nrows(), above.ncols());
    all.rows_mut(0, n).copy_from(above);
    all.rows_mut(n, rows.nrows()).copy_from(rows);
    all
}

fn joined(above: &[f64], below: &DVector<f64>) -> DVector<f64> {
    DVector::from_iterator(above.len() + below.len(), above.iter().chain(below.iter()).copied())
}
