//! The content of a log apart from its samples, as plain data: how the run begins and ends, the notes
//! and the motion between samples.

use std::collections::BTreeMap;

/// One signal of a topic.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Field {
    /// An ASCII identifier other than `t`, unique in its topic.
    pub name: String,
    /// SI unit as text, empty for a plain number.
    pub unit: String,
    /// One line for people; may be empty.
    pub description: String,
}

impl Field {
    /// A field from its three texts.
    pub fn new(name: &str, unit: &str, description: &str) -> Field {
        Field { name: name.into(), unit: unit.into(), description: description.into() }
    }
}

/// Signals that are sampled together.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Topic {
    /// `/` and ASCII identifiers joined by `/`, such as `/state` or `/reactions/elbow`.
    pub name: String,
    /// The signals, in the order of the values of a sample.
    pub fields: Vec<Field>,
}

impl Topic {
    /// A topic from its name and signals.
    pub fn new(name: &str, fields: impl IntoIterator<Item = Field>) -> Topic {
        Topic { name: name.into(), fields: fields.into_iter().collect() }
    }

    /// The name under which a field is exported: `/state` and `angle` give `state.angle`.
    pub fn column_name(&self, field: &Field) -> String {
        format!("{}.{}", dotted(&self.name), field.name)
    }
}

/// `/reactions/elbow` as `reactions.elbow`.
pub(crate) fn dotted(topic_name: &str) -> String {
    topic_name.trim_start_matches('/').replace('/', ".")
}

/// Handle to one topic of a [`Header`]: its index in [`Header::topics`].
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct TopicId(pub(crate) usize);

impl TopicId {
    /// Index in [`Header::topics`].
    pub fn index(self) -> usize {
        self.0
    }
}

/// A number and its SI unit (empty for a plain number).
#[derive(Clone, PartialEq, Debug)]
pub struct Quantity {
    /// The value in that unit.
    pub value: f64,
    /// SI unit as text.
    pub unit: String,
}

/// Everything known before the first sample.
#[derive(Clone, PartialEq, Debug)]
pub struct Header {
    /// Name of the model.
    pub model_name: String,
    /// Ending of the model's file name, such as `toml`.
    pub model_format: String,
    /// The model as its author wrote it.
    pub model_text: String,
    /// Version of bksim that wrote the log.
    pub version: String,
    /// Time at which the run starts, s; may be negative.
    pub t_start: f64,
    /// Time at which it is to end, s; before the start when the run goes back in time.
    pub t_end: f64,
    /// Resolved parameters by name.
    pub parameters: BTreeMap<String, Quantity>,
    /// Options of the run by name.
    pub options: BTreeMap<String, String>,
    /// The channels.
    pub topics: Vec<Topic>,
}

impl Header {
    /// A header without parameters, options and topics, of a run from `t = 0` without end.
    pub fn new(model_name: &str, model_format: &str, model_text: &str, version: &str) -> Header {
        Header {
            model_name: model_name.into(),
            model_format: model_format.into(),
            model_text: model_text.into(),
            version: version.into(),
            t_start: 0.0,
            t_end: f64::INFINITY,
            parameters: BTreeMap::new(),
            options: BTreeMap::new(),
            topics: Vec::new(),
        }
    }

    /// Adds a topic and returns its handle; names are checked when the log is created.
    pub fn add_topic(&mut self, topic: Topic) -> TopicId {
        self.topics.push(topic);
        TopicId(self.topics.len() - 1)
    }

    /// The topic with this name.
    pub fn topic_id(&self, name: &str) -> Option<TopicId> {
        self.topics.iter().position(|topic| topic.name == name).map(TopicId)
    }

    /// All topics with their handles.
    pub fn topics_with_ids(&self) -> impl Iterator<Item = (TopicId, &Topic)> {
        self.topics.iter().enumerate().map(|(topic_idx, topic)| (TopicId(topic_idx), topic))
    }

    /// Sign of the steps: 1, or −1 for a run back in time.
    pub fn direction(&self) -> f64 {
        if self.t_end < self.t_start { -1.0 } else { 1.0 }
    }

    /// The time, s, so many nanoseconds after the start.
    pub(crate) fn time(&self, nanoseconds: u64) -> f64 {
        self.t_start + self.direction() * (nanoseconds as f64 / 1e9)
    }
}

/// Whether a run came to its end time.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Outcome {
    /// The end time was reached.
    ReachedEnd,
    /// The run stopped before; the samples up to then are valid.
    Stopped,
}

/// How a run ended.
#[derive(Clone, PartialEq, Debug)]
pub struct EndStatus {
    /// Whether the end time was reached.
    pub outcome: Outcome,
    /// Last time of the solution, s.
    pub t_end: f64,
    /// Why the run ended there, for people.
    pub reason: String,
    /// Counters, residuals and other results, by name.
    pub summary: BTreeMap<String, String>,
    /// The report of the run as JSON; may be empty.
    pub details: String,
}

impl EndStatus {
    /// An end without a summary.
    pub fn new(outcome: Outcome, t_end: f64, reason: &str) -> EndStatus {
        let (summary, details) = (BTreeMap::new(), String::new());
        EndStatus { outcome, t_end, reason: reason.into(), summary, details }
    }
}

/// How serious a [`Note`] is, numbered as in the schema `foxglove.Log`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Level {
    /// Detail for developers.
    Debug = 1,
    /// Something worth knowing, such as an event.
    Info = 2,
    /// The result may not be what the author wants.
    Warning = 3,
    /// The run failed here.
    Error = 4,
}

/// The motion over one step of the integrator: a message of the topic `/motion`.
///
/// `values` are those of the coordinates and velocities at the Chebyshev points of the first kind
/// of degree d between `t` and `t_end`, from `t_end` to `t`, those of one point together; a
/// polynomial of degree d through them is the motion at every instant between.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct Segment {
    /// Where it begins, s.
    pub t: f64,
    /// Where it ends, s.
    pub t_end: f64,
    /// (d + 1) times as many numbers as `/state` has fields.
    pub values: Vec<f64>,
    /// Which branches and contacts hold, as the solver has them.
    pub modes: Vec<f64>,
    /// Constraint rows that follow from the others.
    pub dependent: Vec<u32>,
}

/// The channels that hold one of many solutions of the equilibrium, from an instant on: a metadata
/// record `bksim.uniqueness`. Without channels, all are unique again.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct NotUnique {
    /// From when on, s.
    pub t: f64,
    /// Number of independent self-stresses.
    pub n_self_stresses: usize,
    /// Names of the channels, such as `reactions.A.fx`.
    pub channels: Vec<String>,
}

/// One line of the topic `/log`.
#[derive(Clone, PartialEq, Debug)]
pub struct Note {
    /// How serious it is.
    pub level: Level,
    /// Time, s.
    pub t: f64,
    /// The event in words.
    pub text: String,
}
