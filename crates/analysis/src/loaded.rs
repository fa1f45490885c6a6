//! [`Loaded`]: a mechanism at its start with masses and loads, and what holds there.

use bksim_expr::SymbolId;
use bksim_mbs::constraint::Source;
use bksim_mbs::contact::Law;
use bksim_mbs::coordinate::CoordinateKind;
use bksim_mbs::modes::with_branches;
use bksim_mbs::system::{Switch, SwitchOf, SymbolicSystem};
use bksim_model::diagnostic::{Diagnostic, Rejected, Span};
use bksim_model::{
    Body, CouplingKind, HeldChange, HeldSignal, JointId, Measure, Model, ParameterId, Shape,
};
use bksim_sim::Mechanism;
use bksim_sim::redundancy::{Effort, Uniqueness};

use crate::codes;
use crate::drive::{DriveRate, Range};
use crate::error::AnalysisError;
use crate::quantity::{PoseQuantity, pose_quantities};
use crate::rows::{Clock, Rows};
use crate::scalar::{Rates, Scalars};

/// A mechanism with masses and loads at its start; stops that are closed there and friction that sticks
/// count as constraints.
#[derive(Debug)]
pub struct Loaded {
    pub(crate) mechanism: Mechanism,
    /// Equations of the mechanism, in which kinks take the branch of each state.
    system: SymbolicSystem,
    /// Time of the start, s.
    pub(crate) t: f64,
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) a: Vec<f64>,
    /// Multipliers of all rows.
    pub(crate) lambda: Vec<f64>,
    /// Values of `SymbolicSystem::parameters`.
    pub(crate) parameters: Vec<f64>,
    /// Constraint rows that hold.
    pub(crate) kept: Vec<usize>,
    /// The longest link, m.
    pub(crate) size: f64,
    /// Forces that are unique; empty where the start does not say.
    pub(crate) unique: Uniqueness,
    pub(crate) quantities: Vec<PoseQuantity>,
    /// True where the efforts of drives are known: what joints share leaves them as they are.
    is_driven: bool,
    /// True where dry friction that slides at the start is left out: at rest it has no direction.
    is_still: bool,
    /// True where the mechanism can move steadily with its drives: an answer at rest is in the frame that they move.
    pub(crate) turns: bool,
}

/// Contacts and drives that count as constraints, and what an answer at rest leaves out.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct HeldContacts {
    /// Stops, and dry friction that sticks, as `stop `NAME``.
    pub rows: Vec<String>,
    /// Dry friction that is left out: as long as it holds, more poses are in balance.
    pub left_out: Vec<String>,
    /// Drives at constant rates, with which all else is at rest.
    pub steady: Vec<DriveRate>,
    /// Drives that are held where they are at the start, and whose rates there are left out.
    pub stopped: Vec<DriveRate>,
}

impl Loaded {
    /// Finds the start of `model`, which may have states.
    ///
    /// # Errors
    /// [`AnalysisError::Rejected`] when there is none, or a signal is sampled or latched.
    pub fn of(mut model: Model) -> Result<Self, AnalysisError> {
        without_memory(&model)?;
        model.forget_turns();
        Self::at_start(Mechanism::derive(model, Vec::new())?)
    }

    /// Finds the start of `model` for questions about rest, without dry friction that slides there.
    ///
    /// # Errors
    /// [`AnalysisError::Rejected`] as of [`Loaded::of`].
    pub(crate) fn at_rest(model: Model) -> Result<Self, AnalysisError> {
        let mut found = Self::of(model)?;
        found.put_at_rest()?;
        Ok(found)
    }

    /// Leaves out the dry friction that slides at the start and all rates but those of a steady motion with the drives.
    pub(crate) fn put_at_rest(&mut self) -> Result<(), AnalysisError> {
        self.leave_out_sliding();
        self.turns = self.moves_steadily()?;
        Ok(())
    }

    /// Leaves out the dry friction that slides at the start, from here on.
    fn leave_out_sliding(&mut self) {
        self.is_still = true;
        let symbols = self.system.parameters(&self.mechanism.model);
        let slips = self.system.contacts.iter().filter_map(|contact| match contact.law {
            Law::Friction { slip, .. } => Some(slip),
            Law::Stop { .. } => None,
        });
        let slips: Vec<SymbolId> = slips.collect();
        for (value, symbol) in self.parameters.iter_mut().zip(symbols) {
            if slips.contains(&symbol) {
                *value = 0.0;
            }
        }
        // As expressions, too: slopes of a reaction's size are no numbers where the reaction is zero.
        let pool = &self.mechanism.model.pool;
        let rest: Vec<_> = slips.iter().map(|slip| (*slip, pool.zero())).collect();
        self.system.applied_force = pool.substitute_all(&self.system.applied_force, &rest);
    }

    /// Finds the start of `mechanism`.
    fn at_start(mechanism: Mechanism) -> Result<Self, AnalysisError> {
        let system = with_branches(&mechanism.model.pool, &mechanism.system);
        let quantities = pose_quantities(&mechanism.model, &mechanism.system);
        let t = mechanism.model.solve.t_start;
        let n_rows = system.constraints.len();
        let mut found = Self {
            t,
            q: Vec::new(),
            v: Vec::new(),
            a: Vec::new(),
            lambda: vec![0.0; n_rows],
            parameters: mechanism.parameters.clone(),
            kept: (0..n_rows).collect(),
            size: 1.0,
            unique: Uniqueness::default(),
            quantities,
            is_driven: false,
            is_still: false,
            turns: false,
            mechanism,
            system,
        };
        found.find_start()?;
        Ok(found)
    }

    /// Finds the start again with other values of the model's parameters; without one all stays as it was.
    pub(crate) fn restart(&mut self, parameters: &[f64]) -> Result<(), AnalysisError> {
        let own = std::mem::replace(&mut self.mechanism.parameters, parameters.to_vec());
        let found = self.find_start();
        if found.is_err() {
            self.mechanism.parameters = own;
        }
        found
    }

    fn find_start(&mut self) -> Result<(), AnalysisError> {
        let mechanism = &self.mechanism;
        let system = mechanism.system.integrated();
        let is_switch = |switch: &Switch| switch.of != SwitchOf::Multipliers;
        let switches = !system.contacts.is_empty() || system.switches.iter().any(is_switch);
        let n_rows = system.constraints.len();
        // Without anything that switches the start needs no accelerations, and so no inertia.
        let moving = if switches { Some(mechanism.start()?) } else { mechanism.start().ok() };
        let size = if let Some(start) = moving {
            let holds = |row: &usize| {
                !system.constraints[*row].source.is_contact()
                    || !start.inactive_rows().contains(row)
            };
            self.kept = (0..n_rows).filter(holds).collect();
            self.parameters = start.parameters_with_modes(&mechanism.parameters);
            self.unique.clone_from(&start.uniqueness);
            (self.q, self.v, self.a, self.lambda) = (start.q, start.v, start.a, start.lambda);
            start.longest_link
        } else {
            let closed = mechanism.closed()?;
            let rest = vec![0.0; closed.q.len()];
            self.kept = (0..n_rows).collect();
            self.parameters.clone_from(&mechanism.parameters);
            (self.q, self.v, self.a, self.lambda) =
                (closed.q, rest.clone(), rest, vec![0.0; n_rows]);
            closed.longest_link
        };
        self.size = if size > 0.0 { size } else { 1.0 };
        if self.is_still {
            self.leave_out_sliding();
        }
        Ok(())
    }

    /// `mechanism` at rest in a position that is known; what switches is as it is at rest, no contact closed.
    pub(crate) fn at_position(
        mechanism: Mechanism,
        positions: &crate::positions::Positions,
    ) -> Self {
        let system = with_branches(&mechanism.model.pool, &mechanism.system);
        let is_bilateral = |row: &usize| !system.constraints[*row].source.is_contact();
        let kept = (0..system.constraints.len()).filter(is_bilateral).collect();
        let parameters = mechanism.compiled.idle_parameters(&mechanism.parameters);
        // Integrals of states come after the coordinates that move.
        let rest = vec![0.0; system.coordinates().len()];
        let mut q = positions.q.clone();
        q.resize(rest.len(), 0.0);
        Self {
            t: positions.t(),
            q,
            v: rest.clone(),
            a: rest,
            lambda: vec![0.0; system.constraints.len()],
            parameters,
            kept,
            size: positions.size,
            unique: Uniqueness::default(),
            quantities: Vec::new(),
            is_driven: true,
            is_still: false,
            turns: false,
            mechanism,
            system,
        }
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.mechanism.model
    }

    pub(crate) fn system(&self) -> &SymbolicSystem {
        &self.system
    }

    /// Contacts and drives that count as constraints, and those that are left out.
    pub fn held_contacts(&self) -> HeldContacts {
        let (model, rows) = (self.model(), &self.system.constraints);
        let name = |&row: &usize| match rows[row].source {
            Source::Stop(load) => Some(format!("stop `{}`", model.loads[load.0].name)),
            Source::Friction(load) => Some(format!("friction `{}`", model.loads[load.0].name)),
            _ => None,
        };
        let is_left_out = |row: &usize| {
            self.is_still
                && matches!(rows[*row].source, Source::Friction(_))
                && !self.kept.contains(row)
        };
        let drives = if self.is_still { self.moving_drives() } else { Vec::new() };
        let [steady, stopped] =
            if self.turns { [drives, Vec::new()] } else { [Vec::new(), drives] };
        HeldContacts {
            steady,
            stopped,
            rows: self.kept.iter().filter_map(name).collect(),
            left_out: (0..rows.len()).filter(is_left_out).filter_map(|row| name(&row)).collect(),
        }
    }

    /// Holds the rows of the contacts that are closed by the parameters, but for `dependent` ones.
    pub(crate) fn keep_active(&mut self, dependent: &[usize]) {
        let is_active = |row: &usize| {
            let contact = self.system.contacts.iter().find(|contact| contact.row == *row);
            contact.is_none_or(|contact| {
                self.value_of(contact.closed) == Some(1.0) && !dependent.contains(row)
            })
        };
        self.kept = (0..self.system.constraints.len()).filter(is_active).collect();
    }

    /// An answer with the constraint row of one more contact held.
    pub(crate) fn with_closed<T>(&mut self, row: usize, answer: impl FnOnce(&Self) -> T) -> T {
        let (kept, parameters) = (self.kept.clone(), self.parameters.clone());
        let mode = self.system.contacts.iter().find(|contact| contact.row == row);
        let mode = mode.map(|contact| contact.closed);
        let symbols = self.system.parameters(self.model());
        for (value, symbol) in self.parameters.iter_mut().zip(symbols) {
            if Some(symbol) == mode {
                *value = 1.0;
            }
        }
        self.kept.push(row);
        self.kept.sort_unstable();
        let answer = answer(self);
        (self.kept, self.parameters) = (kept, parameters);
        answer
    }

    /// Coordinates whose velocities are states.
    pub(crate) fn state_coordinates(&self) -> Vec<usize> {
        let coordinates = self.system().coordinates().iter().enumerate();
        coordinates.filter(|(_, c)| c.kind == CoordinateKind::Integral).map(|(i, _)| i).collect()
    }

    pub(crate) fn rows(&self) -> Result<Rows, AnalysisError> {
        let numbers = (self.parameters.as_slice(), self.size, Clock::Held);
        Ok(Rows::compile(self.model(), self.system(), &[], &self.kept, numbers)?)
    }

    pub(crate) fn scalars(&self, quantities: &[PoseQuantity]) -> Result<Scalars, AnalysisError> {
        let functions: Vec<_> = quantities.iter().map(|quantity| quantity.value).collect();
        Ok(Scalars::compile(self.model(), self.system(), &functions, &self.parameters)?)
    }

    pub(crate) fn rates(&self, quantities: &[PoseQuantity]) -> Result<Rates, AnalysisError> {
        let functions: Vec<_> = quantities.iter().map(|quantity| quantity.value).collect();
        Ok(Rates::compile(self.model(), self.system(), &functions, &self.parameters)?)
    }

    /// The parameter of this name.
    pub(crate) fn parameter(&self, name: &str) -> Result<ParameterId, AnalysisError> {
        let found = self.model().parameters.iter().position(|p| p.name == name);
        found
            .map(ParameterId)
            .ok_or_else(|| AnalysisError::UnknownParameter { name: name.to_owned() })
    }

    /// Values of the parameters of an expression.
    pub(crate) fn value_of(&self, symbol: SymbolId) -> Option<f64> {
        let symbols = self.system.parameters(self.model());
        let at = symbols.iter().position(|own| *own == symbol)?;
        self.parameters.get(at).copied()
    }

    /// Values of all parameters when `free` ones have the values `p`: what the model defines by them follows.
    pub(crate) fn parameters_with(&self, free: &[ParameterId], p: &[f64]) -> Vec<f64> {
        let mut values = self.parameters.clone();
        let own = varied(self.model(), &values, free, p);
        values[..own.len()].copy_from_slice(&own);
        values
    }

    /// Joint reactions, six numbers each: force, then moment, on the second body, world axes; where joints yield,
    /// what they share, as which the multipliers of drives and contacts change, too.
    pub(crate) fn reactions(
        &self,
        t: f64,
        parameters: &[f64],
        [q, v, a]: [&[f64]; 3],
        lambda: &mut [f64],
    ) -> Vec<[f64; 6]> {
        use bksim_sim::state::{AccelerationRef, StateRef};
        let mut out = Vec::new();
        let compiled = &self.mechanism.compiled;
        let parameters = compiled.branches_at(parameters, StateRef { t, q, v });
        let mut evaluator = compiled.evaluator(&parameters);
        let (state, rates) = (StateRef { t, q, v }, AccelerationRef { a, lambda });
        evaluator.reactions_into(state, rates, &mut out);
        let among = |effort: Effort| !(self.is_driven && matches!(effort, Effort::Drive(_)));
        compiled.share(&parameters, (t, q), &among, (&mut out, lambda));
        out
    }
}

/// The values of the model's parameters, of which `free` ones have the values `p` and those that are defined by
/// them follow; the others keep theirs.
pub(crate) fn varied(model: &Model, values: &[f64], free: &[ParameterId], p: &[f64]) -> Vec<f64> {
    let pool = &model.pool;
    let mut values = values[..model.parameters.len()].to_vec();
    let mut changed: Vec<usize> = Vec::new();
    for (id, p) in free.iter().zip(p) {
        values[id.0] = *p;
        changed.push(id.0);
    }
    // Each comes after those that its definition uses.
    for (idx, parameter) in model.parameters.iter().enumerate() {
        let symbols = pool.symbols_of(parameter.definition);
        let follows =
            symbols.iter().any(|s| changed.iter().any(|&k| model.parameters[k].symbol == *s));
        if free.contains(&ParameterId(idx)) || !follows {
            continue;
        }
        let value = |symbol| {
            let at = model.parameters.iter().position(|other| other.symbol == symbol)?;
            Some(values[at])
        };
        if let Ok(value) = pool.evaluate(parameter.definition, &value) {
            values[idx] = value;
            changed.push(idx);
        }
    }
    values
}

/// Refuses a model whose loads are not known along a given motion: with latched signals, with sampled ones where time runs
/// backward, or with loads that depend on reactions.
///
/// # Errors
/// [`AnalysisError::Rejected`] with the first of them.
pub(crate) fn known_along_a_motion(model: &Model, times: &Range) -> Result<(), AnalysisError> {
    if times.to < times.from {
        return without_memory(model);
    }
    let is_latched = |signal: &&HeldSignal| matches!(signal.change, HeldChange::Event { .. });
    let latched = model.held.iter().find(is_latched);
    latched.map_or(Ok(()), |signal| Err(remembers(signal)))?;
    without_reactions(model)
}

/// Refuses a model with signals that remember what was before, or with loads that depend on reactions.
///
/// # Errors
/// [`AnalysisError::Rejected`] with the first of them.
pub(crate) fn without_memory(model: &Model) -> Result<(), AnalysisError> {
    let remembering = model.held.iter().find(|signal| !signal.is_count());
    remembering.map_or(Ok(()), |signal| Err(remembers(signal)))?;
    without_contacts(model)?;
    without_reactions(model)
}

/// Refuses a model with conditions on rates, which positions alone do not keep.
///
/// # Errors
/// [`AnalysisError::Rejected`] with the first of them.
pub(crate) fn without_rates(model: &Model) -> Result<(), AnalysisError> {
    without_contacts(model)?;
    let joint = model.joints.iter().find(|joint| joint.kind.n_rates() > 0);
    let joint = joint.map(|joint| (format!("joint `{}`", joint.name), &joint.span));
    let condition = model.couplings.iter().find(|of| of.kind == CouplingKind::Rate);
    let condition = condition.map(|of| (format!("condition `{}`", of.name), &of.span));
    let Some((what, span)) = joint.or(condition) else { return Ok(()) };
    let note = "it holds between rates and leaves every position free, so that positions do not follow from each other";
    let help = "solve the motion in time, or ask for linear equations about the start: `bksim linearize --at start`";
    Err(refused((what, span, "a condition on rates"), note, help))
}

/// Refuses a model with contacts: which of them bear follows from the motion alone.
///
/// # Errors
/// [`AnalysisError::Rejected`] with the first of them.
pub fn without_contacts(model: &Model) -> Result<(), AnalysisError> {
    let Some(contact) = model.contacts.first() else { return Ok(()) };
    let note = "its outlines touch, part and rub as the motion brings them together; only a run follows that";
    let help = if matches!(contact.shapes[0], Shape::Curve { .. }) {
        "solve the motion in time, or remove `lifts`"
    } else if contact.play_of.is_some() {
        "solve the motion in time, or remove `clearance`"
    } else {
        "solve the motion in time, or put joints and loads of type \"stop\" in place of the contact"
    };
    let what = format!("contact `{}`", contact.name);
    Err(refused((what, &contact.span, "outlines that may touch"), note, help))
}

/// Refuses a beam whose shapes nothing prescribes: `free` are the positions of joints that are left.
///
/// # Errors
/// [`AnalysisError::Rejected`] with the first of them.
pub(crate) fn without_free_shapes(model: &Model, free: &[String]) -> Result<(), AnalysisError> {
    let is_free = |id: JointId| {
        let positions = free.iter().filter_map(|name| name.split_once('.'));
        { positions }.any(|(joint, _)| joint == model.joints[id.0].name)
    };
    let bends = |body: &&Body| body.flexible.iter().any(|beam| beam.shapes().any(is_free));
    let Some(body) = model.bodies.iter().find(bends) else { return Ok(()) };
    let note = "how it bends follows from its forces, not from the motion that is given";
    let help = "solve the motion in time with drives, or give the body `mass`, `com` and `inertia` in place of `flexible`";
    let what = format!("body `{}`", body.name);
    Err(refused((what, &body.span, "it bends"), note, help))
}

/// A signal that is held, as a fault.
fn remembers(signal: &HeldSignal) -> AnalysisError {
    let note = "between two instants such a signal follows from the past, not from the state alone";
    match signal.change {
        HeldChange::Tick { .. } => {
            let help = "leave out its `clock`, or give it a value as a parameter";
            let what = format!("sampled signal `{}`", signal.name);
            refused((what, &signal.span, "held from tick to tick"), note, help)
        }
        HeldChange::Event { .. } | HeldChange::HalfTurn { .. } => {
            let help = "leave it out, or give it a value as a parameter";
            let what = format!("latched signal `{}`", signal.name);
            refused((what, &signal.span, "held between events"), note, help)
        }
    }
}

fn without_reactions(model: &Model) -> Result<(), AnalysisError> {
    let reaction = model.signals.iter().find_map(|signal| match signal.measure {
        Measure::Reaction(JointId(joint), ..) if model.acts(signal) => Some(&model.joints[joint]),
        _ => None,
    });
    let Some(joint) = reaction else { return Ok(()) };
    let help = "leave out the loads and signals that use its reaction";
    let note = "equilibria, small motions and efforts are those of bodies, joints and loads alone";
    let what = format!("the reaction of joint `{}` in expressions", joint.name);
    Err(refused((what, &joint.span, "found together with the accelerations"), note, help))
}

fn refused((what, span, label): (String, &Span, &str), note: &str, help: &str) -> AnalysisError {
    let message = format!("this question cannot be asked with {what}");
    let fault = Diagnostic::error(codes::WITH_STATES, message)
        .at(span.clone(), label)
        .note(note)
        .help(help);
    Rejected(vec![fault]).into()
}
