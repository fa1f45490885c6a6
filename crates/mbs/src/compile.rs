//! [`CompiledSystem`]: the symbolic system as straight-line functions of numbers.
//!
//! Three functions serve everything outside the integrator: the dynamics at a state, the energies
//! and powers, and the joint reactions. All take the parameters at run time, so one compiled system
//! serves every parameter value.

use bksim_expr::{Expr, Pool, Runner, SymbolId, Tape, TapeError, Workspace};
use nalgebra::{DMatrix, DVector};

use crate::assemble::{Source, SymbolicSystem};
use crate::joint::MotionKind;
use crate::model::{DriveId, JointId, Model};
use crate::reaction::reactions;

/// Name and unit of one number of the state.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Quantity {
    /// Identifier.
    pub name: String,
    /// SI unit of the value; rates append `/s`.
    pub unit: &'static str,
    /// What it is, in a few words.
    pub description: String,
}

/// A mechanism as functions of numbers: no expressions, no text to parse, safe to share.
#[derive(Clone, Debug)]
pub struct CompiledSystem {
    /// The generalised coordinates.
    pub coordinates: Vec<Quantity>,
    /// The multipliers.
    pub multipliers: Vec<Quantity>,
    /// Where each constraint row comes from.
    pub sources: Vec<Source>,
    /// Names of the joints, in file order; reactions follow it.
    pub joints: Vec<String>,
    /// The drives, each with its effort.
    pub drives: Vec<Quantity>,
    dynamics: Runner,
    shape: DynamicsShape,
    energy: Runner,
    reactions: Runner,
}

/// Where the outputs of the dynamics tape go.
#[derive(Clone, Debug)]
struct DynamicsShape {
    nq: usize,
    nc: usize,
    mass: Vec<(usize, usize)>,
    jacobian: Vec<(usize, usize)>,
}

/// M, f, g, G, ∂g/∂t and γ at one state: M v̇ = f − Gᵀλ, g = 0, G v + ∂g/∂t = 0, G v̇ + γ = 0.
#[derive(Clone, Debug)]
pub(crate) struct Dynamics {
    /// nq × nq.
    pub(crate) mass: DMatrix<f64>,
    /// nq: applied, potential and Coriolis forces.
    pub(crate) force: DVector<f64>,
    /// nc.
    pub(crate) constraint: DVector<f64>,
    /// nc × nq.
    pub(crate) jacobian: DMatrix<f64>,
    /// nc.
    pub(crate) rate: DVector<f64>,
    /// nc.
    pub(crate) gamma: DVector<f64>,
}

impl Dynamics {
    /// Whether every number is finite.
    pub(crate) fn is_finite(&self) -> bool {
        let matrices = self.mass.iter().chain(&self.jacobian);
        let vectors = [&self.force, &self.constraint, &self.rate, &self.gamma];
        matrices.chain(vectors.into_iter().flatten()).all(|value| value.is_finite())
    }
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

/// The functions of one compiled system at one set of parameters, with their buffers.
#[derive(Clone, Debug)]
pub struct Evaluator<'a> {
    system: &'a CompiledSystem,
    dynamics: Workspace,
    energy: Workspace,
    reactions: Workspace,
    inputs: Vec<f64>,
    outputs: Vec<f64>,
    pub(crate) at: Dynamics,
}

/// Compiles the functions of `system`.
///
/// # Errors
/// [`TapeError`] names a symbol that is neither time, a parameter nor part of the state.
pub fn compile(model: &Model, system: &SymbolicSystem) -> Result<CompiledSystem, TapeError> {
    let pool = &model.pool;
    let coordinates = system.coordinates();
    let [q, v, a]: [Vec<SymbolId>; 3] = [
        coordinates.iter().map(|c| c.q).collect(),
        coordinates.iter().map(|c| c.v).collect(),
        coordinates.iter().map(|c| c.a).collect(),
    ];
    let lambda: Vec<SymbolId> = system.constraints.iter().map(|c| c.lambda).collect();
    let parameters: Vec<SymbolId> = model.parameters.iter().map(|p| p.symbol).collect();
    let tape = |outputs: &[Expr], inputs: &[&[SymbolId]]| {
        let inputs: Vec<SymbolId> =
            std::iter::once(model.time).chain(inputs.iter().copied().flatten().copied()).collect();
        let tape = Tape::compile(pool, outputs, &inputs, &parameters)?;
        Ok::<_, TapeError>(Runner::new(tape, model.solve.jit))
    };

    let (shape, dynamics) = dynamics_outputs(model, system);
    let reaction_outputs: Vec<Expr> =
        reactions(model, system).iter().flat_map(|r| [r.force, r.moment].concat()).collect();
    Ok(CompiledSystem {
        coordinates: coordinates
            .iter()
            .map(|c| coordinate_quantity(c.name.clone(), c.kind))
            .collect(),
        multipliers: multiplier_quantities(model, system),
        sources: system.constraints.iter().map(|c| c.source).collect(),
        joints: model.joints.iter().map(|j| j.name.clone()).collect(),
        drives: drive_quantities(model),
        dynamics: tape(&dynamics, &[&q, &v])?,
        shape,
        energy: tape(&energy_outputs(pool, system), &[&q, &v, &lambda])?,
        reactions: tape(&reaction_outputs, &[&q, &v, &a, &lambda])?,
    })
}

impl CompiledSystem {
    /// Number of generalised coordinates.
    pub fn nq(&self) -> usize {
        self.shape.nq
    }

    /// Number of constraint rows.
    pub fn nc(&self) -> usize {
        self.shape.nc
    }

    /// The functions at the given parameter values, in the order of the model's parameters.
    pub fn evaluator(&self, parameters: &[f64]) -> Evaluator<'_> {
        let (nq, nc) = (self.nq(), self.nc());
        let n_outputs = [&self.dynamics, &self.energy, &self.reactions]
            .map(|runner| runner.tape().n_outputs())
            .into_iter()
            .max()
            .unwrap_or(0);
        Evaluator {
            system: self,
            dynamics: self.dynamics.tape().workspace(parameters),
            energy: self.energy.tape().workspace(parameters),
            reactions: self.reactions.tape().workspace(parameters),
            inputs: Vec::with_capacity(1 + 3 * nq + nc),
            outputs: vec![0.0; n_outputs],
            at: Dynamics {
                mass: DMatrix::zeros(nq, nq),
                force: DVector::zeros(nq),
                constraint: DVector::zeros(nc),
                jacobian: DMatrix::zeros(nc, nq),
                rate: DVector::zeros(nc),
                gamma: DVector::zeros(nc),
            },
        }
    }
}

impl Evaluator<'_> {
    /// Evaluates the dynamics at a state into `self.at`.
    pub(crate) fn dynamics(&mut self, t: f64, q: &[f64], v: &[f64]) -> &Dynamics {
        let system = self.system;
        let outputs = &mut self.outputs[..system.dynamics.tape().n_outputs()];
        gather(&mut self.inputs, t, &[q, v]);
        system.dynamics.evaluate(&mut self.dynamics, &self.inputs, outputs);

        let shape = &system.shape;
        let (mass, rest) = outputs.split_at(shape.mass.len());
        let (jacobian, rest) = rest.split_at(shape.jacobian.len());
        for (&(i, j), &value) in shape.mass.iter().zip(mass) {
            self.at.mass[(i, j)] = value;
            self.at.mass[(j, i)] = value;
        }
        for (&entry, &value) in shape.jacobian.iter().zip(jacobian) {
            self.at.jacobian[entry] = value;
        }
        let (force, rest) = rest.split_at(shape.nq);
        let (constraint, rest) = rest.split_at(shape.nc);
        let (rate, gamma) = rest.split_at(shape.nc);
        self.at.force.copy_from_slice(force);
        self.at.constraint.copy_from_slice(constraint);
        self.at.rate.copy_from_slice(rate);
        self.at.gamma.copy_from_slice(gamma);
        &self.at
    }

    /// Energies, and the power of loads and drives.
    pub fn energy(&mut self, t: f64, q: &[f64], v: &[f64], lambda: &[f64]) -> Energy {
        let mut outputs = [0.0; 3];
        gather(&mut self.inputs, t, &[q, v, lambda]);
        self.system.energy.evaluate(&mut self.energy, &self.inputs, &mut outputs);
        let [kinetic, potential, power] = outputs;
        Energy { kinetic, potential, power }
    }

    /// Joint reactions: six numbers per joint, force then moment, world axes.
    pub fn reactions_into(&mut self, t: f64, state: [&[f64]; 4], out: &mut Vec<[f64; 6]>) {
        let outputs = &mut self.outputs[..self.system.reactions.tape().n_outputs()];
        gather(&mut self.inputs, t, &state);
        self.system.reactions.evaluate(&mut self.reactions, &self.inputs, outputs);
        out.clear();
        out.extend(outputs.chunks_exact(6).map(|six| std::array::from_fn(|i| six[i])));
    }
}

/// Inputs of a tape: time, then the parts of the state.
fn gather(inputs: &mut Vec<f64>, t: f64, parts: &[&[f64]]) {
    inputs.clear();
    inputs.push(t);
    for part in parts {
        inputs.extend_from_slice(part);
    }
}

fn dynamics_outputs(model: &Model, system: &SymbolicSystem) -> (DynamicsShape, Vec<Expr>) {
    let pool = &model.pool;
    let (nq, nc) = (system.coordinates().len(), system.constraints.len());
    let mut shape = DynamicsShape { nq, nc, mass: Vec::new(), jacobian: Vec::new() };
    let mut outputs = Vec::new();
    for (i, j, entry) in system.mass_matrix.lower() {
        shape.mass.push((i, j));
        outputs.push(entry);
    }
    for (row, col, entry) in system.constraint_jacobian.entries() {
        shape.jacobian.push((row, col));
        outputs.push(entry);
    }
    outputs.extend((0..nq).map(|i| {
        let resisting = pool.add(system.bias[i], system.potential_gradient[i]);
        pool.sub(system.force[i], resisting)
    }));
    outputs.extend(system.constraints.iter().map(|c| c.expression));
    outputs.extend(&system.constraint_rate);
    // γ = (∂/∂q (G v + ∂g/∂t)) v + ∂/∂t (G v + ∂g/∂t)
    outputs.extend((0..nc).map(|row| {
        system.kinematics.rate(model, constraint_velocity(pool, system, row))
    }));
    (shape, outputs)
}

/// G v + ∂g/∂t of one row.
pub(crate) fn constraint_velocity(pool: &Pool, system: &SymbolicSystem, row: usize) -> Expr {
    let v = |i: usize| pool.symbol_expr(system.coordinates()[i].v);
    let terms = system.constraint_jacobian.row(row).iter().map(|&(i, g)| pool.mul(g, v(i)));
    pool.sum(terms.chain([system.constraint_rate[row]]).collect::<Vec<_>>())
}

/// T, V, and P = Q · v + λ · ∂g/∂t: constraint forces do the work −λᵀ G v = λᵀ ∂g/∂t.
fn energy_outputs(pool: &Pool, system: &SymbolicSystem) -> [Expr; 3] {
    let loads = system.coordinates().iter().zip(&system.force);
    let drives = system.constraints.iter().zip(&system.constraint_rate);
    let power = loads
        .map(|(c, &force)| pool.mul(force, pool.symbol_expr(c.v)))
        .chain(drives.map(|(c, &rate)| pool.mul(rate, pool.symbol_expr(c.lambda))));
    let power = pool.sum(power.collect::<Vec<_>>());
    [system.kinetic_energy, system.potential_energy, power]
}

fn coordinate_quantity(name: String, kind: MotionKind) -> Quantity {
    let (unit, description) = match kind {
        MotionKind::Rotation => ("rad", "angle"),
        MotionKind::Translation => ("m", "position"),
    };
    Quantity { name, unit, description: description.into() }
}

fn multiplier_quantities(model: &Model, system: &SymbolicSystem) -> Vec<Quantity> {
    let quantity = |c: &crate::assemble::Constraint| {
        let is_force = c.force.iter().any(|&component| !model.pool.is_zero(component));
        let owner = match c.source {
            Source::Joint(JointId(j)) => format!("joint `{}`", model.joints[j].name),
            Source::Drive(DriveId(d)) => format!("drive `{}`", model.drives[d].name),
        };
        Quantity {
            name: model.pool.symbol_name(c.lambda),
            unit: if is_force { "N" } else { "N*m" },
            description: format!("{owner}, {}", c.direction),
        }
    };
    system.constraints.iter().map(quantity).collect()
}

fn drive_quantities(model: &Model) -> Vec<Quantity> {
    let quantity = |drive: &crate::model::Drive| {
        let joint = &model.joints[drive.joint.0];
        let turns = crate::joint::motions(&model.pool, joint)[drive.motion_idx].kind
            == MotionKind::Rotation;
        Quantity {
            name: drive.name.clone(),
            unit: if turns { "N*m" } else { "N" },
            description: format!("effort on joint `{}`", joint.name),
        }
    };
    model.drives.iter().map(quantity).collect()
}
