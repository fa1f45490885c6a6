//! [`FixedModes`]: a mechanism in one set of modes, at one state after the other.
//!
//! ```text
//! M v̇ + Gᵀ λ = f        G v̇ + γ = 0        active rows of G alone
//! ```

use bksim_dae::{Loader, Saver, SolveError};

use super::consistent::NoConsistentModes;
use crate::compiled::CompiledSystem;
use crate::evaluator::Evaluator;
use crate::linear::matrix::Matrix;
use crate::linear::rank::dependent_rows;
use crate::linear::rows::SparseRows;
use crate::multiplier::{MultiplierSystem, largest};
use crate::state::Acceleration;

/// A mechanism whose modes do not change, with its buffers.
pub(crate) struct FixedModes<'a> {
    evaluator: Evaluator<'a>,
    /// The multiplier system without its inactive rows, once it has been asked for.
    solver: Option<ActiveRows>,
    acceleration: Acceleration,
    /// G v̇ + γ of every row.
    residual: Vec<f64>,
}

/// The multiplier system of some rows.
struct ActiveRows {
    inactive: Vec<usize>,
    multipliers: MultiplierSystem,
}

/// M, G and ∂g/∂t at one state.
pub(crate) struct Matrices {
    /// nq × nq.
    pub(crate) mass: Matrix,
    /// nc × nq.
    pub(crate) jacobian: SparseRows,
    /// ∂g/∂t, nc.
    pub(crate) rate: Vec<f64>,
}

/// Rows that follow from others must agree with them in acceleration to this part of its size.
const AGREEMENT: f64 = 1e-6;
/// A drive may jump by this part of the size of the state before it counts as a jump.
pub(super) const JUMP: f64 = 1e-6;
/// Newton steps of a projection.
const CORRECTIONS: usize = 4;

impl<'a> FixedModes<'a> {
    /// `parameters` end with the modes.
    pub(crate) fn new(compiled: &'a CompiledSystem, parameters: &[f64]) -> Self {
        Self {
            evaluator: compiled.evaluator(parameters),
            solver: None,
            acceleration: Acceleration::zeros(compiled.nq(), compiled.nc()),
            residual: vec![0.0; compiled.nc()],
        }
    }

    /// Saves the numbers that outlive a state.
    pub(crate) fn save(&self, saver: &mut Saver) {
        saver.flag(self.solver.is_some());
        if let Some(ActiveRows { multipliers, .. }) = &self.solver {
            multipliers.save(saver);
        }
    }

    /// Takes over the numbers that were saved in the same modes, without these rows.
    pub(crate) fn load(
        &mut self,
        loader: &mut Loader<'_>,
        inactive: &[usize],
    ) -> Result<(), SolveError> {
        self.solver = None;
        if loader.flag()? {
            let shape = self.evaluator.shape();
            solver_without(inactive, &mut self.solver, &self.evaluator).load(shape, loader)?;
        }
        Ok(())
    }

    /// M, G and ∂g/∂t at a state.
    pub(crate) fn matrices(&mut self, t: f64, q: &[f64], v: &[f64]) -> Matrices {
        let mass = self.evaluator.dynamics(t, q, v).mass();
        let constraints = self.evaluator.constraints(t, q);
        let (jacobian, rate) = (constraints.jacobian_rows(), constraints.rate.to_vec());
        Matrices { mass, jacobian, rate }
    }

    /// g at a position: how far each row is from being satisfied, m or rad.
    pub(crate) fn gaps(&mut self, t: f64, q: &[f64]) -> &[f64] {
        self.evaluator.constraints(t, q).value
    }

    /// Rows of open contacts, and rows that follow from others.
    pub(crate) fn inactive_rows(&mut self, t: f64, q: &[f64]) -> Vec<usize> {
        dependent_rows(&self.evaluator.constraints(t, q).jacobian_rows()).dependent
    }

    /// v̇ and λ, the smallest where they are not unique; `None` where there are none, as for rows
    /// that follow from others but ask for another motion.
    pub(crate) fn acceleration(
        &mut self,
        (t, q, v): (f64, &[f64], &[f64]),
        inactive: &[usize],
    ) -> Option<&Acceleration> {
        let Self { evaluator, solver, acceleration, residual } = self;
        let Acceleration { a, lambda } = acceleration;
        let multipliers = solver_without(inactive, solver, evaluator);
        multipliers.complete_into(evaluator, t, (q, v), a, lambda).ok()?;
        let at = evaluator.dynamics(t, q, v);
        at.acceleration_residual_into(a, residual);
        let size = 1.0 + largest(a) + largest(at.gamma);
        let agree = largest(residual) <= AGREEMENT * size;
        agree.then_some(&self.acceleration)
    }

    /// Rounding of accelerations: of those that the forces would give with all rows open.
    pub(crate) fn noise(&mut self, (t, q, v): (f64, &[f64], &[f64])) -> f64 {
        const BITS: f64 = 64.0 * f64::EPSILON;
        let at = self.evaluator.dynamics(t, q, v);
        let own = at.shape.mass.iter().zip(at.mass).filter(|((i, j), m)| i == j && **m > 0.0);
        BITS * own.fold(0.0, |most: f64, (&(i, _), m)| most.max((at.force[i] / m).abs()))
    }

    /// Moves q, then v, onto the active rows.
    pub(crate) fn project(&mut self, t: f64, q: &mut [f64], v: &mut [f64], inactive: &[usize]) {
        let Self { evaluator, solver, .. } = self;
        let multipliers = solver_without(inactive, solver, evaluator);
        // A state that is not finite here shows in the accelerations.
        if multipliers.factor(&evaluator.dynamics(t, q, v)).is_ok() {
            multipliers.project(evaluator, t, (q, v), CORRECTIONS);
        }
    }

    /// Moves q onto all active rows, which must be near.
    ///
    /// # Errors
    /// [`NoConsistentModes::Jump`] where they are not.
    pub(super) fn put_onto_rows(
        &mut self,
        t: f64,
        q: &mut [f64],
        v: &[f64],
    ) -> Result<(), NoConsistentModes> {
        let gaps = self.gaps(t, q).iter().map(|g| g.abs()).enumerate();
        let worst = gaps.max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((row, by)) = worst.filter(|(_, by)| *by > JUMP * largest(q).max(1.0)) {
            return Err(NoConsistentModes::Jump { row, by });
        }
        let inactive = self.inactive_rows(t, q);
        self.project(t, q, &mut v.to_vec(), &inactive);
        Ok(())
    }
}

/// The multiplier system without the `inactive` rows: the one there is, if it is that.
fn solver_without<'s>(
    inactive: &[usize],
    solver: &'s mut Option<ActiveRows>,
    evaluator: &Evaluator<'_>,
) -> &'s mut MultiplierSystem {
    if solver.as_ref().is_none_or(|known| known.inactive != inactive) {
        *solver = None;
    }
    let new = || ActiveRows {
        inactive: inactive.to_vec(),
        multipliers: evaluator.system().multiplier_system(inactive),
    };
    &mut solver.get_or_insert_with(new).multipliers
}
