//! The channels of a run: its topics with their fields, and the values of a sample in them.

use std::ops::Range;

use bksim_expr::SymbolId;
use bksim_log::{Field, SHORT, Topic};
use bksim_mbs::constraint::{Constraint, Source};
use bksim_model::{Frame, Load, Measure, Model, MotionKind, NamedSignal, ParameterId};
use bksim_sim::Mechanism;
use bksim_sim::redundancy::Uniqueness;
use bksim_sim::run::Sample;

/// The topic of the [inputs](bksim_sim::input).
pub const INPUTS: &str = "/inputs";

/// The topics of a log, and the part of a sample that fills each.
#[derive(Clone, PartialEq, Debug)]
pub struct Channels {
    pub(crate) topics: Vec<(Topic, TopicKind)>,
    /// Rows of the couplings.
    couplings: Range<usize>,
    /// The number of ropes that may become slack, whose rows are the last.
    n_ropes: usize,
    /// Rows of the drives.
    drives: Range<usize>,
    /// Named expressions that are signals; those after them are outputs.
    n_signals: usize,
    /// The part of the mechanism that each multiplier is a force of.
    rows: Vec<RowKind>,
    /// The forces that each named expression depends on.
    forces: Vec<Vec<ForceKind>>,
}

/// A force that a named expression depends on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum ForceKind {
    /// Of a joint, with the first and the last component of its reaction that it may follow.
    Reaction(usize, [usize; 2]),
    /// The effort of a drive.
    Drive(usize),
    /// Of a coupling.
    Coupling(usize),
    /// The pull of a rope that may become slack.
    Rope(usize),
}

/// The part of the mechanism that a multiplier is a force of.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum RowKind {
    /// Of a joint, with the first and the last component of its reaction that it may be part of.
    Joint(usize, [usize; 2]),
    Quaternion,
    Coupling(usize),
    Drive(usize),
    Contact(usize),
}

/// The largest number of values of a topic that do not lie in the sample as they are.
pub(crate) const N_MADE: usize = 10;

/// The part of a sample that fills a topic.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum TopicKind {
    State,
    Acceleration,
    Multipliers,
    Reaction(usize),
    Couplings,
    Drives,
    Inputs,
    Signals,
    Outputs,
    Energy,
    Solver,
}

/// A value of a sample: a topic of [`Channels`] and a field of it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Signal {
    topic_idx: usize,
    field_idx: usize,
}

impl Channels {
    /// The channels of a mechanism's runs.
    pub fn new(mechanism: &Mechanism) -> Self {
        // Rows of joints come first, then those of couplings, of drives, and of stops and friction.
        let end = mechanism.system.n_bilateral();
        let drives = end - mechanism.compiled.drives.len()..end;
        let couplings = drives.start - mechanism.compiled.couplings.len()..drives.start;
        let n_bilateral = end;
        let row = |(row, constraint): (usize, &Constraint)| match constraint.source {
            Source::Joint(joint) => RowKind::Joint(joint.0, components(constraint.direction)),
            Source::Quaternion(_) => RowKind::Quaternion,
            Source::Coupling(coupling) => RowKind::Coupling(coupling.0),
            Source::Drive(drive) => RowKind::Drive(drive.0),
            Source::Stop(_) | Source::Friction(_) => RowKind::Contact(row - n_bilateral),
        };
        let rows = mechanism.system.constraints.iter().enumerate().map(row).collect();
        let n_signals = mechanism.model.named_signals.iter().filter(|s| !s.is_output).count();
        let forces = forces(&mechanism.model);
        let n_ropes = mechanism.model.loads.iter().filter(|load| load.is_coupling()).count();
        Self { topics: topics(mechanism), couplings, n_ropes, drives, n_signals, rows, forces }
    }

    /// The signals that have a value at every instant, with their names and fields: all but what a
    /// run gathers on its way.
    pub fn signals(&self) -> impl Iterator<Item = (Signal, String, &Field)> {
        self.topics.iter().enumerate().flat_map(|(topic_idx, (topic, of))| {
            let fields = topic.fields.iter().enumerate();
            let lasting = fields.filter(|(_, field)| of.is_lasting(field));
            lasting.map(move |(field_idx, field)| {
                (Signal { topic_idx, field_idx }, topic.column_name(field), field)
            })
        })
    }

    /// The signal of this name, such as `state.A_angle`, or of an output or a signal without its topic, if it has a
    /// value at every instant.
    pub fn signal(&self, name: &str) -> Option<Signal> {
        let is_it = |known: &str| known == name;
        let found = self.signals().find(|(_, known, _)| is_it(known));
        let in_short = |topic: &str| {
            let name = format!("{topic}.{name}");
            self.signals().find(|(_, known, _)| *known == name)
        };
        let found = found.or_else(|| SHORT.iter().find_map(|topic| in_short(topic)));
        found.map(|(signal, ..)| signal)
    }

    /// Value in a sample; NaN in a sample that was not filled yet.
    pub fn value(&self, signal: Signal, sample: &Sample) -> f64 {
        let mut made = [0.0; N_MADE];
        let [first, second] = self.values(self.topics[signal.topic_idx].1, sample, &mut made);
        let in_second = signal.field_idx.checked_sub(first.len());
        let value = in_second.map_or_else(|| first.get(signal.field_idx), |idx| second.get(idx));
        value.copied().unwrap_or(f64::NAN)
    }

    /// True if a signal is the same in every solution of the equilibrium; only reactions, efforts and
    /// multipliers may not be.
    pub fn is_unique(&self, signal: Signal, uniqueness: &Uniqueness) -> bool {
        let Signal { topic_idx, field_idx } = signal;
        match self.topics[topic_idx].1 {
            TopicKind::Reaction(joint) => uniqueness.reactions[joint][field_idx],
            TopicKind::Couplings => match field_idx.checked_sub(uniqueness.couplings.len()) {
                None => uniqueness.couplings[field_idx],
                Some(rope) => self.is_rope_unique(rope, uniqueness),
            },
            TopicKind::Drives => uniqueness.drives[field_idx],
            TopicKind::Signals => self.is_named_unique(field_idx, uniqueness),
            TopicKind::Outputs => self.is_named_unique(self.n_signals + field_idx, uniqueness),
            TopicKind::Multipliers => match self.rows[field_idx] {
                RowKind::Joint(joint, [first, last]) => {
                    uniqueness.reactions[joint][first..=last].iter().all(|&is_unique| is_unique)
                }
                RowKind::Quaternion => true,
                RowKind::Coupling(coupling) => uniqueness.couplings[coupling],
                RowKind::Drive(drive) => uniqueness.drives[drive],
                RowKind::Contact(contact) => uniqueness.contacts[contact],
            },
            _ => true,
        }
    }

    /// True if the pull of a rope that may become slack is unique: its row is among the last.
    fn is_rope_unique(&self, rope: usize, uniqueness: &Uniqueness) -> bool {
        uniqueness.contacts[uniqueness.contacts.len() - self.n_ropes + rope]
    }

    /// True where all forces that a named expression depends on are unique.
    fn is_named_unique(&self, named_idx: usize, uniqueness: &Uniqueness) -> bool {
        self.forces[named_idx].iter().all(|force| match *force {
            ForceKind::Reaction(joint, [first, last]) => {
                uniqueness.reactions[joint][first..=last].iter().all(|&is_unique| is_unique)
            }
            ForceKind::Drive(drive) => uniqueness.drives[drive],
            ForceKind::Coupling(coupling) => uniqueness.couplings[coupling],
            ForceKind::Rope(rope) => self.is_rope_unique(rope, uniqueness),
        })
    }

    /// Names of the signals that are not unique: `reactions.A.fx`.
    pub fn not_unique(&self, uniqueness: &Uniqueness) -> Vec<String> {
        if uniqueness.is_complete() {
            return Vec::new();
        }
        let shared = self.signals().filter(|&(signal, ..)| !self.is_unique(signal, uniqueness));
        shared.map(|(_, name, _)| name).collect()
    }

    /// The values of a topic, in two parts: as they lie in the sample, or made from it.
    pub(crate) fn values<'a>(
        &self,
        of: TopicKind,
        sample: &'a Sample,
        made: &'a mut [f64; N_MADE],
    ) -> [&'a [f64]; 2] {
        let Sample { q, v, a, lambda, reactions, inputs, signals, energy, stats, .. } = sample;
        match of {
            TopicKind::State => [q, v],
            TopicKind::Acceleration => [a, &[]],
            TopicKind::Multipliers => [lambda, &[]],
            TopicKind::Reaction(joint) => [&reactions[joint], &[]],
            // The multipliers of the rows of couplings and drives are their forces.
            // Ropes that may become slack come last.
            TopicKind::Couplings => {
                [&lambda[self.couplings.clone()], &lambda[lambda.len() - self.n_ropes..]]
            }
            TopicKind::Drives => [&lambda[self.drives.clone()], &[]],
            TopicKind::Inputs => [inputs, &[]],
            // A sample that was not filled yet has none.
            TopicKind::Signals => [signals.get(..self.n_signals).unwrap_or_default(), &[]],
            TopicKind::Outputs => [signals.get(self.n_signals..).unwrap_or_default(), &[]],
            TopicKind::Energy => {
                let total = energy.kinetic + energy.potential;
                let five = [energy.kinetic, energy.potential, total, sample.work, energy.power];
                made[..5].copy_from_slice(&five);
                [&made[..5], &[]]
            }
            #[expect(clippy::cast_precision_loss, reason = "counters stay far below 2^53")]
            TopicKind::Solver => {
                *made = [
                    sample.step_size,
                    sample.position_residual[1],
                    sample.velocity_residual[1],
                    sample.position_residual[0],
                    sample.velocity_residual[0],
                    stats.n_step as f64,
                    stats.n_reject as f64,
                    stats.n_newton as f64,
                    stats.n_jacobian as f64,
                    stats.n_factor as f64,
                ];
                [made, &[]]
            }
        }
    }
}

/// The components of a reaction that a row of this direction is part of, first and last.
fn components(direction: &str) -> [usize; 2] {
    match direction {
        "x" => [0, 0],
        "y" => [1, 1],
        "z" => [2, 2],
        "angle" => [3, 5],
        _ => [0, 2],
    }
}

impl TopicKind {
    /// True if a field has a value at every instant.
    pub(crate) fn is_lasting(self, field: &Field) -> bool {
        match self {
            Self::Energy => field.name != "work",
            Self::Solver => false,
            _ => true,
        }
    }
}

/// The forces that each named expression depends on.
fn forces(model: &Model) -> Vec<Vec<ForceKind>> {
    let force = |measure: Measure| match measure {
        Measure::Reaction(joint, Frame::World, k) => Some(ForceKind::Reaction(joint.0, [k, k])),
        // Along the joint's axes a component has parts of all three.
        Measure::Reaction(joint, Frame::Body, k) => {
            Some(ForceKind::Reaction(joint.0, [k / 3 * 3, k / 3 * 3 + 2]))
        }
        Measure::Effort(drive) => Some(ForceKind::Drive(drive.0)),
        Measure::Force(idx) | Measure::Moment(idx) => {
            let name = &model.force_names[idx];
            let coupling = model.couplings.iter().position(|of| of.name == *name);
            let rope = || {
                let mut ropes = model.loads.iter().filter(|load| load.is_coupling());
                let teeth = |of: &Load| of.teeth().is_some_and(|teeth| teeth.name == *name);
                ropes.position(|of| of.name == *name || teeth(of)).map(ForceKind::Rope)
            };
            coupling.map(ForceKind::Coupling).or_else(rope)
        }
        _ => None,
    };
    let all = model.signals.iter().filter_map(|one| Some((one.symbol, force(one.measure)?)));
    let all: Vec<(SymbolId, ForceKind)> = all.collect();
    let used = |named: &NamedSignal| {
        let own = all.iter().filter(|(symbol, _)| model.pool.depends_on(named.value, *symbol));
        own.map(|(_, force)| *force).collect()
    };
    model.named_signals.iter().map(used).collect()
}

/// The topics in the order of the log; those of parts that the mechanism has not are left out.
fn topics(mechanism: &Mechanism) -> Vec<(Topic, TopicKind)> {
    // Fields of the motion, of the multipliers and of the efforts.
    let compiled = &mechanism.compiled;
    let coordinates = &compiled.coordinates;
    let values = coordinates.iter().map(|c| Field::new(&c.name, &c.unit, &c.description));
    let rates = coordinates
        .iter()
        .map(|c| Field::new(&c.rates[0][0], &c.rates[0][1], "rate of the coordinate"));
    let accelerations = coordinates
        .iter()
        .map(|c| Field::new(&c.rates[1][0], &c.rates[1][1], "second rate of the coordinate"));
    let multipliers =
        compiled.multipliers.iter().map(|m| Field::new(&m.name, &m.unit, &m.description));
    let coupled = compiled.couplings.iter();
    let coupled = coupled.map(|c| Field::new(&c.name, &c.unit, &c.description));
    let ropes = mechanism.model.loads.iter().filter(|load| load.is_coupling());
    let one_sided = |load: &Load| match load.teeth().map(|teeth| teeth.effort) {
        Some(MotionKind::Translation) => {
            Field::new(&load.name, "N", "force of the flanks along the pitch circles")
        }
        Some(MotionKind::Rotation) => {
            Field::new(&load.name, "N*m", "torque of the flanks on the second gear")
        }
        None => Field::new(&load.name, "N", "pull of the rope"),
    };
    let coupled = coupled.chain(ropes.map(one_sided));
    let efforts = compiled.drives.iter().map(|d| Field::new(&d.name, &d.unit, &d.description));

    // Six components for each joint.
    let wrench =
        [("fx", "N"), ("fy", "N"), ("fz", "N"), ("mx", "N*m"), ("my", "N*m"), ("mz", "N*m")];
    let reaction_fields =
        wrench.map(|(name, unit)| Field::new(name, unit, "on the joint's second body, world axes"));
    let reaction = |(joint_idx, joint): (usize, &String)| {
        let name = format!("/reactions/{joint}");
        (Topic::new(&name, reaction_fields.clone()), TopicKind::Reaction(joint_idx))
    };

    // Inputs, with the unit as those of all other channels are written.
    let inputs = mechanism.model.inputs.iter().map(|&ParameterId(idx)| {
        let parameter = &mechanism.model.parameters[idx];
        let unit = parameter.unit.replace(' ', "*");
        Field::new(&parameter.name, &unit, "a function of the motion")
    });

    let named = |is_output: bool, description: &'static str| {
        let named = mechanism.model.named_signals.iter();
        let named = named.filter(move |signal| signal.is_output == is_output);
        named.map(move |s| Field::new(&s.name, &s.unit.replace(' ', "*"), description))
    };
    let signals = named(false, "value of the signal");
    let outputs = named(true, "value of the output");

    // One topic for each part of a sample.
    let mut topics = vec![
        (Topic::new("/state", values.chain(rates)), TopicKind::State),
        (Topic::new("/acceleration", accelerations), TopicKind::Acceleration),
        (Topic::new("/multipliers", multipliers), TopicKind::Multipliers),
    ];
    topics.extend(compiled.joints.iter().enumerate().map(reaction));
    topics.extend([
        (Topic::new("/couplings", coupled), TopicKind::Couplings),
        (Topic::new("/drives", efforts), TopicKind::Drives),
        (Topic::new(INPUTS, inputs), TopicKind::Inputs),
        (Topic::new("/signals", signals), TopicKind::Signals),
        (Topic::new("/outputs", outputs), TopicKind::Outputs),
        (Topic::new("/energy", energy_fields()), TopicKind::Energy),
        (Topic::new("/solver", solver_fields()), TopicKind::Solver),
    ]);
    let is_optional = |of: &TopicKind| {
        use TopicKind as T;
        let of_parts = matches!(of, T::Multipliers | T::Couplings | T::Drives | T::Inputs);
        of_parts || matches!(of, T::Signals | T::Outputs)
    };
    topics.retain(|(topic, of)| !(is_optional(of) && topic.fields.is_empty()));
    topics
}

fn energy_fields() -> [Field; 5] {
    [
        Field::new("kinetic", "J", "kinetic energy"),
        Field::new("potential", "J", "potential energy"),
        Field::new("total", "J", "kinetic and potential energy"),
        Field::new("work", "J", "work of loads and drives since the start"),
        Field::new("power", "W", "power of loads and drives"),
    ]
}

fn solver_fields() -> [Field; 10] {
    let counter = |name| Field::new(name, "", "counter since the start");
    [
        Field::new("step_size", "s", "size of the step this sample lies in"),
        Field::new("position_residual", "", "largest constraint of the sample, m or rad"),
        Field::new("velocity_residual", "", "largest constraint rate of the sample"),
        Field::new("position_drift", "", "largest constraint before projection"),
        Field::new("velocity_drift", "", "largest constraint rate before projection"),
        counter("n_step"),
        counter("n_reject"),
        counter("n_newton"),
        counter("n_jacobian"),
        counter("n_factor"),
    ]
}
