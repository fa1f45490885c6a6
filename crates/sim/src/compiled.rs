//! [`CompiledSystem`]: the symbolic system as straight-line functions of numbers.
//!
//! The dynamics at a state, the constraints at a position, energies and powers, and the joint
//! reactions; [`Evaluator`](crate::evaluator::Evaluator) calls them. All take the parameters at run time, so one compiled system
//! serves every parameter value.

use crate::input::{Law, input_symbols, without_inputs};
use crate::linear::plan::EliminationPlan;
use crate::linear::shape::Shape;
use bksim_mbs::levels::constraint_gamma;
use bksim_mbs::quantity::{
    Quantity, coordinate_quantities, coupling_quantities, drive_quantities, multiplier_quantities,
};
use std::sync::Arc;

use bksim_dae::{Index, Layout};
use bksim_expr::{Expr, Pool, SymbolId, Tape, TapeError};

use crate::function::Function;
use crate::held_rows::HeldRows;

use crate::linear::unrolled::{solved, solved_with_factors};

use crate::input::Inputs;
use crate::latch::Latches;
use crate::modes::Modes;
use crate::modes::indicators::EventIndicators;
use crate::pressing::{Bearing, PressingMultipliers, bearings, pressing_symbols};
use crate::redundancy::{
    Effort, MovingInstant, Redundancy, SelfStress, Transmissions, Uniqueness, Yields, resting,
};
use crate::rope_turns::RopeTurns;
use crate::sampled::{SampledSignals, Sampling};
use crate::whole_sample::{SampleParts, WholeSample};
use crate::whole_step::{StepParts, WholeStep};
use bksim_mbs::constraint::Source;
use bksim_mbs::coordinate::CoordinateKind;
use bksim_mbs::reaction::{reactions, reported};
use bksim_mbs::signal::signal_values;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{CouplingKind, Model};

/// A mechanism as functions of numbers: no expressions, no text to parse, safe to share.
#[derive(Clone, Debug)]
pub struct CompiledSystem {
    /// The generalised coordinates.
    pub coordinates: Vec<Quantity>,
    /// The multipliers.
    pub multipliers: Vec<Quantity>,
    /// Where each constraint row comes from.
    pub sources: Vec<Source>,
    /// Constraint rows of ropes that stay taut.
    pub(crate) taut_ropes: Vec<usize>,
    /// Turns of ropes about pulleys that they are held to.
    pub(crate) rope_turns: Option<RopeTurns>,
    /// Names of the joints, in file order; reactions follow it.
    pub joints: Vec<String>,
    /// The couplings, each with its force or moment.
    pub couplings: Vec<Quantity>,
    /// The drives, each with its effort.
    pub drives: Vec<Quantity>,
    /// Parameters that are functions of the motion.
    pub(crate) inputs: Inputs,
    /// M, G, f and γ of (t, q, v, u), u the inputs, and of the pressing multipliers.
    pub(crate) dynamics: Function,
    /// The multipliers that f depends on; mostly `None`.
    pub(crate) pressing: Option<PressingMultipliers>,
    /// The joints whose friction follows their reactions.
    pub(crate) bearings: Vec<Bearing>,
    /// v̇, λ and factors of (t, q, v, u), of small mechanisms; see [`solved_with_factors`].
    pub(crate) unrolled: Option<Function>,
    /// A whole step of small mechanisms whose loads follow no law.
    pub(crate) step: Option<Arc<WholeStep>>,
    /// A whole sample, of the same mechanisms as a whole step.
    pub(crate) sample: Option<Arc<WholeSample>>,
    /// The unknowns (q, v, W) of explicit steps, W the work of loads and drives.
    pub(crate) unknowns: Layout,
    /// G, g and ∂g/∂t of (t, q).
    pub(crate) constraints: Function,
    /// Constraints with the branch of each position in place of modes, where joints or drives have kinks: to look for
    /// positions. Contacts are as in the modes.
    pub(crate) branching_constraints: Option<Function>,
    pub(crate) shape: Shape,
    pub(crate) elimination: EliminationPlan,
    /// T, V and the power of (t, q, v, λ, u).
    pub(crate) energy: Function,
    /// The power alone; `None` where nothing acts but forces with a potential.
    pub(crate) power: Option<Function>,
    /// Six numbers per joint of (t, q, v, a, λ, u).
    pub(crate) reactions: Function,
    /// The functions that decide the modes.
    pub(crate) indicators: EventIndicators,
    pub(crate) sampled: SampledSignals,
    pub(crate) latches: Latches,
    /// The wrenches that joints in loops transmit.
    pub(crate) transmissions: Transmissions,
    /// Second angles of three in sequence.
    pub(crate) second_angles: Vec<usize>,
    /// The values of the named signals, where there are some.
    pub(crate) signals: Option<Function>,
    /// The function that tells of another assembly, where one is held.
    pub(crate) held_rows: Option<HeldRows>,
    /// Parameters of the model itself, without modes.
    pub(crate) n_parameters: usize,
    /// Coordinates whose velocities are states.
    pub(crate) n_states: usize,
}

/// Compiles the functions of `system`.
///
/// # Errors
/// [`TapeError`] names a symbol that is neither time, a parameter nor part of the state.
pub fn compile(model: &Model, system: &SymbolicSystem) -> Result<CompiledSystem, TapeError> {
    let pool = &model.pool;
    // Modes stand for everything that switches.
    let indicators = EventIndicators::compile(model, system)?;
    let sampled = SampledSignals::compile(model, system)?;
    let latches = Latches::compile(model, system)?;
    let (written, system) = (system, system.integrated());
    // Arguments and parameters.
    let coordinates = system.coordinates();
    let [q, v, a]: [Vec<SymbolId>; 3] = [
        coordinates.iter().map(|c| c.q).collect(),
        coordinates.iter().map(|c| c.v).collect(),
        coordinates.iter().map(|c| c.a).collect(),
    ];
    let lambda: Vec<SymbolId> = system.constraints.iter().map(|c| c.lambda).collect();
    let u = input_symbols(model);
    let u = u.as_slice();
    let parameters = without_inputs(model, system.parameters(model));
    let function = |outputs: &[Expr], arguments: &[&[SymbolId]]| {
        let time = [model.time];
        let arguments = [&[&time[..]], arguments].concat();
        Function::compile(model, outputs, &arguments, &parameters)
    };

    // M, G, f and γ, for small mechanisms with the solution of their equations.
    let shape = Shape::of(system);
    let Terms { mass, jacobian, force, gamma } = terms(model, system);
    let dynamics = [mass.as_slice(), &jacobian, &force, &gamma].concat();
    let pressing = PressingMultipliers::compile(model, system)?;
    let pressing_lambda = pressing_symbols(model, system);
    let dynamics = function(&dynamics, &[&q, &v, u, &pressing_lambda])?;
    let unrolled =
        pressing.is_none().then(|| solved_with_factors(&shape, dynamics.tape())).flatten();
    let unrolled = unrolled.map(|line| Function::of(line, model));
    // Constraints at positions, energies, reactions.
    let closed = system.constraints.iter().map(|c| c.expression);
    let constraints: Vec<Expr> =
        jacobian.into_iter().chain(closed).chain(system.constraint_rate.iter().copied()).collect();
    let branching = branching_constraints(written, system);
    let branching_constraints =
        if branching == constraints { None } else { Some(function(&branching, &[&q])?) };
    let constraints = function(&constraints, &[&q])?;
    let energy = energy_outputs(pool, system);
    let is_powered = !pool.is_zero(energy[2]);
    let power = is_powered.then(|| function(&energy[2..], &[&q, &v, &lambda, u])).transpose()?;
    let inputs = Inputs::of(model);
    let step = unrolled.as_ref().filter(|_| inputs.is_empty()).map(|line| {
        Arc::new(StepParts {
            shape: shape.clone(),
            line: line.tape().clone(),
            power: power.as_ref().map(|power| power.tape().clone()),
            constraints: constraints.tape().clone(),
        })
    });
    let all_reactions = reactions(model, system);
    let reaction_outputs: Vec<Expr> =
        all_reactions.iter().flat_map(|r| [r.force, r.moment].concat()).collect();
    // Signals as they were written: they have no modes.
    let measures = signal_values(model, &system.kinematics);
    let signals = model.named_signals.iter();
    let signals: Vec<Expr> = signals.map(|s| pool.substitute(s.value, &measures)).collect();
    let signals = pool.substitute_all(&signals, &reported(model, system, &all_reactions));
    let energy = function(&energy, &[&q, &v, &lambda, u])?;
    let reactions = function(&reaction_outputs, &[&q, &v, &a, &lambda, u])?;
    let signals =
        (!signals.is_empty()).then(|| function(&signals, &[&q, &v, &a, &lambda, u])).transpose()?;
    let sample = step.clone().map(|step| SampleParts {
        step,
        dynamics: dynamics.tape().clone(),
        energy: energy.tape().clone(),
        reactions: reactions.tape().clone(),
        signals: signals.as_ref().map(|signals| signals.tape().clone()),
    });
    let coordinates = coordinate_quantities(model, system);
    Ok(CompiledSystem {
        unknowns: unknowns(&coordinates),
        coordinates,
        multipliers: multiplier_quantities(model, system),
        sources: system.constraints.iter().map(|c| c.source).collect(),
        taut_ropes: {
            let is_rope = |source: Source| match source {
                Source::Coupling(id) => {
                    matches!(model.couplings[id.0].kind, CouplingKind::Rope(..))
                }
                _ => false,
            };
            let rows = 0..system.constraints.len();
            rows.filter(|&row| is_rope(system.constraints[row].source)).collect()
        },
        rope_turns: RopeTurns::compile(model, system, &q, &parameters)?,
        joints: model.joints.iter().map(|j| j.name.clone()).collect(),
        couplings: coupling_quantities(model),
        drives: drive_quantities(model),
        inputs,
        dynamics,
        pressing,
        bearings: bearings(model),
        unrolled,
        step: step.map(|parts| Arc::new(WholeStep::new(parts, model.solve.jit))),
        sample: sample.map(|parts| Arc::new(WholeSample::new(parts, model.solve.jit))),
        constraints,
        branching_constraints,
        shape,
        elimination: EliminationPlan::default(),
        energy,
        power,
        reactions,
        indicators,
        sampled,
        latches,
        transmissions: Transmissions::compile(model, system, &q, &parameters)?,
        second_angles: system.kinematics.sequences().iter().map(|three| three[1]).collect(),
        signals,
        held_rows: HeldRows::compile(model, system, &parameters)?,
        n_parameters: model.parameters.len(),
        n_states: model.states.len(),
    })
}

/// (q, v, W) with the names of the coordinates and their rates.
fn unknowns(coordinates: &[Quantity]) -> Layout {
    let names = coordinates.iter().map(|c| c.name.clone());
    let rates = coordinates.iter().map(|c| c.rates[0][0].clone());
    let names: Vec<String> = names.chain(rates).chain(["work".to_owned()]).collect();
    Layout::from_groups(&[(names.len(), Index::One)]).with_names(names)
}

/// G, g and ∂g/∂t with the rows that always hold as they were written, and those of contacts with their modes.
fn branching_constraints(written: &SymbolicSystem, integrated: &SymbolicSystem) -> Vec<Expr> {
    let n_bilateral = written.n_bilateral();
    let of = |row: usize| if row < n_bilateral { written } else { integrated };
    let n = integrated.constraints.len();
    let jacobian = (0..n).flat_map(|row| of(row).constraint_jacobian.row(row).iter().map(|e| e.1));
    let closed = (0..n).map(|row| of(row).constraints[row].expression);
    let rates = (0..n).map(|row| of(row).constraint_rate[row]);
    jacobian.chain(closed).chain(rates).collect()
}

/// The terms of M v̇ + Gᵀ λ = f, G v̇ = −γ as expressions of (t, q, v).
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Terms {
    /// Entries of the lower triangle of M, row by row, those that are not zero.
    pub mass: Vec<Expr>,
    /// Entries of G, row by row, those that are not zero.
    pub jacobian: Vec<Expr>,
    /// f, nq.
    pub force: Vec<Expr>,
    /// γ, nc.
    pub gamma: Vec<Expr>,
}

/// The terms of the equations of motion.
pub fn terms(model: &Model, system: &SymbolicSystem) -> Terms {
    let pool = &model.pool;
    let force = |i: usize| pool.sub(system.applied_force[i], system.resistance[i]);
    Terms {
        mass: system.mass_matrix.lower().map(|(.., entry)| entry).collect(),
        jacobian: system.constraint_jacobian.entries().map(|(.., entry)| entry).collect(),
        force: (0..system.coordinates().len()).map(force).collect(),
        gamma: (0..system.constraints.len())
            .map(|row| constraint_gamma(model, system, row))
            .collect(),
    }
}

/// v̇, nq, and λ, nc, all constraint rows being independent, as a function of the arguments (t, q, v, …) of a tape of the
/// [`terms`], one after the other; `None` for a mechanism that is too large, or has a coordinate without inertia of its
/// own.
pub fn solved_accelerations(system: &SymbolicSystem, terms: &Tape) -> Option<Tape> {
    solved(&Shape::of(system), terms)
}

impl CompiledSystem {
    /// The sampled signals at these values of the model's own parameters.
    pub(crate) fn sampling(&self, parameters: &[f64]) -> Sampling<'_> {
        self.sampled.at(parameters, &self.inputs)
    }

    /// Number of generalised coordinates.
    pub fn nq(&self) -> usize {
        self.shape.nq
    }

    /// Number of constraint rows.
    pub fn nc(&self) -> usize {
        self.shape.nc
    }

    /// Which components of the reactions are unique from an instant on, in these modes.
    pub(crate) fn uniqueness(
        &self,
        parameters: &[f64],
        at: MovingInstant<'_>,
        modes: &Modes,
    ) -> Uniqueness {
        let parameters = modes.parameters_with_modes(parameters);
        let resting = resting(&self.indicators, &parameters, at, modes);
        let acts = |effort: Effort| effort.acts_in(modes) || effort.is_of_contact(&resting);
        self.transmissions.uniqueness(&parameters, at, &acts, Yields::AsStated)
    }

    /// Whether there are loops, or several efforts in one joint: otherwise every reaction is unique.
    pub fn may_share_reactions(&self) -> bool {
        self.transmissions.are_shared()
    }

    /// Redundancy: [`CompiledSystem::uniqueness`] with that of the joints alone.
    pub(crate) fn redundancy(
        &self,
        parameters: &[f64],
        at: MovingInstant<'_>,
        modes: &Modes,
    ) -> Redundancy {
        let parameters = modes.parameters_with_modes(parameters);
        let resting = resting(&self.indicators, &parameters, at, modes);
        let acts = |effort: Effort| effort.acts_in(modes) || effort.is_of_contact(&resting);
        self.transmissions.redundancy(&parameters, at, &acts)
    }

    /// A basis of the self-stresses at a position, in these modes.
    pub(crate) fn self_stresses(
        &self,
        parameters: &[f64],
        at: (f64, &[f64]),
        modes: &Modes,
    ) -> Vec<SelfStress> {
        let parameters = modes.parameters_with_modes(parameters);
        self.transmissions.self_stresses(&parameters, at, &|effort| effort.acts_in(modes))
    }

    /// True where joints in loops yield, so that they decide what they share.
    pub fn yields(&self) -> bool {
        self.transmissions.may_yield()
    }

    /// The self-stresses at a position that no joint decides which yields; `parameters` end with modes.
    pub fn open_stresses(&self, parameters: &[f64], at: (f64, &[f64])) -> Vec<SelfStress> {
        let modes = self.modes_among(parameters);
        let acts = |effort: Effort| effort.acts_in(&modes);
        self.transmissions.open_stresses(parameters, at, &acts, Yields::AsStated)
    }

    /// The modes that parameters end with.
    fn modes_among(&self, parameters: &[f64]) -> Modes {
        let modes = self.indicators.modes_from_numbers(&parameters[self.n_parameters..]);
        modes.unwrap_or_else(|| self.indicators.idle())
    }

    /// Brings reactions, and the multipliers of drives, couplings and contacts, to what joints share that yield; `parameters`
    /// end with modes. Efforts that `among` leaves out stay as they are; nothing changes where no joint yields.
    pub fn share(
        &self,
        parameters: &[f64],
        at: (f64, &[f64]),
        among: &dyn Fn(Effort) -> bool,
        (reactions, lambda): (&mut [[f64; 6]], &mut [f64]),
    ) {
        if !self.yields() {
            return;
        }
        let modes = self.modes_among(parameters);
        let acts = |effort: Effort| effort.acts_in(&modes) && among(effort);
        let shared = self.transmissions.shared(parameters, at, &acts, reactions);
        for (joint, six) in &shared.reactions {
            reactions[joint.0].iter_mut().zip(six).for_each(|(own, part)| *own += part);
        }
        for &(effort, part) in &shared.efforts {
            if let Some((row, sign)) = self.row_of(effort) {
                lambda[row] += sign * part;
            }
        }
    }

    /// The constraint row of an effort, and the effort for a multiplier of one.
    pub fn row_of(&self, effort: Effort) -> Option<(usize, f64)> {
        let row = |of: Source| self.sources.iter().position(|source| *source == of);
        match effort {
            Effort::Coupling(coupling) => Some((row(Source::Coupling(coupling))?, 1.0)),
            Effort::Drive(drive) => Some((row(Source::Drive(drive))?, 1.0)),
            Effort::Contact(contact_idx, _) => Some(self.transmissions.contact_row(contact_idx)),
        }
    }

    /// Functions with the values of the inputs by `law`.
    #[must_use]
    pub fn with_law(mut self, law: Arc<Law>) -> Self {
        self.inputs.follow(law);
        self
    }
}

/// T, V, and P = Q · v + λ · ∂g/∂t: constraint forces do the work −λᵀ G v = λᵀ ∂g/∂t.
pub(crate) fn energy_outputs(pool: &Pool, system: &SymbolicSystem) -> [Expr; 3] {
    let loads = system.coordinates().iter().zip(&system.applied_force);
    // A state does no work.
    let loads = loads.filter(|(c, _)| c.kind != CoordinateKind::Integral);
    let drives = system.constraints.iter().zip(&system.constraint_rate);
    let power = loads
        .map(|(c, &force)| pool.mul(force, pool.symbol_expr(c.v)))
        .chain(drives.map(|(c, &rate)| pool.mul(rate, pool.symbol_expr(c.lambda))));
    let power = pool.sum(power.collect::<Vec<_>>());
    [system.kinetic_energy, system.potential_energy, power]
}
