//! A mechanism in one set of modes, at one state after the other, as dense matrices.

use nalgebra::{DMatrix, DVector};

use crate::compile::{CompiledSystem, Evaluator};
use crate::linear::{accelerations, dependent_rows, project};

/// A mechanism whose modes do not change.
pub(crate) struct Frozen<'a> {
    evaluator: Evaluator<'a>,
}

/// M, G, g and ∂g/∂t at one state.
pub(crate) struct Matrices {
    /// nq × nq.
    pub(crate) mass: DMatrix<f64>,
    /// nc × nq.
    pub(crate) jacobian: DMatrix<f64>,
    /// nc.
    pub(crate) constraint: DVector<f64>,
    /// nc.
    pub(crate) rate: DVector<f64>,
}

impl<'a> Frozen<'a> {
    /// `parameters` end with the modes.
    pub(crate) fn new(compiled: &'a CompiledSystem, parameters: &[f64]) -> Self {
        Self { evaluator: compiled.evaluator(parameters) }
    }

    /// M, G, g and ∂g/∂t.
    pub(crate) fn matrices(&mut self, t: f64, q: &[f64], v: &[f64]) -> Matrices {
        let at = self.evaluator.dynamics(t, q, v);
        Matrices {
            mass: at.mass.clone(),
            jacobian: at.jacobian.clone(),
            constraint: at.constraint.clone(),
            rate: at.rate.clone(),
        }
    }

    /// Rows that are open or follow from others.
    pub(crate) fn dependent(&mut self, t: f64, q: &[f64], v: &[f64]) -> Vec<usize> {
        dependent_rows(&self.evaluator.dynamics(t, q, v).jacobian).dependent
    }

    /// v̇ and λ, the smallest where they are not unique; `None` where there are none.
    pub(crate) fn accelerations(
        &mut self,
        (t, q, v): (f64, &[f64], &[f64]),
        dependent: &[usize],
    ) -> Option<(Vec<f64>, Vec<f64>)> {
        let found = accelerations(self.evaluator.dynamics(t, q, v), dependent)?;
        Some((found.vdot.as_slice().to_vec(), found.lambda.as_slice().to_vec()))
    }

    /// Moves q, then v, onto the rows that hold.
    pub(crate) fn project(&mut self, t: f64, q: &mut [f64], v: &mut [f64], dependent: &[usize]) {
        project(&mut self.evaluator, t, q, v, dependent);
    }
}

/// Largest magnitude; zero of nothing.
pub(crate) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |size, value| size.max(value.abs()))
}
