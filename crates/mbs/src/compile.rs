//! [`CompiledSystem`]: the symbolic system as straight-line functions of numbers.
//!
//! The dynamics at a state, the constraints at a position, energies and powers, and the joint
//! reactions; [`Evaluator`] calls them. All take the parameters at run time, so one compiled system
//! serves every parameter value.

use bksim_expr::{Expr, Pool, Runner, SymbolId, Tape, TapeError};

pub use crate::evaluator::Evaluator;
use crate::straight::StraightLine;

use crate::assemble::{Source, SymbolicSystem};
use crate::input::Inputs;
use crate::joint::MotionKind;
use crate::model::{DriveId, JointId, LoadId, Model};
use crate::reaction::reactions;
use crate::switch::{Modes, Watch};

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
    /// Parameters that are functions of the motion.
    pub(crate) inputs: Inputs,
    /// M, G, f and γ of (t, q, v, u), u the inputs.
    pub(crate) dynamics: Runner,
    /// v̇, λ and factors of (t, q, v, u), of small mechanisms; see [`StraightLine`].
    pub(crate) straight_line: Option<Runner>,
    /// G, g and ∂g/∂t of (t, q).
    pub(crate) constraints: Runner,
    pub(crate) shape: Shape,
    /// T, V and the power of (t, q, v, λ, u).
    pub(crate) energy: Runner,
    /// The power alone; `None` where nothing acts but forces with a potential.
    pub(crate) power: Option<Runner>,
    /// Six numbers per joint of (t, q, v, a, λ, u).
    pub(crate) reactions: Runner,
    /// What decides the modes.
    pub(crate) watch: Watch,
    /// The model's own, without modes.
    n_parameters: usize,
}

/// Which entries of M and G there are, in the order of their values.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub(crate) struct Shape {
    pub(crate) nq: usize,
    pub(crate) nc: usize,
    /// (i, j) with i ≥ j.
    pub(crate) mass: Vec<(usize, usize)>,
    /// (row, coordinate).
    pub(crate) jacobian: Vec<(usize, usize)>,
}

/// Compiles the functions of `system`.
///
/// # Errors
/// [`TapeError`] names a symbol that is neither time, a parameter nor part of the state.
pub fn compile(model: &Model, system: &SymbolicSystem) -> Result<CompiledSystem, TapeError> {
    let pool = &model.pool;
    let watch = Watch::compile(model, system)?;
    let system = system.integrated();
    let coordinates = system.coordinates();
    let [q, v, a]: [Vec<SymbolId>; 3] = [
        coordinates.iter().map(|c| c.q).collect(),
        coordinates.iter().map(|c| c.v).collect(),
        coordinates.iter().map(|c| c.a).collect(),
    ];
    let lambda: Vec<SymbolId> = system.constraints.iter().map(|c| c.lambda).collect();
    let u = model.inputs.symbols();
    let parameters = model.inputs.without(model, system.parameters(model));
    let tape = |outputs: &[Expr], inputs: &[&[SymbolId]]| {
        let inputs: Vec<SymbolId> =
            std::iter::once(model.time).chain(inputs.iter().copied().flatten().copied()).collect();
        let tape = Tape::compile(pool, outputs, &inputs, &parameters)?;
        Ok::<_, TapeError>(Runner::new(tape, model.solve.jit))
    };

    let shape = Shape::of(system);
    let mass: Vec<Expr> = system.mass_matrix.lower().map(|(.., entry)| entry).collect();
    let jacobian: Vec<Expr> =
        system.constraint_jacobian.entries().map(|(.., entry)| entry).collect();
    let forces = (0..shape.nq).map(|i| {
        let resisting = pool.add(system.bias[i], system.potential_gradient[i]);
        pool.sub(system.force[i], resisting)
    });
    let forces: Vec<Expr> = forces.collect();
    let gammas: Vec<Expr> = (0..shape.nc).map(|row| constraint_gamma(model, system, row)).collect();
    let dynamics = [mass.as_slice(), &jacobian, &forces, &gammas].concat();
    let straight_line = StraightLine::of(pool, &shape, (&mass, &jacobian), (&forces, &gammas))
        .map(|line| tape(&line.outputs(), &[&q, &v, u]))
        .transpose()?;
    let closed = system.constraints.iter().map(|c| c.expression);
    let constraints: Vec<Expr> =
        jacobian.into_iter().chain(closed).chain(system.constraint_rate.iter().copied()).collect();
    let energy = energy_outputs(pool, system);
    let is_powered = !pool.is_zero(energy[2]);
    let power = is_powered.then(|| tape(&energy[2..], &[&q, &v, &lambda, u])).transpose()?;
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
        inputs: model.inputs.clone(),
        dynamics: tape(&dynamics, &[&q, &v, u])?,
        straight_line,
        constraints: tape(&constraints, &[&q])?,
        shape,
        energy: tape(&energy, &[&q, &v, &lambda, u])?,
        power,
        reactions: tape(&reaction_outputs, &[&q, &v, &a, &lambda, u])?,
        watch,
        n_parameters: model.parameters.len(),
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

    /// The functions at the given parameter values, in the order of the model's parameters; modes
    /// may follow, else every contact is open.
    pub fn evaluator(&self, parameters: &[f64]) -> Evaluator<'_> {
        let has_modes = parameters.len() > self.n_parameters;
        let idle = if has_modes { Modes::default() } else { self.watch.idle() };
        Evaluator::new(self, &idle.behind(parameters))
    }
}

impl Shape {
    fn of(system: &SymbolicSystem) -> Self {
        let place = |(row, col, _): (usize, usize, Expr)| (row, col);
        Self {
            nq: system.coordinates().len(),
            nc: system.constraints.len(),
            mass: system.mass_matrix.lower().map(place).collect(),
            jacobian: system.constraint_jacobian.entries().map(place).collect(),
        }
    }
}

/// G v + ∂g/∂t of one row.
pub(crate) fn constraint_velocity(pool: &Pool, system: &SymbolicSystem, row: usize) -> Expr {
    let v = |i: usize| pool.symbol_expr(system.coordinates()[i].v);
    let terms = system.constraint_jacobian.row(row).iter().map(|&(i, g)| pool.mul(g, v(i)));
    pool.sum(terms.chain([system.constraint_rate[row]]).collect::<Vec<_>>())
}

/// G v̇ + γ of one row.
pub(crate) fn constraint_acceleration(model: &Model, system: &SymbolicSystem, row: usize) -> Expr {
    let pool = &model.pool;
    let a = |i: usize| pool.symbol_expr(system.coordinates()[i].a);
    let terms = system.constraint_jacobian.row(row).iter().map(|&(i, g)| pool.mul(g, a(i)));
    pool.sum(terms.chain([constraint_gamma(model, system, row)]).collect::<Vec<_>>())
}

/// γ = (∂/∂q (G v + ∂g/∂t)) v + ∂/∂t (G v + ∂g/∂t).
fn constraint_gamma(model: &Model, system: &SymbolicSystem, row: usize) -> Expr {
    system.kinematics.rate(model, constraint_velocity(&model.pool, system, row))
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
            Source::Stop(LoadId(l)) => format!("stop `{}`", model.loads[l].name),
            Source::Friction(LoadId(l)) => format!("friction `{}`", model.loads[l].name),
        };
        Quantity {
            name: model.pool.symbol_name(c.lambda),
            unit: if is_force { "N" } else { "N*m" },
            description: match c.source {
                Source::Friction(_) => owner,
                _ => format!("{owner}, {}", c.direction),
            },
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
