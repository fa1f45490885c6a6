//! Changes of the state that satisfy the differentiated equations, level by level.

use bksim_dae::NotFinite;
use nalgebra::{DMatrix, DVector};

use super::SensitivityEquations;
use crate::compiled::CompiledSystem;
use crate::evaluator::{ConstraintsAt, DynamicsAt, Evaluator};
use crate::function::Buffers;
use crate::linear::dense::least_squares;
use crate::multiplier::MultiplierSystem;
use crate::run::StateSensitivity;
use crate::state::{AccelerationRef, StateRef};

/// State, accelerations and multipliers at which equations are differentiated.
#[derive(Clone, Copy)]
pub(super) struct TangentPoint<'a> {
    pub(super) state: StateRef<'a>,
    pub(super) acceleration: AccelerationRef<'a>,
}

/// The differentiated equations at one set of parameters, with their buffers.
pub(super) struct Tangents<'a> {
    equations: &'a SensitivityEquations,
    evaluator: Evaluator<'a>,
    multipliers: MultiplierSystem,
    levels: Buffers,
    jacobian: Buffers,
    /// Changes of g, of G v + ∂g/∂t, of M a + Gᵀ λ − f and of G a + γ.
    changes: Vec<f64>,
}

impl<'a> Tangents<'a> {
    pub(super) fn new(
        equations: &'a SensitivityEquations,
        compiled: &'a CompiledSystem,
        parameters: &[f64],
        dependent: &[usize],
    ) -> Self {
        Self {
            evaluator: compiled.evaluator(parameters),
            multipliers: MultiplierSystem::new(&compiled.shape, dependent),
            levels: equations.levels.buffers(parameters),
            jacobian: equations.jacobian.buffers(parameters),
            changes: vec![0.0; equations.levels.n_outputs()],
            equations,
        }
    }

    /// Change of g along ∂q and p_k.
    pub(super) fn of_positions(&mut self, at: TangentPoint<'_>, k: usize, dq: &[f64]) -> &[f64] {
        let zero = vec![0.0; dq.len()];
        self.evaluate(at, k, dq, &zero);
        &self.changes[..at.acceleration.lambda.len()]
    }

    /// Change of G v + ∂g/∂t along ∂q, ∂v and p_k.
    pub(super) fn of_velocities(
        &mut self,
        at: TangentPoint<'_>,
        k: usize,
        (dq, dv): (&[f64], &[f64]),
    ) -> &[f64] {
        self.evaluate(at, k, dq, dv);
        let nc = at.acceleration.lambda.len();
        &self.changes[nc..2 * nc]
    }

    fn evaluate(&mut self, at: TangentPoint<'_>, k: usize, dq: &[f64], dv: &[f64]) {
        let StateRef { t, q, v } = at.state;
        let AccelerationRef { a, lambda } = at.acceleration;
        let direction = self.equations.direction(k);
        let arguments = [&[t], q, v, a, lambda, dq, dv, direction];
        self.equations.levels.evaluate_into(&mut self.levels, &arguments, &mut self.changes);
    }

    /// Change of G along ∂q and p_k.
    pub(super) fn of_jacobian(
        &mut self,
        at: TangentPoint<'_>,
        k: usize,
        dq: &[f64],
    ) -> DMatrix<f64> {
        let SensitivityEquations { jacobian, cells, .. } = self.equations;
        let arguments = [&[at.state.t], at.state.q, dq, self.equations.direction(k)];
        let values = jacobian.evaluate(&mut self.jacobian, &arguments);
        dense((at.acceleration.lambda.len(), dq.len()), cells, values)
    }

    /// G at a state.
    pub(super) fn jacobian_at(&mut self, at: TangentPoint<'_>) -> DMatrix<f64> {
        let ConstraintsAt { shape, jacobian, .. } =
            self.evaluator.constraints(at.state.t, at.state.q);
        dense((shape.nc, shape.nq), &shape.jacobian, jacobian)
    }

    /// The changes of a state by p_k that satisfy the differentiated equations, from changes of q
    /// and v near them.
    ///
    /// # Errors
    /// [`NotFinite`] when a derivative has no finite value.
    pub(super) fn complete(
        &mut self,
        at: TangentPoint<'_>,
        k: usize,
        (dq, dv): (&[f64], &[f64]),
    ) -> Result<StateSensitivity, NotFinite> {
        let (nq, nc) = (dq.len(), at.acceleration.lambda.len());
        let (mut q, mut v) = (dq.to_vec(), dv.to_vec());
        let (force, mut step) = (vec![0.0; nq], vec![0.0; nq]);

        // Least changes, in the norm of M, onto the linearised constraints.
        let gap = self.of_positions(at, k, &q).to_vec();
        self.solve(at, (&force, &gap), &mut step)?;
        q.iter_mut().zip(&step).for_each(|(q, step)| *q += step);
        let gap = self.of_velocities(at, k, (&q, &v)).to_vec();
        self.solve(at, (&force, &gap), &mut step)?;
        v.iter_mut().zip(&step).for_each(|(v, step)| *v += step);

        self.evaluate(at, k, &q, &v);
        let (resisting, gamma) = self.changes[2 * nc..].split_at(nq);
        let (resisting, gamma) = (resisting.to_vec(), gamma.to_vec());
        let force: Vec<f64> = resisting.iter().map(|change| -change).collect();
        let mut a = step;
        let mut lambda = self.solve(at, (&force, &gamma), &mut a)?;
        if self.multipliers.active_rows().len() < nc {
            lambda = self.smallest_multipliers(at, k, &q, &resisting, &a);
        }
        Ok(StateSensitivity { q, v, a, lambda })
    }

    /// Solves M x + Gᵀ μ = force, G x = −gap at a state; returns μ.
    fn solve(
        &mut self,
        at: TangentPoint<'_>,
        (force, gap): (&[f64], &[f64]),
        x: &mut [f64],
    ) -> Result<Vec<f64>, NotFinite> {
        let dynamics = self.evaluator.dynamics(at.state.t, at.state.q, at.state.v);
        let system = DynamicsAt { force, gamma: gap, ..dynamics };
        let mut multipliers = vec![0.0; gap.len()];
        self.multipliers.solved_into(&system, x, &mut multipliers)?;
        Ok(multipliers)
    }

    /// Change of the smallest λ with Gᵀ λ = f − M a.
    fn smallest_multipliers(
        &mut self,
        at: TangentPoint<'_>,
        k: usize,
        dq: &[f64],
        resisting: &[f64],
        da: &[f64],
    ) -> Vec<f64> {
        let rows = self.jacobian_at(at).transpose();
        let turned = self.of_jacobian(at, k, dq).transpose();
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

    /// Whether R dx + (dR x + dr) = 0 has a solution, and dx is one.
    pub(super) fn is_met_by(&self, dx: &DVector<f64>) -> bool {
        /// Rounding and the closure of the start leave less.
        const TOLERANCE: f64 = 1e-7;
        let size = dx.amax() * self.rows.amax() + self.residual.amax();
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
        assert!(nearest.is_met_by(&found));
        assert!(!nearest.is_met_by(&(found * 2.0)));
    }
}
