//! A logged run again, at any instant, from the motion between its samples.
//!
//! A log holds the model and the integrator's polynomial over every step. So whatever has a value
//! along the motion is computed at the instant that is asked for, by the equations themselves, and
//! nothing is taken from the sample next to it.

use std::io::Read;

use crate::player::{Player, span, uniqueness};
use crate::record::{Channels, INPUTS, Signal, compliances, overrides};
use bksim_expr::TapeError;
use bksim_log::{EndStatus, Header, LogError, LogReader, Note, Record, Topic};
use bksim_model::diagnostic::{Diagnostic, Rejected};
use bksim_model::file::{Source, read};
use bksim_model::{Compliance, Model};
use bksim_sim::Mechanism;
use bksim_sim::input::{along, find_inputs};
use bksim_sim::pose::{Pose, PoseRunner, Poses};
use bksim_sim::redundancy::{Uniqueness, UniquenessChange};
use bksim_sim::run::{Sample, Segment, Unreplayed};

/// A logged run with its mechanism.
#[derive(Debug)]
pub struct Playback {
    log: RunLog,
    mechanism: Mechanism,
    player: Player,
    poses: PoseRunner,
    channels: Channels,
    uniqueness: Vec<UniquenessChange>,
    at: Vec<Pose>,
}

/// The contents of a log other than its samples.
#[derive(Clone, PartialEq, Debug)]
pub struct RunLog {
    /// The header: model, parameters, options and topics.
    pub header: Header,
    /// Warnings and events.
    pub notes: Vec<Note>,
    /// The end of the run; `None` if the log was cut short.
    pub end: Option<EndStatus>,
    /// The motion, in the order of the run.
    pub segments: Vec<Segment>,
    /// Samples of the inputs.
    pub inputs: LoggedInputs,
}

/// The inputs of a run at its samples.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct LoggedInputs {
    /// s.
    pub t: Vec<f64>,
    /// SI; at each instant as many as the topic has fields.
    pub values: Vec<f64>,
}

/// Why a log cannot be played back.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlaybackError {
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The model in it is refused: it was written by another version.
    #[error("the model in the log is refused: {0}")]
    Model(#[from] Rejected),
    /// There is nothing to play: the run ended, or the log was cut, before its first step.
    #[error("the log holds no motion")]
    NoMotion,
    /// The motion in it is not that of its model.
    #[error(transparent)]
    Unreplayed(#[from] Unreplayed),
    /// The poses cannot be compiled.
    #[error(transparent)]
    Tape(#[from] TapeError),
}

impl RunLog {
    /// A motion that was never logged, and whose mechanism is known.
    pub fn unlogged(header: Header, segments: Vec<Segment>) -> Self {
        Self { header, notes: Vec::new(), end: None, segments, inputs: LoggedInputs::default() }
    }

    /// Reads a log to its end, or to where it was cut short. Samples of all but inputs are passed over.
    ///
    /// # Errors
    /// [`LogError`] when the bytes are no log, or a damaged one.
    pub fn read<R: Read>(mut log: LogReader<R>) -> Result<Self, LogError> {
        let (mut notes, mut segments) = (Vec::new(), Vec::new());
        let mut inputs = LoggedInputs::default();
        let of_inputs = inputs_of(log.header()).map(|(idx, _)| idx);
        while let Some(record) = log.next_record()? {
            match record {
                Record::Note(note) => notes.push(note),
                Record::Segment(segment) => segments.push(segment_of(segment)),
                Record::Sample { topic, t, values } if Some(topic.index()) == of_inputs => {
                    inputs.t.push(t);
                    inputs.values.extend_from_slice(values);
                }
                Record::Sample { .. } | Record::NotUnique(_) => (),
            }
        }
        let (header, end) = (log.header().clone(), log.end().cloned());
        Ok(Self { header, notes, end, segments, inputs })
    }

    /// The mechanism of the run, with the values that its parameters had; between its samples, inputs are
    /// straight lines.
    ///
    /// # Errors
    /// [`Rejected`] when this version refuses the model.
    pub fn mechanism(&self) -> Result<Mechanism, Rejected> {
        let (mut model, diagnostics) = self.model()?;
        if let Some((_, topic)) = inputs_of(&self.header) {
            let names: Vec<&str> = topic.fields.iter().map(|field| field.name.as_str()).collect();
            let law = along(self.inputs.t.clone(), self.inputs.values.clone());
            // A log of another program may call what it likes so.
            if let Ok(inputs) = find_inputs(&model, &names) {
                model.inputs = inputs;
                return Mechanism::derive_with(model, Some(law), diagnostics);
            }
        }
        Mechanism::derive(model, diagnostics)
    }

    /// The model with other values of its parameters, those of a mechanism of the run.
    ///
    /// # Errors
    /// [`Rejected`] when this version refuses the model.
    pub fn model_with(&self, parameters: &[f64]) -> Result<Model, Rejected> {
        let (mut model, _) = self.model()?;
        for (parameter, value) in model.parameters.iter_mut().zip(parameters) {
            parameter.value = *value;
        }
        Ok(model)
    }

    fn model(&self) -> Result<(Model, Vec<Diagnostic>), Rejected> {
        let Header { model_text: text, model_name: name, options, parameters, .. } = &self.header;
        let overrides = overrides(options);
        let source = Source { overrides: &overrides, ..Source::new(text, name) };
        let reading = read(&source);
        match reading.model {
            Some(mut model) => {
                // The run may have had other values than the text and the options say.
                for parameter in &mut model.parameters {
                    let logged = parameters.get(&parameter.name).map(|logged| logged.value);
                    parameter.value = logged.filter(|x| x.is_finite()).unwrap_or(parameter.value);
                }
                // Written by bksim itself: what cannot be read is of another version, and the joint is rigid.
                let known = compliances(options);
                let read =
                    |(name, value): &(String, String)| Compliance::parse(&model, name, value).ok();
                model.compliances = known.iter().filter_map(read).collect();
                Ok((model, reading.diagnostics))
            }
            None => Err(Rejected(reading.diagnostics)),
        }
    }
}

/// The topic of the inputs, with its index.
fn inputs_of(header: &Header) -> Option<(usize, &Topic)> {
    header.topics.iter().enumerate().find(|(_, topic)| topic.name == INPUTS)
}

/// The motion over a step as a log has it.
pub fn segment_of(logged: &bksim_log::Segment) -> Segment {
    Segment {
        t0: logged.t,
        t1: logged.t_end,
        values: logged.values.clone(),
        modes: logged.modes.clone(),
        dependent: logged.dependent.iter().map(|&row| row as usize).collect(),
    }
}

impl Playback {
    /// Reads a log and derives the equations of its model.
    ///
    /// # Errors
    /// [`PlaybackError`].
    pub fn open<R: Read>(log: LogReader<R>) -> Result<Self, PlaybackError> {
        let log = RunLog::read(log)?;
        let mechanism = log.mechanism()?;
        Self::new(log, mechanism)
    }

    /// A playback of `log`, which is a run of `mechanism`.
    ///
    /// # Errors
    /// [`PlaybackError`] when it is not, or holds no motion.
    pub fn new(log: RunLog, mechanism: Mechanism) -> Result<Self, PlaybackError> {
        let t_start = log.segments.first().ok_or(PlaybackError::NoMotion)?.t0;
        let poses = Poses::compile(&mechanism.model, &mechanism.system)?;
        let poses = poses.runner(&mechanism.parameters);
        let channels = Channels::new(&mechanism);
        let player = Player::new(mechanism.compiled.clone(), &mechanism.parameters);
        let (compiled, parameters) = (&mechanism.compiled, &mechanism.parameters);
        let uniqueness = uniqueness(&log.segments, compiled, parameters)?;
        let at = Vec::new();
        let mut playback = Self { log, mechanism, player, poses, channels, uniqueness, at };
        playback.seek(t_start)?;
        Ok(playback)
    }

    /// The mechanism.
    pub fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    /// The contents of the log other than its samples.
    pub fn log(&self) -> &RunLog {
        &self.log
    }

    /// First and last instant of the motion, s; the last is the earlier one in a run back in time.
    pub fn span(&self) -> [f64; 2] {
        span(&self.log.segments).unwrap_or_default()
    }

    /// Moves to `t`, s, or to the end that is nearer when it lies outside of the span. At an event,
    /// what follows it is shown.
    ///
    /// # Errors
    /// [`Unreplayed`] when the motion is not that of the mechanism.
    pub fn seek(&mut self, t: f64) -> Result<&Sample, Unreplayed> {
        let sample = self.player.at(&self.log.segments, t)?;
        self.poses.at(&sample.q, &sample.v, &mut self.at);
        Ok(sample)
    }

    /// Moves to the start of a segment of the motion and returns the kinetic energy that impacts have given there, J.
    ///
    /// # Errors
    /// [`Unreplayed`] when the motion is not that of the mechanism.
    pub fn seek_impact(&mut self, idx: usize) -> Result<f64, Unreplayed> {
        let energy = self.player.impact_at(&self.log.segments, idx)?;
        let sample = self.player.sample();
        self.poses.at(&sample.q, &sample.v, &mut self.at);
        Ok(energy)
    }

    /// The sample of the last [`Playback::seek`]; work, step size and counters are zero.
    pub fn sample(&self) -> &Sample {
        self.player.sample()
    }

    /// The modes that hold there, as parameters after those of the model.
    pub fn modes(&self) -> &[f64] {
        self.player.modes(&self.log.segments)
    }

    /// The distance of that sample from a singular pose: [`Player::rank_margin`].
    pub fn rank_margin(&mut self) -> f64 {
        self.player.rank_margin()
    }

    /// The poses of the bodies there, the ground first.
    pub fn poses(&self) -> &[Pose] {
        &self.at
    }

    /// The poses of the bodies at `t`, s, the ground first: as the integrator has them, without projection
    /// and without the rest of a sample, which takes a small part of the time of
    /// [`Playback::seek`]. That one's sample stays. For trails, sizes and extents.
    pub fn poses_at(&mut self, t: f64) -> Vec<Pose> {
        let nq = self.sample().q.len();
        let mut state = vec![0.0; 2 * nq];
        self.player.state_at(&self.log.segments, t, &mut state);
        let (q, v) = state.split_at(nq);
        let mut poses = Vec::new();
        self.poses.at(q, v, &mut poses);
        poses
    }

    /// [`Playback::poses_at`] `n` even instants from the start to the end.
    pub fn poses_over_run(&mut self, n: usize) -> Vec<Vec<Pose>> {
        let [first, last] = self.span();
        #[expect(clippy::cast_precision_loss, reason = "few instants")]
        let instant =
            |k: usize| first + (last - first) * k as f64 / n.saturating_sub(1).max(1) as f64;
        (0..n).map(|k| self.poses_at(instant(k))).collect()
    }

    /// The signal of this name, such as `state.A_angle`, if it has a value at every instant.
    pub fn signal(&self, name: &str) -> Option<Signal> {
        self.channels.signal(name)
    }

    /// Value of a signal at the last [`Playback::seek`].
    pub fn value(&self, signal: Signal) -> f64 {
        self.channels.value(signal, self.sample())
    }

    /// Which components of the reactions are unique, from the start on and wherever that changes.
    pub fn uniqueness(&self) -> &[UniquenessChange] {
        &self.uniqueness
    }

    /// Which components of the reactions are unique at `t`, s.
    pub fn uniqueness_at(&self, t: f64) -> &Uniqueness {
        let [first, last] = self.span();
        let forward = if last < first { -1.0 } else { 1.0 };
        let n_begun = self.uniqueness.partition_point(|change| (change.t - t) * forward <= 0.0);
        // A motion has a first segment, and so a first change.
        &self.uniqueness[n_begun.saturating_sub(1)].uniqueness
    }

    /// The instants from which on a signal is unique, or is not, each with which.
    pub fn uniqueness_of(&self, signal: Signal) -> Vec<(f64, bool)> {
        let changes = self.uniqueness.iter();
        let states = changes.map(|c| (c.t, self.channels.is_unique(signal, &c.uniqueness)));
        let mut found: Vec<(f64, bool)> = Vec::new();
        for (t, is_unique) in states {
            if found.last().is_none_or(|&(_, last)| last != is_unique) {
                found.push((t, is_unique));
            }
        }
        found
    }

    /// The channels.
    pub fn channels(&self) -> &Channels {
        &self.channels
    }
}
