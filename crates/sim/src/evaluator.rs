//! The functions of one compiled system at one set of parameters, with their buffers.

use std::sync::Arc;

use nalgebra::DMatrix;

use crate::compiled::CompiledSystem;
use crate::function::{Buffers, Function};
use crate::input::InputValues;
use crate::linear::matrix::Matrix;
use crate::linear::rows::{LARGEST_DENSE, SparseRows};
use crate::linear::shape::Shape;
use crate::modes::Modes;
use crate::state::{AccelerationRef, StateRef};
use crate::whole_sample::SampleResults;

/// The functions of one compiled system at one set of parameters, with their buffers.
#[derive(Clone, Debug)]
pub struct Evaluator<'a> {
    system: &'a CompiledSystem,
    buffers: EvaluatorBuffers,
}

/// The buffers of an [`Evaluator`], to be kept apart from its system between two uses.
#[derive(Clone, Debug)]
pub(crate) struct EvaluatorBuffers {
    dynamics: Buffers,
    unrolled: Option<Buffers>,
    /// Of a whole sample, where there is one.
    sample: Option<Buffers>,
    constraints: Buffers,
    /// In the place of `constraints` while positions are looked for.
    branching: Option<Buffers>,
    energy: Buffers,
    power: Option<Buffers>,
    reactions: Buffers,
    signals: Option<Buffers>,
    inputs: InputValues,
    slopes: Option<Buffers>,
    /// The multipliers that loads depend on, as the last solution left them.
    pressing: Vec<f64>,
}

/// T, V and the power of everything without a potential.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Energy {
    /// J.
    pub kinetic: f64,
    /// J.
    pub potential: f64,
    /// Power of loads and drives, W.
    pub power: f64,
}

/// M, G, f and γ at one state: M v̇ + Gᵀ λ = f, G v̇ + γ = 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DynamicsAt<'a> {
    pub(crate) shape: &'a Shape,
    /// Values of M in the order of the shape, lower triangle.
    pub(crate) mass: &'a [f64],
    /// Values of G in the order of the shape.
    pub(crate) jacobian: &'a [f64],
    /// nq: applied, potential and Coriolis forces.
    pub(crate) force: &'a [f64],
    /// nc.
    pub(crate) gamma: &'a [f64],
}

/// G, g and ∂g/∂t at one position: g = 0, G v + ∂g/∂t = 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConstraintsAt<'a> {
    pub(crate) shape: &'a Shape,
    /// Values of G in the order of the shape.
    pub(crate) jacobian: &'a [f64],
    /// nc: g, m or rad.
    pub(crate) value: &'a [f64],
    /// nc: ∂g/∂t.
    pub(crate) rate: &'a [f64],
}

impl<'a> Evaluator<'a> {
    pub(crate) fn new(system: &'a CompiledSystem, parameters: &[f64]) -> Self {
        let shared: Arc<[f64]> = parameters.into();
        let parameters = || Arc::clone(&shared);
        let buffers = EvaluatorBuffers {
            dynamics: system.dynamics.buffers(parameters()),
            unrolled: system.unrolled.as_ref().map(|function| function.buffers(parameters())),
            sample: system.sample.as_ref().map(|_| Buffers::new(parameters())),
            constraints: system.constraints.buffers(parameters()),
            branching: None,
            energy: system.energy.buffers(parameters()),
            power: system.power.as_ref().map(|function| function.buffers(parameters())),
            reactions: system.reactions.buffers(parameters()),
            signals: system.signals.as_ref().map(|function| function.buffers(parameters())),
            inputs: InputValues::new(&system.inputs),
            slopes: system.pressing.as_ref().map(|p| p.slopes.buffers(parameters())),
            pressing: vec![0.0; system.pressing.as_ref().map_or(0, |p| p.rows.len())],
        };
        Self { system, buffers }
    }

    /// The evaluator of `system` with buffers that it was [taken apart](Self::into_buffers) into.
    pub(crate) fn with_buffers(system: &'a CompiledSystem, buffers: EvaluatorBuffers) -> Self {
        Self { system, buffers }
    }

    /// Buffers of the evaluator, for [`Self::with_buffers`].
    pub(crate) fn into_buffers(self) -> EvaluatorBuffers {
        self.buffers
    }

    /// The compiled system.
    pub(crate) fn system(&self) -> &'a CompiledSystem {
        self.system
    }

    /// Which entries of M and G there are.
    pub(crate) fn shape(&self) -> &'a Shape {
        &self.system.shape
    }

    /// The inputs at a state, SI.
    pub fn inputs(&mut self, t: f64, q: &[f64], v: &[f64]) -> &[f64] {
        self.buffers.inputs.at(t, q, v)
    }

    /// The values of the named signals, then of the outputs, at a state with its accelerations and multipliers, SI.
    pub fn signals(
        &mut self,
        StateRef { t, q, v }: StateRef<'_>,
        AccelerationRef { a, lambda }: AccelerationRef<'_>,
    ) -> &[f64] {
        let Self { system, buffers: EvaluatorBuffers { signals, inputs, .. } } = self;
        let (Some(function), Some(buffers)) = (&system.signals, signals) else { return &[] };
        function.evaluate(buffers, &[&[t], q, v, a, lambda, inputs.at(t, q, v)])
    }

    /// The rows whose multipliers loads depend on.
    pub(crate) fn pressing_rows(&self) -> &'a [usize] {
        self.system.pressing.as_ref().map_or(&[], |pressing| &pressing.rows)
    }

    /// The multipliers that loads depend on, for [`Evaluator::dynamics`].
    pub(crate) fn pressing_mut(&mut self) -> &mut [f64] {
        &mut self.buffers.pressing
    }

    /// Takes the multipliers that loads depend on from all λ.
    pub(crate) fn press(&mut self, lambda: &[f64]) {
        let rows = self.pressing_rows();
        self.buffers.pressing.iter_mut().zip(rows).for_each(|(own, &row)| *own = lambda[row]);
    }

    /// ∂f/∂λ by the pressing multipliers, nq × their number, row by row.
    pub(crate) fn pressing_slopes(&mut self, t: f64, q: &[f64], v: &[f64]) -> &[f64] {
        let Self { system, buffers: EvaluatorBuffers { slopes, inputs, pressing, .. } } = self;
        let (Some(of), Some(buffers)) = (&system.pressing, slopes) else { return &[] };
        of.slopes.evaluate(buffers, &[&[t], q, v, inputs.at(t, q, v), pressing])
    }

    /// M, G, f and γ at a state, f with the pressing multipliers as they are.
    pub(crate) fn dynamics(&mut self, t: f64, q: &[f64], v: &[f64]) -> DynamicsAt<'_> {
        let Self { system, buffers: EvaluatorBuffers { dynamics, inputs, pressing, .. } } = self;
        let arguments = [&[t], q, v, inputs.at(t, q, v), &pressing[..]];
        let outputs = system.dynamics.evaluate(dynamics, &arguments);
        let shape = &system.shape;
        let (mass, rest) = outputs.split_at(shape.mass.len());
        let (jacobian, rest) = rest.split_at(shape.jacobian.len());
        let (force, gamma) = rest.split_at(shape.nq);
        DynamicsAt { shape, mass, jacobian, force, gamma }
    }

    /// v̇, λ and the factors they come from, see [`solved_with_factors`](crate::linear::unrolled::solved_with_factors); `None` for large
    /// mechanisms.
    pub(crate) fn unrolled(&mut self, t: f64, q: &[f64], v: &[f64]) -> Option<&[f64]> {
        let Self { system, buffers: EvaluatorBuffers { unrolled, inputs, .. } } = self;
        let (function, buffers) = system.unrolled.as_ref().zip(unrolled.as_mut())?;
        Some(function.evaluate(buffers, &[&[t], q, v, inputs.at(t, q, v)]))
    }

    /// Everything about the state near this one that lies on the constraints; `None` where it is computed by parts.
    pub(crate) fn whole_sample(
        &mut self,
        t: f64,
        q: &[f64],
        v: &[f64],
    ) -> Option<SampleResults<'_>> {
        let Self { system, buffers: EvaluatorBuffers { sample, .. } } = self;
        system.sample.as_ref()?.evaluate(sample.as_mut()?, (t, q, v))
    }

    /// The factors among the last results of [`Evaluator::unrolled`].
    pub(crate) fn unrolled_factors(&self) -> &[f64] {
        let line = self.buffers.unrolled.as_ref().map_or(&[][..], Function::last);
        let n = self.system.shape.nq + self.system.shape.nc;
        line.get(n..).unwrap_or_default()
    }

    /// Evaluator whose constraints take the branch of each position whatever the modes are.
    pub(crate) fn branching(self, parameters: &[f64]) -> Self {
        let branching = self.system.branching_constraints.as_ref();
        let branching = branching.map(|function| function.buffers(parameters));
        Self { buffers: EvaluatorBuffers { branching, ..self.buffers }, ..self }
    }

    /// G, g and ∂g/∂t at a position.
    pub(crate) fn constraints(&mut self, t: f64, q: &[f64]) -> ConstraintsAt<'_> {
        let Self { system, buffers: EvaluatorBuffers { constraints, branching, .. } } = self;
        let outputs = match (&system.branching_constraints, branching) {
            (Some(function), Some(buffers)) => function.evaluate(buffers, &[&[t], q]),
            _ => system.constraints.evaluate(constraints, &[&[t], q]),
        };
        let shape = &system.shape;
        let (jacobian, rest) = outputs.split_at(shape.jacobian.len());
        let (value, rate) = rest.split_at(shape.nc);
        ConstraintsAt { shape, jacobian, value, rate }
    }

    /// Energies, and the power of loads and drives.
    pub fn energy(&mut self, t: f64, q: &[f64], v: &[f64], lambda: &[f64]) -> Energy {
        let Self { system, buffers: EvaluatorBuffers { energy, inputs, .. } } = self;
        let arguments = [&[t], q, v, lambda, inputs.at(t, q, v)];
        let mut outputs = [0.0; 3];
        system.energy.evaluate_into(energy, &arguments, &mut outputs);
        let [kinetic, potential, power] = outputs;
        Energy { kinetic, potential, power }
    }

    /// The power of loads and drives, W.
    pub(crate) fn power(&mut self, t: f64, q: &[f64], v: &[f64], lambda: &[f64]) -> f64 {
        let Self { system, buffers: EvaluatorBuffers { power, inputs, .. } } = self;
        let (Some(function), Some(buffers)) = (&system.power, power) else { return 0.0 };
        function.evaluate(buffers, &[&[t], q, v, lambda, inputs.at(t, q, v)])[0]
    }

    /// Joint reactions: six numbers per joint, force then moment, world axes.
    pub fn reactions_into(
        &mut self,
        StateRef { t, q, v }: StateRef<'_>,
        AccelerationRef { a, lambda }: AccelerationRef<'_>,
        out: &mut Vec<[f64; 6]>,
    ) {
        let Self { system, buffers: EvaluatorBuffers { reactions, inputs, .. } } = self;
        let arguments = [&[t], q, v, a, lambda, inputs.at(t, q, v)];
        let outputs = system.reactions.evaluate(reactions, &arguments);
        out.clear();
        out.extend(outputs.chunks_exact(6).map(|six| std::array::from_fn(|i| six[i])));
    }
}

impl CompiledSystem {
    /// The values of `SymbolicSystem::parameters` where every contact is open: the model's own, then the modes.
    pub fn idle_parameters(&self, parameters: &[f64]) -> Vec<f64> {
        self.indicators.idle().parameters_with_modes(parameters)
    }

    /// `parameters`, which may end with modes, with the branches that kinks take at a state, where conditions on zero are
    /// as written; contacts stay as they are.
    pub fn branches_at(&self, parameters: &[f64], state: StateRef<'_>) -> Vec<f64> {
        let (own, numbers) = parameters.split_at(self.n_parameters);
        let modes = self.indicators.modes_from_numbers(numbers);
        let modes = modes.unwrap_or_else(|| self.indicators.idle());
        let StateRef { t, q, v } = state;
        self.indicators.with_signs_at(modes, own, (t, q, v), &|_| 0.0).parameters_with_modes(own)
    }

    /// The functions at the given parameter values, in the order of the model's parameters; modes
    /// may follow, else every contact is open.
    pub fn evaluator(&self, parameters: &[f64]) -> Evaluator<'_> {
        let has_modes = parameters.len() > self.n_parameters;
        let idle = if has_modes { Modes::default() } else { self.indicators.idle() };
        Evaluator::new(self, &idle.parameters_with_modes(parameters))
    }
}

impl DynamicsAt<'_> {
    /// True if every number is finite.
    pub(crate) fn is_finite(&self) -> bool {
        let parts = [self.mass, self.jacobian, self.force, self.gamma];
        parts.into_iter().flatten().all(|value| value.is_finite())
    }

    /// M, nq × nq.
    pub(crate) fn mass_matrix(&self) -> DMatrix<f64> {
        let nq = self.shape.nq;
        let mut mass = DMatrix::zeros(nq, nq);
        for (&(i, j), &value) in self.shape.mass.iter().zip(self.mass) {
            mass[(i, j)] = value;
            mass[(j, i)] = value;
        }
        mass
    }

    /// M, nq × nq: dense for a small mechanism, else its entries alone.
    pub(crate) fn mass(&self) -> Matrix {
        let nq = self.shape.nq;
        if nq <= LARGEST_DENSE {
            return Matrix::Dense(self.mass_matrix());
        }
        let lower = self.shape.mass.iter().zip(self.mass).map(|(&(i, j), &m)| (i, j, m));
        let upper = lower.clone().filter(|&(i, j, _)| i != j).map(|(i, j, m)| (j, i, m));
        Matrix::Sparse(SparseRows::from_entries(nq, nq, lower.chain(upper)))
    }

    /// Writes G v̇ + γ, nc.
    pub(crate) fn acceleration_residual_into(&self, vdot: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for (&(row, i), &g) in self.shape.jacobian.iter().zip(self.jacobian) {
            out[row] += g * vdot[i];
        }
        out.iter_mut().zip(self.gamma).for_each(|(out, gamma)| *out += gamma);
    }

    /// G, nc × nq.
    pub(crate) fn jacobian_rows(&self) -> SparseRows {
        jacobian_rows(self.shape, self.jacobian)
    }

    /// M v̇.
    pub(crate) fn inertia_of(&self, vdot: &[f64]) -> Vec<f64> {
        let mut inertia = vec![0.0; self.shape.nq];
        for (&(i, j), &m) in self.shape.mass.iter().zip(self.mass) {
            inertia[i] += m * vdot[j];
            if i != j {
                inertia[j] += m * vdot[i];
            }
        }
        inertia
    }
}

impl ConstraintsAt<'_> {
    /// G, nc × nq.
    pub(crate) fn jacobian_rows(&self) -> SparseRows {
        jacobian_rows(self.shape, self.jacobian)
    }

    /// Adds the rows of G, nc × nq.
    pub(crate) fn add_jacobian_rows_to(&self, rows: &mut SparseRows) {
        rows.push_rows(self.shape.nc, entries(self.shape, self.jacobian));
    }

    /// Writes G v + ∂g/∂t, nc.
    pub(crate) fn rate_into(&self, v: &[f64], out: &mut [f64]) {
        out.copy_from_slice(self.rate);
        for (&(row, i), &value) in self.shape.jacobian.iter().zip(self.jacobian) {
            out[row] += value * v[i];
        }
    }

    /// G v + ∂g/∂t, nc.
    pub(crate) fn rate_of(&self, v: &[f64]) -> Vec<f64> {
        let mut rate = vec![0.0; self.shape.nc];
        self.rate_into(v, &mut rate);
        rate
    }
}

/// The entries of G, row by row: row, coordinate, value.
fn entries<'a>(
    shape: &'a Shape,
    values: &'a [f64],
) -> impl Iterator<Item = (usize, usize, f64)> + 'a {
    shape.jacobian.iter().zip(values).map(|(&(row, i), &value)| (row, i, value))
}

fn jacobian_rows(shape: &Shape, values: &[f64]) -> SparseRows {
    let mut rows = SparseRows::new(shape.nq);
    rows.push_rows(shape.nc, entries(shape, values));
    rows
}
