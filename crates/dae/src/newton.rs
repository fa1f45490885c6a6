//! Simplified Newton iteration on the stage equations.
//!
//! ```text
//! 0 = F(t + c_i h, y + z_i, (1/h) Σ_j (A⁻¹)_ij z_j),   i = 1 … s       stages
//! Z = T W,  A⁻¹ = T Λ T⁻¹                                              HW2 §IV.8, the linear system
//! ((λ_k/h) ∂F/∂y′ + ∂F/∂y) ΔW_k = −(T⁻¹ F)_k                           one system per eigenvalue
//! ```
//!
//! Corrections are judged as `ΔZ`: `T⁻¹` is large for seven stages, and a norm of `ΔW` would
//! mistake rounding for divergence. Working with increments `z_i = Y_i − y` keeps rounding small
//! (HW2 §IV.8). The Jacobian is frozen, so `F` may be nonlinear in `y′` too.

use crate::contraction::{Contraction, Progress};
use crate::error::Cause;
use crate::iteration_matrix::IterationMatrix;
use crate::lanes::multiply_blocks;
use crate::limits::first_not_finite;
use crate::scale::Scale;
use crate::stats::Stats;
use crate::system::System;
use crate::tableau::Tableau;

/// Start and size of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point<'a> {
    pub(crate) t: f64,
    pub(crate) h: f64,
    pub(crate) y: &'a [f64],
    /// Derivative at `t`, from the last step or the caller.
    pub(crate) ydot: &'a [f64],
}

/// Buffers of one step, allocated once. Stage vectors follow each other, `s n` numbers.
pub(crate) struct NewtonWork {
    /// Stage increments `Z`.
    pub(crate) z: Vec<f64>,
    /// Corrections `−ΔZ` of the last iteration.
    pub(crate) delta: Vec<f64>,
    /// Derivatives of the stages, then transformed residuals `T⁻¹ F`, then corrections `−ΔW`.
    transformed: Vec<f64>,
    /// Residuals of the stages.
    pub(crate) defect: Vec<f64>,
    /// State and derivative at one instant.
    pub(crate) y_stage: Vec<f64>,
    pub(crate) ydot_stage: Vec<f64>,
    /// Estimate of the local error.
    pub(crate) error: Vec<f64>,
    pub(crate) scale: Scale,
    pub(crate) contraction: Contraction,
}

/// Cause of a failed iteration, and the cut of the step size that might help.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct NewtonFailure {
    pub(crate) cause: Cause,
    pub(crate) shrink: f64,
}

impl NewtonWork {
    pub(crate) fn new(n: usize, s: usize, contraction: Contraction) -> Self {
        Self {
            z: vec![0.0; s * n],
            delta: vec![0.0; s * n],
            transformed: vec![0.0; s * n],
            defect: vec![0.0; s * n],
            y_stage: vec![0.0; n],
            ydot_stage: vec![0.0; n],
            error: vec![0.0; n],
            scale: Scale::new(n),
            contraction,
        }
    }

    /// Resizes the buffers to `s` stages; those that once held more are not allocated again.
    pub(crate) fn set_stages(&mut self, s: usize, contraction: Contraction) {
        let n = self.y_stage.len();
        for buffer in [&mut self.z, &mut self.delta, &mut self.transformed, &mut self.defect] {
            buffer.resize(s * n, 0.0);
        }
        self.contraction = contraction;
    }

    /// Iterates from the starting values in `z` until they solve the stage equations.
    pub(crate) fn solve<S: System>(
        &mut self,
        system: &mut S,
        at: Point<'_>,
        tableau: &Tableau,
        matrix: &mut IterationMatrix,
        stats: &mut Stats,
    ) -> Result<(), NewtonFailure> {
        let n = at.y.len();
        if n == 0 {
            return Ok(());
        }
        loop {
            self.residuals_into_defect(system, at, tableau, stats)?;
            multiply_blocks(&tableau.t_inv, 1.0, n, &self.defect, &mut self.transformed);
            matrix.solve_all(n, &mut self.transformed);
            multiply_blocks(&tableau.t, 1.0, n, &self.transformed, &mut self.delta);
            stats.n_solve += 1;
            stats.n_newton += 1;

            for (z, delta) in self.z.iter_mut().zip(&self.delta) {
                *z -= delta;
            }
            match self.contraction.observe(self.scale.rms_tested(&self.delta)) {
                Progress::Continue => (),
                Progress::Converged => return Ok(()),
                // The rate already predicts failure: stop before paying for more iterations.
                Progress::Hopeless { shrink } => {
                    let is_finite = self.delta.iter().all(|x| x.is_finite());
                    let cause = if is_finite { Cause::Newton } else { Cause::Singular };
                    return Err(NewtonFailure { cause, shrink });
                }
            }
        }
    }

    /// `F` at every stage.
    fn residuals_into_defect<S: System>(
        &mut self,
        system: &mut S,
        at: Point<'_>,
        tableau: &Tableau,
        stats: &mut Stats,
    ) -> Result<(), NewtonFailure> {
        let n = at.y.len();
        // The derivatives of all stages; the transformed residuals are not needed any more.
        multiply_blocks(&tableau.a_inv, 1.0 / at.h, n, &self.z, &mut self.transformed);
        let stages = self.z.chunks_exact(n).zip(self.transformed.chunks_exact(n));
        for (i, ((z, ydot), out)) in stages.zip(self.defect.chunks_exact_mut(n)).enumerate() {
            for (stage, (y, z)) in self.y_stage.iter_mut().zip(at.y.iter().zip(z)) {
                *stage = y + z;
            }
            let t = at.t + tableau.c[i] * at.h;
            stats.n_residual += 1;
            let row = match system.residual(t, &self.y_stage, ydot, out) {
                Ok(()) => first_not_finite(out),
                Err(not_finite) => Some(not_finite.row),
            };
            if let Some(row) = row {
                return Err(NewtonFailure { cause: Cause::NotFinite { row }, shrink: 0.5 });
            }
        }
        Ok(())
    }

    /// State and derivative at the end of the step, which is its last stage, from `z`.
    pub(crate) fn load_end(&mut self, at: Point<'_>, tableau: &Tableau) {
        let (n, s) = (at.y.len(), tableau.s);
        let i = s - 1;
        let own = &self.z[i * n..];
        for (stage, (y, z)) in self.y_stage.iter_mut().zip(at.y.iter().zip(own)) {
            *stage = y + z;
        }
        self.ydot_stage.fill(0.0);
        for j in 0..s {
            let factor = tableau.a_inv[i * s + j] / at.h;
            for (ydot, z) in self.ydot_stage.iter_mut().zip(&self.z[j * n..(j + 1) * n]) {
                *ydot += factor * z;
            }
        }
    }
}
