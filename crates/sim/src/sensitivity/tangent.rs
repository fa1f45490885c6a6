//! Changes of the state that satisfy the differentiated equations, level by level.

use bksim_dae::NotFinite;
use nalgebra::{DMatrix, DVector};

use super::SensitivityEquations;
use super::direction::Change;
use crate::compiled::CompiledSystem;
use crate::evaluator::{ConstraintsAt, DynamicsAt, Evaluator};
use crate::function::Buffers;
use crate::linear::dense::least_squares;
use crate::linear::rank::dependent_rows;
use crate::modes::{ContactMode, Modes};
use crate::multiplier::MultiplierSystem;
use crate::run::StateSensitivity;
use crate::start::Start;
use crate::state::{AccelerationRef, StateRef};

/// State, accelerations and multipliers at which equations are differentiated.
#[derive(Clone, Copy)]
pub(super) struct TangentPoint<'a> {
    pub(super) state: StateRef<'a>,
    pub(super) acceleration: AccelerationRef<'a>,
}

impl TangentPoint<'_> {
    /// The arguments of functions of a point and of changes of everything there.
    pub(super) fn arguments(
        &self,
        change: Change<'_>,
        (dq, dv): (&[f64], &[f64]),
        (da, dlambda): (&[f64], &[f64]),
    ) -> Vec<f64> {
        let StateRef { t, q, v } = self.state;
        let AccelerationRef { a, lambda } = self.acceleration;
        let Change { dt, dp } = change;
        [&[t], q, v, a, lambda, &[dt], dq, dv, dp, da, dlambda].concat()
    }
}

/// The differentiated equations at one set of parameters, with their buffers.
pub(super) struct Tangents<'a> {
    equations: &'a SensitivityEquations,
    evaluator: Evaluator<'a>,
    multipliers: MultiplierSystem,
    /// True where the factors of a state are kept until the next one is prepared, and serve well.
    is_prepared: bool,
    /// Rows of friction that sticks, and of stops that are closed.
    sticking: Vec<usize>,
    closed: Vec<usize>,
    levels: Buffers,
    jacobian: Buffers,
    /// Changes of g, of G v + ∂g/∂t, of M a + Gᵀ λ − f and of G a + γ.
    changes: Vec<f64>,
}

/// Factors with a margin above this need no refinement.
const WELL_POSED: f64 = 1e-5;

impl<'a> Tangents<'a> {
    /// At parameters that end with the modes, without rows that depend on others or belong to open contacts.
    pub(super) fn new(
        equations: &'a SensitivityEquations,
        compiled: &'a CompiledSystem,
        parameters: &[f64],
        dependent: &[usize],
    ) -> Self {
        let numbers = &parameters[compiled.n_parameters..];
        let modes = compiled.indicators.modes_from_numbers(numbers).unwrap_or_default();
        let rows = |is_it: fn(ContactMode) -> bool| -> Vec<usize> {
            let contacts = compiled.indicators.contacts.iter().zip(&modes.contacts);
            contacts.filter(|&(_, &mode)| is_it(mode)).map(|(contact, _)| contact.row).collect()
        };
        Self {
            evaluator: compiled.evaluator(parameters),
            multipliers: compiled.multiplier_system(dependent),
            is_prepared: false,
            sticking: rows(|mode| matches!(mode, ContactMode::Stick(_))),
            closed: rows(|mode| mode == ContactMode::Closed),
            levels: equations.levels.buffers(parameters),
            jacobian: equations.jacobian.buffers(parameters),
            changes: vec![0.0; equations.levels.n_outputs()],
            equations,
        }
    }

    /// At the state of a start, with its contacts open.
    pub(super) fn with_contacts_open(
        equations: &'a SensitivityEquations,
        compiled: &'a CompiledSystem,
        parameters: &[f64],
        start: &Start,
    ) -> Self {
        if compiled.indicators.contacts.is_empty() {
            return Self::new(equations, compiled, parameters, start.inactive_rows());
        }
        let idle = compiled.indicators.idle().contacts;
        let open = Modes { contacts: idle, ..start.modes.clone() };
        let open = open.parameters_with_modes(&parameters[..compiled.n_parameters]);
        let mut evaluator = compiled.evaluator(&open);
        let rows = evaluator.constraints(start.t, &start.q).jacobian_rows();
        Self::new(equations, compiled, &open, &dependent_rows(&rows).dependent)
    }

    /// Change of g along ∂q, t and the parameters.
    pub(super) fn of_positions(
        &mut self,
        at: TangentPoint<'_>,
        change: Change<'_>,
        dq: &[f64],
    ) -> &[f64] {
        let zero = vec![0.0; dq.len()];
        self.evaluate(at, change, dq, &zero);
        &self.changes[..at.acceleration.lambda.len()]
    }

    /// Change of G v + ∂g/∂t along ∂q, ∂v, t and the parameters.
    pub(super) fn of_velocities(
        &mut self,
        at: TangentPoint<'_>,
        change: Change<'_>,
        (dq, dv): (&[f64], &[f64]),
    ) -> &[f64] {
        self.evaluate(at, change, dq, dv);
        let nc = at.acceleration.lambda.len();
        &self.changes[nc..2 * nc]
    }

    /// Change of M a + Gᵀ λ − f along ∂q, ∂v, t and the parameters, with a and λ held.
    pub(super) fn of_forces(
        &mut self,
        at: TangentPoint<'_>,
        change: Change<'_>,
        (dq, dv): (&[f64], &[f64]),
    ) -> &[f64] {
        self.evaluate(at, change, dq, dv);
        let nc = at.acceleration.lambda.len();
        &self.changes[2 * nc..2 * nc + dq.len()]
    }

    fn evaluate(&mut self, at: TangentPoint<'_>, change: Change<'_>, dq: &[f64], dv: &[f64]) {
        let StateRef { t, q, v } = at.state;
        let AccelerationRef { a, lambda } = at.acceleration;
        let Change { dt, dp } = change;
        let arguments = [&[t], q, v, a, lambda, &[dt], dq, dv, dp];
        self.equations.levels.evaluate_into(&mut self.levels, &arguments, &mut self.changes);
    }

    /// Takes what the rows of friction that sticks lack to their position, as an offset that stays: where it sticks
    /// changes with everything else. False where the gap of a closed stop changes.
    pub(super) fn take_offset(
        &mut self,
        at: TangentPoint<'_>,
        change: Change<'_>,
        dq: &[f64],
        offset: &mut [f64],
    ) -> bool {
        /// Part of a change that is rounding.
        const ROUNDING: f64 = 1e-6;
        if self.sticking.is_empty() && self.closed.is_empty() {
            return true;
        }
        let gaps = self.of_positions(at, change, dq).to_vec();
        self.sticking.iter().for_each(|&row| offset[row] = gaps[row]);
        let size = dq.iter().fold(f64::MIN_POSITIVE, |size: f64, dq| size.max(dq.abs()));
        self.closed.iter().all(|&row| gaps[row].abs() <= ROUNDING * size)
    }

    /// Change of G along ∂q, t and the parameters.
    pub(super) fn of_jacobian(
        &mut self,
        at: TangentPoint<'_>,
        change: Change<'_>,
        dq: &[f64],
    ) -> DMatrix<f64> {
        let SensitivityEquations { jacobian, cells, .. } = self.equations;
        let arguments = [&[at.state.t], at.state.q, &[change.dt], dq, change.dp];
        let values = jacobian.evaluate(&mut self.jacobian, &arguments);
        dense((at.acceleration.lambda.len(), dq.len()), cells, values)
    }

    /// True where rows of friction that sticks hold: they keep a place that changes.
    pub(super) fn has_sticking(&self) -> bool {
        !self.sticking.is_empty()
    }

    /// True where no rows hold.
    pub(super) fn is_free(&self) -> bool {
        self.multipliers.active_rows().is_empty()
    }

    /// M at a state.
    pub(super) fn mass_at(&mut self, state: StateRef<'_>) -> DMatrix<f64> {
        self.evaluator.dynamics(state.t, state.q, state.v).mass_matrix()
    }

    /// G at a state.
    pub(super) fn jacobian_at(&mut self, at: TangentPoint<'_>) -> DMatrix<f64> {
        let ConstraintsAt { shape, jacobian, .. } =
            self.evaluator.constraints(at.state.t, at.state.q);
        dense((shape.nc, shape.nq), &shape.jacobian, jacobian)
    }

    /// Factors the equations at a state whose changes by several quantities are looked for.
    ///
    /// # Errors
    /// [`NotFinite`] when the state has no finite values.
    pub(super) fn prepare(&mut self, state: StateRef<'_>) -> Result<(), NotFinite> {
        self.multipliers.factor(&self.evaluator.dynamics(state.t, state.q, state.v))?;
        self.is_prepared = self.multipliers.rank_margin() >= WELL_POSED;
        Ok(())
    }

    /// Takes changes of q and v onto the linearised constraints, whose positions keep `offset`.
    ///
    /// # Errors
    /// [`NotFinite`] when a derivative has no finite value.
    pub(super) fn onto_constraints(
        &mut self,
        at: TangentPoint<'_>,
        (change, offset): (Change<'_>, &[f64]),
        (q, v): (&mut [f64], &mut [f64]),
    ) -> Result<(), NotFinite> {
        if self.multipliers.active_rows().is_empty() {
            return Ok(());
        }
        let (force, mut step) = (vec![0.0; q.len()], vec![0.0; q.len()]);

        // Least changes, in the norm of M.
        let mut gap = self.of_positions(at, change, q).to_vec();
        gap.iter_mut().zip(offset).for_each(|(gap, offset)| *gap -= offset);
        self.solve(at, (&force, &gap), &mut step)?;
        q.iter_mut().zip(&step).for_each(|(q, step)| *q += step);
        let gap = self.of_velocities(at, change, (q, v)).to_vec();
        self.solve(at, (&force, &gap), &mut step)?;
        v.iter_mut().zip(&step).for_each(|(v, step)| *v += step);
        Ok(())
    }

    /// The changes of a state that satisfy the differentiated equations, from changes of q and v near them;
    /// positions keep `offset`.
    ///
    /// # Errors
    /// [`NotFinite`] when a derivative has no finite value.
    pub(super) fn complete(
        &mut self,
        at: TangentPoint<'_>,
        (change, offset): (Change<'_>, &[f64]),
        (dq, dv): (&[f64], &[f64]),
    ) -> Result<StateSensitivity, NotFinite> {
        let (nq, nc) = (dq.len(), at.acceleration.lambda.len());
        let (mut q, mut v) = (dq.to_vec(), dv.to_vec());
        self.onto_constraints(at, (change, offset), (&mut q, &mut v))?;

        self.evaluate(at, change, &q, &v);
        let (resisting, gamma) = self.changes[2 * nc..].split_at(nq);
        let (resisting, gamma) = (resisting.to_vec(), gamma.to_vec());
        let force: Vec<f64> = resisting.iter().map(|change| -change).collect();
        let mut a = vec![0.0; nq];
        let mut lambda = self.solve(at, (&force, &gamma), &mut a)?;
        if self.multipliers.active_rows().len() < nc {
            lambda = self.smallest_multipliers(at, change, &q, &resisting, &a);
        }
        Ok(StateSensitivity { q, v, a, lambda, channels: Vec::new() })
    }

    /// Solves M x + Gᵀ μ = force, G x = −gap at a state; returns μ.
    fn solve(
        &mut self,
        at: TangentPoint<'_>,
        (force, gap): (&[f64], &[f64]),
        x: &mut [f64],
    ) -> Result<Vec<f64>, NotFinite> {
        let mut multipliers = vec![0.0; gap.len()];
        if self.is_prepared {
            self.multipliers.solve_with_factors((force, gap), x, &mut multipliers)?;
            return Ok(multipliers);
        }
        let dynamics = self.evaluator.dynamics(at.state.t, at.state.q, at.state.v);
        let system = DynamicsAt { force, gamma: gap, ..dynamics };
        self.multipliers.solved_into(&system, x, &mut multipliers)?;
        Ok(multipliers)
    }

    /// Change of the smallest λ with Gᵀ λ = f − M a.
    fn smallest_multipliers(
        &mut self,
        at: TangentPoint<'_>,
        change: Change<'_>,
        dq: &[f64],
        resisting: &[f64],
        da: &[f64],
    ) -> Vec<f64> {
        let rows = self.jacobian_at(at).transpose();
        let turned = self.of_jacobian(at, change, dq).transpose();
        let dynamics = self.evaluator.dynamics(at.state.t, at.state.q, at.state.v);
        let inertia = dynamics.mass_matrix() * DVector::from_column_slice(da);
        let nearest =
            Nearest { rows, turned, residual: DVector::from_column_slice(resisting) + inertia };
        let lambda = DVector::from_column_slice(at.acceleration.lambda);
        nearest.change(&lambda, &DVector::zeros(lambda.len())).as_slice().to_vec()
    }
}

fn dense(size: (usize, usize), entries: &[(usize, usize)], values: &[f64]) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(size.0, size.1);
    entries.iter().zip(values).for_each(|(&entry, &value)| matrix[entry] = value);
    matrix
}

/// How the solution x of R x + r = 0 that is nearest to x₀ changes with R, r and x₀:
///
/// ```text
/// x = x₀ + Rᵀ w        dx = dx₀ + dRᵀ w + Rᵀ dw        R dx + (dR x + dr) = 0
/// ```
pub(super) struct Nearest {
    /// R.
    pub(super) rows: DMatrix<f64>,
    /// dR.
    pub(super) turned: DMatrix<f64>,
    /// dR x + dr.
    pub(super) residual: DVector<f64>,
}

impl Nearest {
    /// dx for the distance x − x₀ and dx₀.
    pub(super) fn change(&self, distance: &DVector<f64>, dx0: &DVector<f64>) -> DVector<f64> {
        let (w, _) = least_squares(&self.rows.transpose(), distance);
        let free = dx0 + self.turned.transpose() * w;
        let (step, _) = least_squares(&self.rows, &(&self.rows * &free + &self.residual));
        free - step
    }

    /// True if R dx + (dR x + dr) = 0 has a solution, and dx is one; the largest of x is `x`.
    pub(super) fn is_met_by(&self, dx: &DVector<f64>, x: f64) -> bool {
        /// Rounding and the closure of the start leave less.
        const TOLERANCE: f64 = 1e-7;
        // In dR x large terms may cancel: of velocities that do not change, rounding is left.
        let changes = dx.amax() * self.rows.amax() + self.turned.amax() * x;
        let size = changes + self.residual.amax();
        let left = &self.rows * dx + &self.residual;
        left.is_empty() || left.amax() <= TOLERANCE * size
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x(s) nearest to x₀(s) = (1 + s, s) on (1, s) x = 2 + s: differences agree with the derivative.
    #[test]
    fn the_nearest_solution_changes_as_its_differences() {
        let at = |s: f64| {
            let rows = DMatrix::from_row_slice(1, 2, &[1.0, s]);
            let x0 = DVector::from_vec(vec![1.0 + s, s]);
            let gap = &rows * &x0 - DVector::from_element(1, 2.0 + s);
            (x0.clone(), &x0 - least_squares(&rows, &gap).0)
        };
        let (s, h) = (0.7, 1e-5);
        let (x0, x) = at(s);
        let expected = (at(s + h).1 - at(s - h).1) / (2.0 * h);
        let nearest = Nearest {
            rows: DMatrix::from_row_slice(1, 2, &[1.0, s]),
            turned: DMatrix::from_row_slice(1, 2, &[0.0, 1.0]),
            residual: DVector::from_element(1, x[1] - 1.0),
        };
        let found = nearest.change(&(&x - &x0), &DVector::from_vec(vec![1.0, 1.0]));
        assert!((&found - &expected).amax() < 1e-9, "{found} against {expected}");
        assert!(nearest.is_met_by(&found, 0.0));
        assert!(!nearest.is_met_by(&(found * 2.0), 0.0));
    }
}
