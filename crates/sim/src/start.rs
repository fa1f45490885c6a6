//! The consistent start: positions, velocities, then accelerations and multipliers.
//!
//! Positions are found by damped Gauss–Newton steps of minimum norm on the constraints together
//! with the stated values, from the guesses, and where that does not close, or moves guesses, by a
//! search for the nearest assembly; velocities are the smallest change of the guessed
//! ones that satisfies G v + ∂g/∂t = 0 and the stated rates; accelerations and multipliers follow
//! from the equations of motion. Each level fails with what cannot be met and by how much.

use std::borrow::Cow;

use crate::assembly::Closure;
use crate::compiled::CompiledSystem;
use crate::evaluator::Evaluator;
use crate::hybrid::{
    Bands, ConsistentModes, Instant, consistent_modes_without_impact, latched_modes,
};
use crate::linear::dense::Dependence;
use crate::linear::rank::dependent_rows;
use crate::linear::rows::SparseRows;
use crate::modes::indicators::ContactState;
use crate::modes::{ContactMode, Modes};
use crate::multiplier::{MultiplierSystem, largest};
use crate::pressing::Bearing;
use crate::redundancy::{self, Redundancy, RepeatedCondition, Uniqueness};
use crate::sampled::NoSignal;
pub use crate::start_error::{Conflict, Gap, Moved, Rival, StartError};
use crate::state::{AccelerationRef, State, StateRef};
use bksim_expr::TapeError;
use bksim_mbs::constraint::Source;
use bksim_mbs::system::SymbolicSystem;
use bksim_model::{JointId, Model, SolveOptions};

/// A state that satisfies the constraints at every level.
#[derive(Clone, PartialEq, Debug)]
pub struct Start {
    /// s.
    pub t: f64,
    /// Generalised coordinates, nq.
    pub q: Vec<f64>,
    /// Velocities, nq.
    pub v: Vec<f64>,
    /// Accelerations, nq.
    pub a: Vec<f64>,
    /// Multipliers, nc; the smallest ones when they are not unique, and zero for friction that slides.
    pub lambda: Vec<f64>,
    /// How far each stated or guessed value was moved.
    pub moved: Vec<Moved>,
    /// Largest constraint left open, m or rad.
    pub position_residual: f64,
    /// Largest constraint rate left open, m/s or rad/s.
    pub velocity_residual: f64,
    /// The state that accelerations, multipliers and modes are of.
    pub(crate) state: State,
    /// Rank of the rows that always hold, and which of them depend on others.
    pub(crate) dependence: Dependence,
    /// Rows of open contacts, and rows that follow from others.
    pub(crate) inactive: Vec<usize>,
    /// True if rank is lost there for the instant alone.
    passes_singular: bool,
    /// The branches that hold and the contacts that are closed.
    pub(crate) modes: Modes,
    /// Degrees of freedom without the drives: nq − rank of the joints' rows.
    pub mobility: usize,
    /// Number of independent positions: the mobility where conditions between rates are left out.
    pub mobility_of_positions: usize,
    /// The longest link, m: the measure of how far a guess was moved.
    pub longest_link: f64,
    /// Assemblies nearly as near to the guesses.
    pub rivals: Vec<Rival>,
    /// Which components of the reactions are unique from here on.
    pub uniqueness: Uniqueness,
    /// Which would be if nothing were driven, closed or stuck: the joints among themselves.
    pub(crate) redundancy: Uniqueness,
    /// The conditions of joints and couplings that follow from others.
    pub(crate) repeated: Vec<RepeatedCondition>,
}

impl Start {
    /// Constraint rows that take no part: those of open contacts, and those that follow from others.
    pub fn inactive_rows(&self) -> &[usize] {
        &self.inactive
    }

    /// Rows that follow from the others that always hold.
    pub fn redundant_rows(&self) -> &[usize] {
        &self.dependence.dependent
    }

    /// The values of all parameters of the compiled functions: the model's own, then the modes that hold at
    /// the start, in the order of `SymbolicSystem::parameters`.
    pub fn parameters_with_modes(&self, parameters: &[f64]) -> Vec<f64> {
        self.modes.parameters_with_modes(parameters)
    }

    /// Multipliers as samples have them: those of friction that slides are its forces, which are loads in the
    /// equations and zero in [`Start::lambda`], and those that compliances decide are shared by them.
    pub fn sampled_multipliers(&self, compiled: &CompiledSystem, parameters: &[f64]) -> Vec<f64> {
        let Self { t, q, v, a, modes, .. } = self;
        let all = modes.parameters_with_modes(parameters);
        let mut lambda = self.lambda.clone();
        let mut reactions = vec![[0.0; 6]; compiled.joints.len()];
        let acceleration = AccelerationRef { a, lambda: &self.lambda };
        let mut evaluator = compiled.evaluator(&all);
        evaluator.reactions_into(StateRef { t: *t, q, v }, acceleration, &mut reactions);
        compiled.indicators.at(&all).fill_slip_friction(modes, (*t, q, v), &mut lambda, 0.0);
        compiled.share(&all, (*t, q), &|_| true, (&mut reactions, &mut lambda));
        lambda
    }

    /// True if the start moves through a singular pose: its rows have their rank a little ahead.
    pub fn passes_singular_pose(&self) -> bool {
        self.passes_singular
    }

    /// Constraint rows that take part in a dependency: their multipliers are not unique.
    pub fn not_unique_rows(&self) -> &[usize] {
        &self.dependence.involved
    }
}

/// The conditions of a model's start, compiled once for every parameter value: no expressions, safe
/// to share.
#[derive(Clone, Debug)]
pub struct StartEquations {
    closure: Closure,
    /// Rows that always hold: those of joints and drives.
    n_bilateral: usize,
}

impl StartEquations {
    /// Compiles what `model` says about its start.
    ///
    /// # Errors
    /// [`TapeError`] when an expression of the model cannot be compiled.
    pub fn compile(model: &Model, system: &SymbolicSystem) -> Result<Self, TapeError> {
        let closure = Closure::compile(model, system)?;
        Ok(Self { closure, n_bilateral: system.n_bilateral() })
    }
}

/// Positions of a start, without velocities and forces.
#[derive(Clone, PartialEq, Debug)]
pub struct Closed {
    /// Generalised coordinates, nq.
    pub q: Vec<f64>,
    /// The longest link, m.
    pub longest_link: f64,
    /// Assemblies nearly as near to the guesses.
    pub rivals: Vec<Rival>,
}

/// Closes `model` at `model.solve.t_start`, in positions alone.
///
/// # Errors
/// [`StartError`] says what stands in the way.
pub fn closed(
    model: &Model,
    system: &SymbolicSystem,
    compiled: &CompiledSystem,
    parameters: &[f64],
) -> Result<Closed, StartError> {
    if compiled.nq() == 0 {
        return Err(StartError::NoCoordinates);
    }
    let equations = StartEquations::compile(model, system).map_err(StartError::Compile)?;
    let mut closing = equations.closure.at(parameters, &[]);
    let t = model.solve.t_start;
    let nothing = vec![0.0; compiled.nq()];
    let held = compiled.sampling(parameters).begin(t);
    let modes = compiled.indicators.decided(held, parameters, (t, &nothing, &nothing));
    let mut evaluator = compiled.evaluator(&modes.parameters_with_modes(parameters));
    let (q, rivals) = closing.close_positions(&mut evaluator, t)?;
    Ok(Closed { q, longest_link: closing.longest_link(), rivals })
}

/// Finds the consistent start of `model` at `model.solve.t_start`.
///
/// # Errors
/// [`StartError`] says which level failed and what stands in the way.
pub fn start(
    model: &Model,
    system: &SymbolicSystem,
    compiled: &CompiledSystem,
    parameters: &[f64],
) -> Result<Start, StartError> {
    let equations = StartEquations::compile(model, system).map_err(StartError::Compile)?;
    start_at(&equations, compiled, parameters, &[], &model.solve)
}

/// Start ([`start`]) with what was compiled before; `stated` are initial values, by their places in the
/// model, that take these numbers in SI in place of what the model says.
///
/// # Errors
/// [`StartError`] says which level failed and what stands in the way.
pub fn start_at(
    equations: &StartEquations,
    compiled: &CompiledSystem,
    parameters: &[f64],
    stated: &[(usize, f64)],
    options: &SolveOptions,
) -> Result<Start, StartError> {
    if compiled.nq() == 0 {
        return Err(StartError::NoCoordinates);
    }
    let t = options.t_start;
    let is_reversible = compiled.indicators.is_still() && compiled.sampled.is_empty();
    if options.t_end < t && !is_reversible {
        return Err(StartError::Irreversible);
    }
    if options.too_many().is_some() {
        return Err(StartError::TooMuch);
    }
    let mut closing = equations.closure.at(parameters, stated);
    // Joints and drives follow the branches of each position; no contact is closed yet.
    let nothing = vec![0.0; compiled.nq()];
    let mut sampling = compiled.sampling(parameters);
    if let Some((clock, every)) = sampling.too_many(options) {
        return Err(StartError::TooManyTicks { clock, every });
    }
    let held = sampling.begin(t);
    let mut modes = compiled.indicators.decided(held, parameters, (t, &nothing, &nothing));
    let with_modes = modes.parameters_with_modes(parameters);
    let mut evaluator = compiled.evaluator(&with_modes).branching(&with_modes);

    let (q, rivals) = closing.close_positions(&mut evaluator, t)?;
    let position_residual = largest(evaluator.constraints(t, &q).value);
    let v = closing.fit_velocities(&mut evaluator, t, &q)?;
    let velocity_residual = largest(&evaluator.constraints(t, &q).rate_of(&v));
    let (jacobian, passes_singular) =
        regular_jacobian(&mut evaluator, t, (&q, &v), equations.n_bilateral);
    // Loads follow the branches of the state that was found.
    if !compiled.indicators.is_empty() {
        modes = compiled.indicators.decided(modes.held, parameters, (t, &q, &v));
        evaluator = compiled.evaluator(&modes.parameters_with_modes(parameters));
    }
    let dependence = dependent_rows(&jacobian);
    let shared_axial = shared_multiplier(compiled, &jacobian, dependence.rank);
    let is_joint_row = |row: &usize| compiled.sources[*row].is_geometric();
    let joint_rows: Vec<usize> = (0..compiled.nc()).filter(is_joint_row).collect();
    let joint_rank = dependent_rows(&jacobian.select(&joint_rows)).rank;
    let of_rates = &compiled.shape.of_rates;
    let position_rank = if of_rates.is_empty() {
        joint_rank
    } else {
        let rows: Vec<usize> =
            joint_rows.iter().copied().filter(|row| !of_rates.contains(row)).collect();
        dependent_rows(&jacobian.select(&rows)).rank
    };

    // A tick at the start comes before everything that depends on loads.
    if !compiled.sampled.is_empty() {
        sampling.tick(t, &q, &v, &mut modes.held).map_err(no_signal)?;
        evaluator = compiled.evaluator(&modes.parameters_with_modes(parameters));
    }
    let at = evaluator.dynamics(t, &q, &v);
    if !at.is_finite() {
        return Err(StartError::NotFinite { q, v });
    }
    // Contacts are open until their modes are found: with all of them closed many bodies are one full matrix.
    let contacts = equations.n_bilateral..compiled.nc();
    let inactive: Vec<usize> = dependence.dependent.iter().copied().chain(contacts).collect();
    let mut multipliers = compiled.multiplier_system(&inactive);
    if let Some(coordinates) = multipliers.motion_without_inertia(&at, &jacobian) {
        return Err(StartError::NoInertia { coordinates, q });
    }
    let energy = evaluator.energy(t, &q, &v, &vec![0.0; compiled.nc()]);
    if !(energy.kinetic.is_finite() && energy.potential.is_finite()) {
        return Err(StartError::NotFinite { q, v });
    }
    let moved = closing.moved(t, &q, &v);
    let longest_link = closing.longest_link();
    let mobility = q.len() - joint_rank - compiled.n_states;
    let mobility_of_positions = q.len() - position_rank - compiled.n_states;

    let found = if compiled.indicators.is_still() {
        let state = State { t, q, v };
        completed(&mut evaluator, &mut multipliers, state, modes, &dependence)?
    } else {
        let holding = compiled.latches.none_hold();
        modes_of_start(compiled, parameters, options, (&modes, holding), (t, q, v))?
    };
    let instant = redundancy::MovingInstant { t, q: &found.q, v: &found.v, a: &found.a };
    let Redundancy { uniqueness, of_joints: redundancy, repeated } =
        compiled.redundancy(parameters, instant, &found.modes);
    if let Some(joint) = shared_axial.or_else(|| shared_reaction(compiled, &redundancy)) {
        return Err(StartError::SharedReaction { joint });
    }
    Ok(Start {
        t,
        state: State { t, q: found.q.clone(), v: found.v.clone() },
        uniqueness,
        redundancy,
        repeated,
        q: found.q,
        v: found.v,
        a: found.a,
        lambda: found.lambda,
        moved,
        position_residual,
        velocity_residual,
        dependence,
        inactive: found.inactive,
        modes: found.modes,
        mobility,
        mobility_of_positions,
        longest_link,
        rivals,
        passes_singular,
    })
}

/// A joint whose friction depends on components of its reaction that are not unique.
fn shared_reaction(compiled: &CompiledSystem, redundancy: &Uniqueness) -> Option<JointId> {
    let is_shared = |bearing: &&Bearing| {
        let mut unique = redundancy.reactions[bearing.joint.0].iter().zip(bearing.components);
        let of_coupling = bearing.coupling.is_some_and(|id| !redundancy.couplings[id.0]);
        of_coupling || unique.any(|(is_unique, takes_part)| takes_part && !is_unique)
    };
    compiled.bearings.iter().find(is_shared).map(|bearing| bearing.joint)
}

/// Other reactions ([`shared_reaction`]) that could take the place of a multiplier: its row depends on theirs.
fn shared_multiplier(
    compiled: &CompiledSystem,
    jacobian: &SparseRows,
    rank: usize,
) -> Option<JointId> {
    let rows = &compiled.pressing.as_ref()?.rows;
    // The forces of contacts are found with their modes.
    let is_shared = |&row: &usize| {
        row < jacobian.n_rows() && dependent_rows(&jacobian.without(&[row])).rank == rank
    };
    let shared = rows.iter().copied().find(is_shared)?;
    match compiled.sources[shared] {
        Source::Joint(joint) => Some(joint),
        Source::Coupling(id) => {
            let mut bearings = compiled.bearings.iter();
            bearings.find(|bearing| bearing.coupling == Some(id)).map(|bearing| bearing.joint)
        }
        _ => None,
    }
}

/// The fault of a signal without a value at the start.
fn no_signal(fault: NoSignal) -> StartError {
    StartError::NoConsistentModes(fault.into())
}

/// Accelerations and multipliers at the start of a mechanism in which nothing switches.
fn completed(
    evaluator: &mut Evaluator,
    multipliers: &mut MultiplierSystem,
    State { t, q, v }: State,
    modes: Modes,
    dependence: &Dependence,
) -> Result<ConsistentModes, StartError> {
    let (mut a, mut lambda) = (vec![0.0; q.len()], vec![0.0; evaluator.shape().nc]);
    if multipliers.complete_into(evaluator, t, (&q, &v), &mut a, &mut lambda).is_err() {
        return Err(StartError::NotFinite { q, v });
    }
    let inactive = dependence.dependent.clone();
    Ok(ConsistentModes {
        modes,
        q,
        v,
        a,
        lambda,
        inactive,
        impact_work: 0.0,
        hits: Vec::new(),
        impacts: Vec::new(),
    })
}

impl Start {
    /// This start, or where its time, coordinates or velocities were changed since it was found, one with
    /// the accelerations, multipliers and modes of what they are now.
    ///
    /// # Errors
    /// [`StartError`] when no modes are consistent, a load has no value, or a body lies beyond a stop.
    pub(crate) fn up_to_date<'a>(
        &'a self,
        compiled: &CompiledSystem,
        parameters: &[f64],
        options: &SolveOptions,
    ) -> Result<Cow<'a, Self>, StartError> {
        let Self { t, q, v, state, .. } = self;
        if (*t, q, v) == (state.t, &state.q, &state.v) {
            return Ok(Cow::Borrowed(self));
        }
        let state = State { t: *t, q: q.clone(), v: v.clone() };
        let mut sampling = compiled.sampling(parameters);
        let mut held = sampling.begin(*t);
        sampling.tick(*t, q, v, &mut held).map_err(no_signal)?;
        let modes = compiled.indicators.decided(held, parameters, (*t, q, v));
        let before = (&modes, compiled.latches.none_hold());
        self.going_on(compiled, parameters, options, state, before).map(Cow::Owned)
    }

    /// The start of a motion that goes on from a state of the one that started here, in which `before` are
    /// the modes and the conditions that held, with other values of parameters that only loads depend on.
    ///
    /// # Errors
    /// [`StartError`] when no modes are consistent, or a load has no value.
    pub(crate) fn going_on(
        &self,
        compiled: &CompiledSystem,
        parameters: &[f64],
        options: &SolveOptions,
        state: State,
        (before, holding): (&Modes, Vec<bool>),
    ) -> Result<Self, StartError> {
        let State { t, q, v } = state;
        let found = if compiled.indicators.is_empty() {
            let mut evaluator = compiled.evaluator(&before.parameters_with_modes(parameters));
            let mut multipliers = compiled.multiplier_system(&self.dependence.dependent);
            let state = State { t, q, v };
            completed(&mut evaluator, &mut multipliers, state, before.clone(), &self.dependence)?
        } else {
            modes_of_start(compiled, parameters, options, (before, holding), (t, q, v))?
        };
        let ConsistentModes { modes, q, v, a, lambda, inactive, .. } = found;
        let state = State { t, q: q.clone(), v: v.clone() };
        let instant = redundancy::MovingInstant { t, q: &q, v: &v, a: &a };
        let uniqueness = compiled.uniqueness(parameters, instant, &modes);
        Ok(Self { t, q, v, a, lambda, state, inactive, modes, uniqueness, ..self.clone() })
    }
}

/// The first `n_rows` rows of G at the start, or, where rank is lost there for an instant, at a state
/// a little ahead; true if it is.
fn regular_jacobian(
    evaluator: &mut Evaluator,
    t: f64,
    (q, v): (&[f64], &[f64]),
    n_rows: usize,
) -> (SparseRows, bool) {
    /// Part of a radian, or of a metre.
    const AHEAD: f64 = 1e-4;
    let first: Vec<usize> = (0..n_rows).collect();
    let jacobian = evaluator.constraints(t, q).jacobian_rows().select(&first);
    let fastest = largest(v);
    let is_full = dependent_rows(&jacobian).dependent.is_empty();
    if is_full || fastest == 0.0 {
        return (jacobian, false);
    }
    let ahead = AHEAD / fastest;
    let q: Vec<f64> = q.iter().zip(v).map(|(q, v)| q + ahead * v).collect();
    let there = evaluator.constraints(t + ahead, &q).jacobian_rows().select(&first);
    let ranks = [&jacobian, &there].map(|rows| dependent_rows(rows).rank);
    let is_lost = ranks[1] > ranks[0];
    (if is_lost { there } else { jacobian }, is_lost)
}

/// Branches and contacts of the start; bodies that run into a stop do so in the run.
fn modes_of_start(
    compiled: &CompiledSystem,
    parameters: &[f64],
    options: &SolveOptions,
    (before, holding): (&Modes, Vec<bool>),
    (t, q, v): (f64, Vec<f64>, Vec<f64>),
) -> Result<ConsistentModes, StartError> {
    const BEYOND: f64 = 1e-9;
    let values =
        compiled.indicators.at(&before.parameters_with_modes(parameters)).values(t, &q, &v).clone();
    let size = q.iter().fold(1.0, |size: f64, value| size.max(value.abs()));
    for (contact, state) in compiled.indicators.contacts.iter().zip(&values.contacts) {
        if let ContactState::Stop { penetration, reach, .. } = *state
            && penetration > BEYOND * size
            && reach > 0.0
        {
            return Err(StartError::BeyondStop { load: contact.load, by: penetration });
        }
    }
    let bands = Bands::new((options.atol, options.rtol), &values, &compiled.indicators);
    // Outlines that are stated to touch do, whatever rounding makes of their places.
    let mut before = before.clone();
    for (k, state) in values.contacts.iter().enumerate() {
        if let ContactState::Stop { penetration, rate, reach, .. } = *state
            && compiled.indicators.contacts[k].is_outline
            && penetration > -BEYOND * size
            && reach > 0.0
            && bands.is_at_rest(rate)
        {
            before.contacts[k] = ContactMode::Closed;
        }
    }
    // Functions that are zero up to rounding are: conditions on them are as written unless the motion leads away.
    for (k, u) in values.kinks.iter().enumerate() {
        if !compiled.indicators.is_of_multipliers(k) && u.abs() <= bands.kinks[k] {
            before.signs[k] = compiled.indicators.at_zero[k];
        }
    }
    let before = &before;
    let instant = Instant { compiled, parameters, t, q, v, before, fired: &[], bands };
    latched_modes(instant, holding, consistent_modes_without_impact)
        .map_err(StartError::NoConsistentModes)
}
