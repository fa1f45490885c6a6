//! A run as a log: which channels there are, and how a sample fills them.

mod shown;
mod stage;
mod table;

use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::ops::Range;

use bksim_log::{
    EndStatus, Field, Header, Level, LogError, LogReader, LogWriter, Outcome, Quantity, Record,
    Topic, TopicId,
};
use bksim_model::ParameterId;
use bksim_sim::run::{RunCheckpoint, Sample, Segment, Summary};
use bksim_sim::sensitivity::{Sensitive, StateSensitivity};
use bksim_sim::start::Start;

use self::shown::Shown;
use bksim_sim::Mechanism;

/// Writes samples to a log.
pub struct Recorder<W: Write> {
    writer: LogWriter<W>,
    header: Header,
    channels: Channels,
    /// Those of the channels.
    topics: Vec<TopicId>,
    sensitivities: Vec<TopicId>,
    /// For programs that know nothing of bksim, if they are to have anything.
    shown: Option<Shown>,
    values: Vec<f64>,
    segment: bksim_log::Segment,
}

/// Topics of a log that a sample fills, and of those that it does not.
#[derive(Clone, PartialEq, Debug)]
pub struct Channels {
    topics: Vec<(Topic, Of)>,
    /// Rows of the drives.
    drives: Range<usize>,
}

/// Version of bksim, written into every log.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The topic of the [inputs](bksim_sim::input).
pub const INPUTS: &str = "/inputs";

/// The most bytes of what is told of a run at its end.
const MOST_DETAILS: usize = 8 << 20;

/// The most values of a topic that do not lie in the sample as they are.
const N_MADE: usize = 10;

/// What a topic holds.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Of {
    State,
    Acceleration,
    Multipliers,
    Reaction(usize),
    Drives,
    Inputs,
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
        // Rows of joints come first, then those of drives, then those of stops and friction.
        let end = mechanism.system.n_bilateral();
        let drives = end - mechanism.compiled.drives.len()..end;
        Self { topics: topics(mechanism), drives }
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

    /// The signal of this name, such as `state.A_angle`, if it has a value at every instant.
    pub fn signal(&self, name: &str) -> Option<Signal> {
        self.signals().find(|(_, known, _)| known == name).map(|(signal, ..)| signal)
    }

    /// Its value in a sample.
    pub fn value(&self, signal: Signal, sample: &Sample) -> f64 {
        let mut made = [0.0; N_MADE];
        let [first, second] = self.values(self.topics[signal.topic_idx].1, sample, &mut made);
        let behind = signal.field_idx.checked_sub(first.len());
        let value = behind.map_or_else(|| first.get(signal.field_idx), |idx| second.get(idx));
        value.copied().unwrap_or(f64::NAN)
    }

    /// The values of a topic, in two parts: as they lie in the sample, or made from it.
    fn values<'a>(
        &self,
        of: Of,
        sample: &'a Sample,
        made: &'a mut [f64; N_MADE],
    ) -> [&'a [f64]; 2] {
        let Sample { q, v, a, lambda, reactions, inputs, energy, stats, .. } = sample;
        match of {
            Of::State => [q, v],
            Of::Acceleration => [a, &[]],
            Of::Multipliers => [lambda, &[]],
            Of::Reaction(joint) => [&reactions[joint], &[]],
            // The multipliers of the drives' rows are the efforts.
            Of::Drives => [&lambda[self.drives.clone()], &[]],
            Of::Inputs => [inputs, &[]],
            Of::Energy => {
                let total = energy.kinetic + energy.potential;
                let five = [energy.kinetic, energy.potential, total, sample.work, energy.power];
                made[..5].copy_from_slice(&five);
                [&made[..5], &[]]
            }
            #[expect(clippy::cast_precision_loss, reason = "counters stay far below 2^53")]
            Of::Solver => {
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

impl Of {
    /// Whether a field has a value at every instant.
    fn is_lasting(self, field: &Field) -> bool {
        match self {
            Self::Energy => field.name != "work",
            Self::Solver => false,
            _ => true,
        }
    }
}

/// What a log holds beside the samples.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Contents<'a> {
    /// Settings to keep beside the model's own.
    pub options: &'a [(String, String)],
    /// Quantities that have a channel for the sensitivities to each: `/sensitivity/l1`,
    /// `/sensitivity/A/rate`.
    pub sensitive: &'a [Sensitive],
    /// Whether the channels of other programs are there, too: `/tf`, `/scene`, `/spans`,
    /// `/joint_states`, `/outlines/…`.
    pub has_viewers: bool,
}

impl Default for Contents<'_> {
    /// No options, no sensitivities, and the channels of other programs.
    fn default() -> Self {
        Self { options: &[], sensitive: &[], has_viewers: true }
    }
}

/// Names and fields of the derivatives of a sample by some quantities, in the order of
/// [`sensitivity_row`]: `sensitivity.l1.theta1`.
pub fn sensitivity_columns(mechanism: &Mechanism, by: &[Sensitive]) -> Vec<(String, Field)> {
    let topics = by.iter().map(|&by| sensitivity_topic(mechanism, by));
    let columns = topics.flat_map(|topic| {
        let named = |field: &Field| (topic.column_name(field), field.clone());
        topic.fields.iter().map(named).collect::<Vec<_>>()
    });
    columns.collect()
}

/// The derivatives of a sample by one quantity.
pub fn sensitivity_row(by: &StateSensitivity) -> impl Iterator<Item = f64> {
    [&by.q, &by.v, &by.a, &by.lambda].into_iter().flatten().copied()
}

/// Options with this prefix are parameters given on the command line.
const SET: &str = "set.";

/// A parameter given on the command line, as an option for the log.
pub fn set_option(name: &str, value: &str) -> (String, String) {
    (format!("{SET}{name}"), value.to_owned())
}

/// The parameters among the options of a log that were given on the command line.
pub fn overrides(options: &BTreeMap<String, String>) -> Vec<(String, String)> {
    let set =
        |(key, value): (&String, &String)| Some((key.strip_prefix(SET)?.to_owned(), value.clone()));
    options.iter().filter_map(set).collect()
}

impl<W: Write> Recorder<W> {
    /// Opens a log of `mechanism`; `format` is the ending of the model's file name, `options` are
    /// the settings to keep beside the model's own.
    ///
    /// # Errors
    /// [`LogError`] when the start of the log cannot be written.
    pub fn create(
        out: W,
        mechanism: &Mechanism,
        model_text: &str,
        start: &Start,
        options: &[(String, String)],
    ) -> Result<Self, LogError> {
        let contents = Contents { options, ..Contents::default() };
        Self::create_with(out, mechanism, model_text, start, &contents)
    }

    /// As [`Recorder::create`], with what else the log holds.
    ///
    /// # Errors
    /// [`LogError`] when the start of the log cannot be written.
    pub fn create_with(
        out: W,
        mechanism: &Mechanism,
        model_text: &str,
        start: &Start,
        contents: &Contents<'_>,
    ) -> Result<Self, LogError> {
        let &Contents { options, sensitive, has_viewers } = contents;
        let mut header = Header::new(&mechanism.model.name, "toml", model_text, VERSION);
        (header.t_start, header.t_end) = (start.t, mechanism.model.solve.t_end);
        header.options = options.iter().cloned().collect();
        for parameter in &mechanism.model.parameters {
            let quantity = Quantity { value: parameter.value, unit: parameter.unit.clone() };
            header.parameters.insert(parameter.name.clone(), quantity);
        }
        let channels = Channels::new(mechanism);
        let topics = channels.topics.iter().map(|(topic, _)| header.add_topic(topic.clone()));
        let topics = topics.collect();
        let sensitivities =
            sensitive.iter().map(|&by| header.add_topic(sensitivity_topic(mechanism, by)));
        let sensitivities = sensitivities.collect();
        let mut writer = LogWriter::create(out, &header)?;
        let shown = if has_viewers { Shown::add(&mut writer, mechanism)? } else { None };
        let (values, segment) = (Vec::new(), bksim_log::Segment::default());
        Ok(Self { writer, header, channels, topics, sensitivities, shown, values, segment })
    }

    /// Writes one sample to every channel.
    ///
    /// # Errors
    /// [`LogError`] when the log cannot be written.
    pub fn write(&mut self, sample: &Sample) -> Result<(), LogError> {
        let mut values = std::mem::take(&mut self.values);
        for topic_idx in 0..self.topics.len() {
            values.clear();
            let mut made = [0.0; N_MADE];
            let parts = self.channels.values(self.channels.topics[topic_idx].1, sample, &mut made);
            values.extend(parts.into_iter().flatten());
            self.put(topic_idx, sample.t, &values)?;
        }
        self.values = values;
        Ok(())
    }

    /// Writes the values of one topic, and behind the last one of a sample what viewers are shown.
    fn put(&mut self, topic_idx: usize, t: f64, values: &[f64]) -> Result<(), LogError> {
        self.writer.write(self.topics[topic_idx], t, values)?;
        let Some(shown) = &mut self.shown else { return Ok(()) };
        shown.learn(self.channels.topics[topic_idx].1, values);
        let is_last = topic_idx + 1 == self.topics.len();
        if is_last { shown.write(&mut self.writer, t) } else { Ok(()) }
    }

    /// Writes the motion over a step, ahead of the samples in it.
    ///
    /// # Errors
    /// [`LogError`] when the log cannot be written.
    pub fn segment(&mut self, segment: &Segment) -> Result<(), LogError> {
        let Segment { t0, t1, values, modes, dependent } = segment;
        let message = &mut self.segment;
        (message.t, message.t_end) = (*t0, *t1);
        message.values.clone_from(values);
        message.modes.clone_from(modes);
        message.dependent.clear();
        let rows = dependent.iter().map(|&row| u32::try_from(row).unwrap_or(u32::MAX));
        message.dependent.extend(rows);
        self.writer.segment(message)
    }

    /// Writes the sensitivities of a sample, one per quantity.
    ///
    /// # Errors
    /// [`LogError`] when the log cannot be written.
    pub fn write_sensitivities(&mut self, t: f64, by: &[StateSensitivity]) -> Result<(), LogError> {
        for (&topic, by) in self.sensitivities.iter().zip(by) {
            self.values.clear();
            self.values.extend(sensitivity_row(by));
            self.writer.write(topic, t, &self.values)?;
        }
        Ok(())
    }

    /// Copies what belongs to the run out of the log of its first part: the samples before
    /// `checkpoint` and the warnings. False, with nothing written, when that log is of another run.
    ///
    /// # Errors
    /// [`LogError`] when either log fails.
    pub fn copy<R: Read>(
        &mut self,
        first: &mut LogReader<R>,
        checkpoint: &RunCheckpoint,
    ) -> Result<bool, LogError> {
        if *first.header() != self.header {
            return Ok(false);
        }
        let mut n_written = vec![0; self.header.topics.len()];
        while let Some(record) = first.next_record()? {
            match record {
                Record::Sample { topic, t, values } => {
                    let topic_idx = topic.index();
                    if n_written[topic_idx] < checkpoint.n_samples() {
                        n_written[topic_idx] += 1;
                        if topic_idx < self.topics.len() {
                            self.put(topic_idx, t, values)?;
                        } else {
                            self.writer.write(topic, t, values)?;
                        }
                    }
                }
                Record::Note(note) if note.level < Level::Error => {
                    self.writer.note(note.level, note.t, &note.text)?;
                }
                Record::Segment(segment) => self.writer.segment(segment)?,
                // How the first part ended.
                Record::Note(_) => (),
            }
        }
        Ok(true)
    }

    /// A line for people in the log itself.
    ///
    /// # Errors
    /// [`LogError`] when the log cannot be written.
    pub fn note(&mut self, level: Level, t: f64, text: &str) -> Result<(), LogError> {
        self.writer.note(level, t, text)
    }

    /// Closes the log with how the run ended, and with what a run goes on from that was stopped.
    ///
    /// # Errors
    /// [`LogError`] when the end of the log cannot be written.
    pub fn finish(
        mut self,
        mechanism: &Mechanism,
        summary: &Summary,
        outcome: Outcome,
        reason: &str,
    ) -> Result<W, LogError> {
        if let Some(checkpoint) = &summary.checkpoint {
            match self.writer.checkpoint(&checkpoint.to_bytes()) {
                // The log is worth more than that.
                Err(LogError::TooLarge { .. }) => {
                    let text = "the state of the run is too large to be kept: it cannot be resumed";
                    self.writer.note(Level::Warning, summary.t, text)?;
                }
                written => written?,
            }
        }
        let mut end = EndStatus::new(outcome, summary.t, reason);
        end.summary = [
            ("steps", summary.stats.to_string()),
            ("position_residual", summary.position_residual[1].to_string()),
            ("velocity_residual", summary.velocity_residual[1].to_string()),
            ("energy_error", summary.energy.worst_error.to_string()),
        ]
        .into_iter()
        .map(|(key, value)| (key.to_owned(), value))
        .collect();
        end.details = crate::describe::summary(mechanism, summary).to_string();
        if end.details.len() > MOST_DETAILS {
            // Millions of events: the log is worth more than that.
            end.details.clear();
        }
        self.writer.finish(&end)
    }
}

fn topics(mechanism: &Mechanism) -> Vec<(Topic, Of)> {
    let compiled = &mechanism.compiled;
    let coordinates = &compiled.coordinates;
    let values = coordinates.iter().map(|c| Field::new(&c.name, c.unit, &c.description));
    let rates = coordinates.iter().map(|c| {
        Field::new(&format!("{}_dot", c.name), &format!("{}/s", c.unit), "rate of the coordinate")
    });
    let accelerations = coordinates.iter().map(|c| {
        let (name, unit) = (format!("{}_ddot", c.name), format!("{}/s^2", c.unit));
        Field::new(&name, &unit, "second rate of the coordinate")
    });
    let multipliers =
        compiled.multipliers.iter().map(|m| Field::new(&m.name, m.unit, &m.description));
    let efforts = compiled.drives.iter().map(|d| Field::new(&d.name, d.unit, &d.description));
    let wrench =
        [("fx", "N"), ("fy", "N"), ("fz", "N"), ("mx", "N*m"), ("my", "N*m"), ("mz", "N*m")];
    let reaction_fields =
        wrench.map(|(name, unit)| Field::new(name, unit, "on the joint's second body, world axes"));
    let reaction = |(joint_idx, joint): (usize, &String)| {
        let name = format!("/reactions/{joint}");
        (Topic::new(&name, reaction_fields.clone()), Of::Reaction(joint_idx))
    };
    let inputs = mechanism.model.inputs.iter().map(|&ParameterId(idx)| {
        let parameter = &mechanism.model.parameters[idx];
        // As the units of all other channels are written.
        let unit = parameter.unit.replace(' ', "*");
        Field::new(&parameter.name, &unit, "a function of the motion")
    });
    let mut topics = vec![
        (Topic::new("/state", values.chain(rates)), Of::State),
        (Topic::new("/acceleration", accelerations), Of::Acceleration),
        (Topic::new("/multipliers", multipliers), Of::Multipliers),
    ];
    topics.extend(compiled.joints.iter().enumerate().map(reaction));
    topics.extend([
        (Topic::new("/drives", efforts), Of::Drives),
        (Topic::new(INPUTS, inputs), Of::Inputs),
        (Topic::new("/energy", energy_fields()), Of::Energy),
        (Topic::new("/solver", solver_fields()), Of::Solver),
    ]);
    let is_optional = |of: &Of| matches!(of, Of::Multipliers | Of::Drives | Of::Inputs);
    topics.retain(|(topic, of)| !(is_optional(of) && topic.fields.is_empty()));
    topics
}

/// Derivatives of coordinates, rates, second rates and multipliers by one quantity.
fn sensitivity_topic(mechanism: &Mechanism, by: Sensitive) -> Topic {
    let (model, compiled) = (&mechanism.model, &mechanism.compiled);
    let (name, of) = (by.name(model), by.unit(model));
    let field = |name: String, unit: String| {
        let unit = match of.as_str() {
            "" => unit,
            of if of.contains(['/', '*', ' ']) => format!("{unit}/({of})"),
            of => format!("{unit}/{of}"),
        };
        Field::new(&name, &unit, &format!("derivative by {}", by.name(model)))
    };
    let rates = [("", ""), ("_dot", "/s"), ("_ddot", "/s^2")];
    let motion = rates.iter().flat_map(|(suffix, per)| {
        let coordinates = compiled.coordinates.iter();
        coordinates.map(move |c| (format!("{}{suffix}", c.name), format!("{}{per}", c.unit)))
    });
    let multipliers = compiled.multipliers.iter().map(|m| (m.name.clone(), m.unit.to_owned()));
    let fields = motion.chain(multipliers).map(|(name, unit)| field(name, unit));
    Topic::new(&format!("/sensitivity/{}", name.replace('.', "/")), fields)
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
