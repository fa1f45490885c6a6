//! A mechanism in one set of modes, at one state after the other, as dense matrices.

use bksim_dae::{Loader, Saver, SolveError};
use nalgebra::{DMatrix, DVector};

use crate::compiled::CompiledSystem;
use crate::evaluator::Evaluator;
use crate::linear::dense::dependent_rows;
use crate::multiplier::MultiplierSystem;
pub(super) use crate::multiplier::largest;

/// A mechanism whose modes do not change.
pub(crate) struct Frozen<'a> {
    evaluator: Evaluator<'a>,
    /// The multiplier system without some rows, once it has been asked for.
    planned: Option<(Vec<usize>, MultiplierSystem)>,
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

/// Rows that follow from others must agree with them in acceleration to this part of its size.
const AGREEMENT: f64 = 1e-6;
/// Newton steps of a projection.
const CORRECTIONS: usize = 4;

impl<'a> Frozen<'a> {
    /// `parameters` end with the modes.
    pub(crate) fn new(compiled: &'a CompiledSystem, parameters: &[f64]) -> Self {
        Self { evaluator: compiled.evaluator(parameters), planned: None }
    }

    /// What outlives a state.
    pub(crate) fn save(&self, saver: &mut Saver) {
        saver.flag(self.planned.is_some());
        if let Some((_, multipliers)) = &self.planned {
            multipliers.save(saver);
        }
    }

    /// Takes over what was saved in the same modes, without these rows.
    pub(crate) fn load(
        &mut self,
        loader: &mut Loader<'_>,
        dependent: &[usize],
    ) -> Result<(), SolveError> {
        self.planned = None;
        if loader.flag()? {
            let shape = self.evaluator.shape();
            plan(&mut self.planned, &self.evaluator, dependent).load(shape, loader)?;
        }
        Ok(())
    }

    /// M, G, g and ∂g/∂t.
    pub(crate) fn matrices(&mut self, t: f64, q: &[f64], v: &[f64]) -> Matrices {
        let mass = self.evaluator.dynamics(t, q, v).mass_matrix();
        let at = self.evaluator.constraints(t, q);
        Matrices {
            mass,
            jacobian: at.jacobian_rows().dense(),
            constraint: DVector::from_column_slice(at.value),
            rate: DVector::from_column_slice(at.rate),
        }
    }

    /// Rows that are open or follow from others.
    pub(crate) fn dependent(&mut self, t: f64, q: &[f64]) -> Vec<usize> {
        dependent_rows(&self.evaluator.constraints(t, q).jacobian_rows().dense()).dependent
    }

    /// v̇ and λ, the smallest where they are not unique; `None` where there are none, as for rows
    /// that follow from others but ask for another motion.
    pub(crate) fn accelerations(
        &mut self,
        (t, q, v): (f64, &[f64], &[f64]),
        dependent: &[usize],
    ) -> Option<(Vec<f64>, Vec<f64>)> {
        let Self { evaluator, planned } = self;
        let multipliers = plan(planned, evaluator, dependent);
        let shape = evaluator.shape();
        let (mut a, mut lambda) = (vec![0.0; shape.nq], vec![0.0; shape.nc]);
        multipliers.complete_into(evaluator, t, (q, v), &mut a, &mut lambda).ok()?;
        let at = evaluator.dynamics(t, q, v);
        let acceleration = DVector::from_column_slice(&a);
        let left =
            at.jacobian_rows().dense() * &acceleration + DVector::from_column_slice(at.gamma);
        let agree = largest(left.as_slice()) <= AGREEMENT * (1.0 + largest(&a) + largest(at.gamma));
        agree.then_some((a, lambda))
    }

    /// Moves q, then v, onto the rows that hold.
    pub(crate) fn project(&mut self, t: f64, q: &mut [f64], v: &mut [f64], dependent: &[usize]) {
        let Self { evaluator, planned } = self;
        let multipliers = plan(planned, evaluator, dependent);
        // What is not finite here shows in the accelerations.
        if multipliers.factor(&evaluator.dynamics(t, q, v)).is_ok() {
            multipliers.project(evaluator, t, (q, v), CORRECTIONS);
        }
    }
}

fn plan<'p>(
    planned: &'p mut Option<(Vec<usize>, MultiplierSystem)>,
    evaluator: &Evaluator<'_>,
    dependent: &[usize],
) -> &'p mut MultiplierSystem {
    if planned.as_ref().is_none_or(|(without, _)| without != dependent) {
        *planned = None;
    }
    let new = || (dependent.to_vec(), MultiplierSystem::new(evaluator.shape(), dependent));
    &mut planned.get_or_insert_with(new).1
}
