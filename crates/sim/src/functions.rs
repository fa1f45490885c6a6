//! The compiled functions of the equations of motion, each by itself, for those who control,
//! optimise or integrate with their own means.
//!
//! ```text
//! M(q) v̇ + G(t, q)ᵀ λ = f(t, q, v)     nq rows, N or N m
//! g(t, q) = 0                          nc rows, m or rad
//! ```
//!
//! Matrices are dense and written row by row. Kinks of loads and drives take the branch of each state; modes of
//! stops and friction are those of open contacts.

use bksim_dae::NotFinite;

use crate::compiled::CompiledSystem;
use crate::evaluator::{ConstraintsAt, Evaluator, EvaluatorBuffers};
use crate::modes::Modes;
use crate::multiplier::MultiplierSystem;
use crate::state::{AccelerationRef, StateRef};

/// The functions at one set of parameters, with their buffers.
#[derive(Clone, Debug)]
pub struct Functions<'a> {
    compiled: &'a CompiledSystem,
    evaluator: Evaluator<'a>,
    multipliers: MultiplierSystem,
    parameters: Vec<f64>,
    /// The branches that the evaluator takes.
    modes: Modes,
    nq: usize,
    nc: usize,
    /// No velocities.
    rest: Vec<f64>,
}

/// [`Functions`] between two uses: without their system, so that an owner of both keeps them.
#[derive(Clone, Debug)]
pub struct IdleFunctions {
    buffers: EvaluatorBuffers,
    multipliers: MultiplierSystem,
    parameters: Vec<f64>,
    modes: Modes,
    rest: Vec<f64>,
}

impl IdleFunctions {
    /// The functions again.
    ///
    /// # Panics
    /// Calls panic if `compiled` is another system than they were of.
    pub fn resume(self, compiled: &CompiledSystem) -> Functions<'_> {
        let Self { buffers, multipliers, parameters, modes, rest } = self;
        Functions {
            compiled,
            evaluator: Evaluator::with_buffers(compiled, buffers),
            multipliers,
            parameters,
            modes,
            nq: compiled.nq(),
            nc: compiled.nc(),
            rest,
        }
    }
}

impl<'a> Functions<'a> {
    /// The functions at these parameters; the constraint rows `dependent` follow from the others.
    pub fn new(compiled: &'a CompiledSystem, parameters: &[f64], dependent: &[usize]) -> Self {
        Self {
            compiled,
            parameters: parameters.to_vec(),
            modes: compiled.indicators.idle(),
            evaluator: compiled.evaluator(parameters),
            multipliers: compiled.multiplier_system(dependent),
            nq: compiled.nq(),
            nc: compiled.nc(),
            rest: vec![0.0; compiled.nq()],
        }
    }

    /// The functions until they are used again: nothing is made again.
    pub fn pause(self) -> IdleFunctions {
        let Self { evaluator, multipliers, parameters, modes, rest, .. } = self;
        IdleFunctions { buffers: evaluator.into_buffers(), multipliers, parameters, modes, rest }
    }

    /// The compiled system.
    pub(crate) fn compiled(&self) -> &'a CompiledSystem {
        self.compiled
    }

    /// The modes of the state that they were last at.
    pub(crate) fn modes(&self) -> &Modes {
        &self.modes
    }

    /// The values of the parameters with those modes.
    pub(crate) fn parameters_with_modes(&self) -> Vec<f64> {
        self.modes.parameters_with_modes(&self.parameters)
    }

    /// The inputs at a state, SI.
    pub(crate) fn inputs(&mut self, t: f64, q: &[f64], v: &[f64]) -> &[f64] {
        self.evaluator.inputs(t, q, v)
    }

    /// Takes the branches of a state.
    pub(crate) fn follow(&mut self, t: f64, q: &[f64], v: &[f64]) {
        let Self { compiled, evaluator, parameters, modes, .. } = self;
        if modes.signs.is_empty() {
            return;
        }
        let now = compiled.indicators.decided(modes.held.clone(), parameters, (t, q, v));
        if now != *modes {
            *evaluator = compiled.evaluator(&now.parameters_with_modes(parameters));
            *modes = now;
        }
    }

    fn follow_at_rest(&mut self, t: f64, q: &[f64]) {
        let rest = std::mem::take(&mut self.rest);
        self.follow(t, q, &rest);
        self.rest = rest;
    }

    fn constraints_at(&mut self, t: f64, q: &[f64]) -> ConstraintsAt<'_> {
        self.follow_at_rest(t, q);
        self.evaluator.constraints(t, q)
    }

    /// Writes M(q), nq × nq.
    ///
    /// # Panics
    /// If a length is not that of the mechanism; so for all that follow.
    pub fn mass_matrix_into(&mut self, t: f64, q: &[f64], out: &mut [f64]) {
        assert_eq!(out.len(), self.nq * self.nq, "M is nq × nq");
        out.fill(0.0);
        self.follow_at_rest(t, q);
        let at = self.evaluator.dynamics(t, q, &self.rest);
        for (&(i, j), &m) in at.shape.mass.iter().zip(at.mass) {
            (out[i * self.nq + j], out[j * self.nq + i]) = (m, m);
        }
    }

    /// Writes f(t, q, v), nq: loads, potentials and what velocities make of inertia.
    pub fn force_into(&mut self, t: f64, q: &[f64], v: &[f64], out: &mut [f64]) {
        self.follow(t, q, v);
        out.copy_from_slice(self.evaluator.dynamics(t, q, v).force);
    }

    /// Writes G, nc × nq.
    ///
    /// # Panics
    /// If a length is not that of the mechanism.
    pub fn constraint_jacobian_into(&mut self, t: f64, q: &[f64], out: &mut [f64]) {
        assert_eq!(out.len(), self.nc * self.nq, "G is nc × nq");
        out.fill(0.0);
        let nq = self.nq;
        let at = self.constraints_at(t, q);
        for (&(row, column), &g) in at.shape.jacobian.iter().zip(at.jacobian) {
            out[row * nq + column] = g;
        }
    }

    /// Writes g(t, q), nc.
    pub fn constraints_into(&mut self, t: f64, q: &[f64], out: &mut [f64]) {
        out.copy_from_slice(self.constraints_at(t, q).value);
    }

    /// Writes M v̇ + Gᵀ λ − f, nq rows, and g, nc rows.
    pub fn residual_into(
        &mut self,
        StateRef { t, q, v }: StateRef<'_>,
        AccelerationRef { a, lambda }: AccelerationRef<'_>,
        out: &mut [f64],
    ) {
        let (motion, closure) = out.split_at_mut(self.nq);
        self.follow(t, q, v);
        self.evaluator.press(lambda);
        let at = self.evaluator.dynamics(t, q, v);
        for (row, &f) in motion.iter_mut().zip(at.force) {
            *row = -f;
        }
        for (&(i, j), &m) in at.shape.mass.iter().zip(at.mass) {
            motion[i] += m * a[j];
            if i != j {
                motion[j] += m * a[i];
            }
        }
        for (&(row, column), &g) in at.shape.jacobian.iter().zip(at.jacobian) {
            motion[column] += g * lambda[row];
        }
        self.constraints_into(t, q, closure);
    }

    /// Writes v̇, nq, and λ, nc, which keep the constraints at acceleration level; the smallest
    /// multipliers where they are not unique.
    ///
    /// # Errors
    /// [`NotFinite`] where the equations have no value; both are NaN then.
    pub fn accelerations_into(
        &mut self,
        StateRef { t, q, v }: StateRef<'_>,
        a: &mut [f64],
        lambda: &mut [f64],
    ) -> Result<(), NotFinite> {
        self.follow(t, q, v);
        let Self { evaluator, multipliers, .. } = self;
        let solved = multipliers
            .factor(&evaluator.dynamics(t, q, v))
            .and_then(|()| multipliers.complete_into(evaluator, t, (q, v), a, lambda));
        if solved.is_err() {
            a.fill(f64::NAN);
            lambda.fill(f64::NAN);
        }
        solved
    }
}
