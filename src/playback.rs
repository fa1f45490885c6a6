//! A logged run again, at any instant: what is drawn, from the motion between its samples.
//!
//! A log holds the model and the integrator's polynomial over every step. So whatever has a value
//! along the motion is computed at the instant that is asked for, by the equations themselves, and
//! nothing is taken from the sample next to it.

use std::io::Read;

use bksim_expr::TapeError;
use bksim_log::{EndStatus, Header, LogError, LogReader, Note, Record};
use bksim_mbs::file::{Limits, Source, read};
use bksim_mbs::pose::{Pose, PoseRunner, Poses};
use bksim_mbs::run::{Replay, Sample, Segment, Unreplayed};
use self_cell::self_cell;

use crate::record::{Channels, Signal, overrides};
use crate::{Mechanism, Rejected};

/// A logged run with its mechanism.
#[derive(Debug)]
pub struct Playback {
    log: RunLog,
    player: Player,
    poses: PoseRunner,
    channels: Channels,
    /// The segment used last: instants that follow each other are near each other.
    last_idx: usize,
    at: Vec<Pose>,
}

/// What a log tells apart from its samples.
#[derive(Clone, PartialEq, Debug)]
pub struct RunLog {
    /// What the log tells about its run.
    pub header: Header,
    /// Warnings and events.
    pub notes: Vec<Note>,
    /// How the run ended; `None` if the log was cut short.
    pub end: Option<EndStatus>,
    /// The motion, in the order of the run.
    pub segments: Vec<Segment>,
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

self_cell!(
    struct Player {
        owner: Mechanism,
        #[covariant]
        dependent: Replay,
    }
    impl {Debug}
);

impl RunLog {
    /// Reads a log to its end, or to where it was cut short. Samples are passed over.
    ///
    /// # Errors
    /// [`LogError`] when the bytes are no log, or a damaged one.
    pub fn read<R: Read>(mut log: LogReader<R>) -> Result<Self, LogError> {
        let (mut notes, mut segments) = (Vec::new(), Vec::new());
        while let Some(record) = log.next_record()? {
            match record {
                Record::Note(note) => notes.push(note),
                Record::Segment(segment) => segments.push(Segment {
                    t0: segment.t,
                    t1: segment.t_end,
                    values: segment.values.clone(),
                    modes: segment.modes.clone(),
                    dependent: segment.dependent.iter().map(|&row| row as usize).collect(),
                }),
                Record::Sample { .. } => (),
            }
        }
        Ok(Self { header: log.header().clone(), notes, end: log.end().cloned(), segments })
    }

    /// The mechanism of the run, with the values that its parameters had.
    ///
    /// # Errors
    /// [`Rejected`] when this version refuses the model.
    pub fn mechanism(&self) -> Result<Mechanism, Rejected> {
        let Header { model_text: text, model_name: name, options, .. } = &self.header;
        let overrides = overrides(options);
        let source = Source { text, name, overrides: &overrides, limits: Limits::default() };
        let reading = read(&source);
        match reading.model {
            Some(model) => Mechanism::derive(model, reading.diagnostics),
            None => Err(Rejected(reading.diagnostics)),
        }
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
        let player = Player::new(mechanism, |m| Replay::new(&m.compiled, &m.parameters));
        let mut playback = Self { log, player, poses, channels, last_idx: 0, at: Vec::new() };
        playback.seek(t_start)?;
        Ok(playback)
    }

    /// The mechanism.
    pub fn mechanism(&self) -> &Mechanism {
        self.player.borrow_owner()
    }

    /// What the log tells apart from its samples.
    pub fn log(&self) -> &RunLog {
        &self.log
    }

    /// First and last instant of the motion, s; the last is the earlier one in a run back in time.
    pub fn span(&self) -> [f64; 2] {
        let ends = |segments: &[Segment]| Some([segments.first()?.t0, segments.last()?.t1]);
        ends(&self.log.segments).unwrap_or_default()
    }

    /// Moves to `t`, s, or to the end that is nearer when it lies outside of the span. At an event,
    /// what follows it is shown.
    ///
    /// # Errors
    /// [`Unreplayed`] when the motion is not that of the mechanism.
    pub fn seek(&mut self, t: f64) -> Result<&Sample, Unreplayed> {
        let [first, last] = self.span();
        let t = if t.is_nan() { first } else { t.clamp(first.min(last), first.max(last)) };
        self.last_idx = self.segment_at(t);
        let segment = &self.log.segments[self.last_idx];
        self.player.with_dependent_mut(|_, replay| replay.at(segment, t).map(drop))?;
        let sample = self.player.borrow_dependent().sample();
        self.poses.at(&sample.q, &sample.v, &mut self.at);
        Ok(sample)
    }

    /// The sample of the last [`Playback::seek`]; work, step size and counters are zero.
    pub fn sample(&self) -> &Sample {
        self.player.borrow_dependent().sample()
    }

    /// Where the bodies are there, the ground first.
    pub fn poses(&self) -> &[Pose] {
        &self.at
    }

    /// Where the bodies are at `t`, s, the ground first: as the integrator has them, without projection
    /// and without what else a sample tells, which takes a small part of the time of
    /// [`Playback::seek`]. That one's sample stays. For trails, sizes and extents.
    pub fn poses_at(&mut self, t: f64) -> Vec<Pose> {
        let [first, last] = self.span();
        let t = if t.is_nan() { first } else { t.clamp(first.min(last), first.max(last)) };
        let nq = self.sample().q.len();
        let mut state = vec![0.0; 2 * nq];
        self.log.segments[self.segment_at(t)].at(t, &mut state);
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

    /// The channels.
    pub fn channels(&self) -> &Channels {
        &self.channels
    }

    fn segment_at(&self, t: f64) -> usize {
        let segments = &self.log.segments;
        let [first, last] = self.span();
        let forward = if last < first { -1.0 } else { 1.0 };
        let is_in = |idx: usize| segments.get(idx).is_some_and(|s| s.contains(t) && t != s.t1);
        if is_in(self.last_idx) {
            return self.last_idx;
        }
        if is_in(self.last_idx + 1) {
            return self.last_idx + 1;
        }
        let n_before = segments.partition_point(|s| (s.t1 - t) * forward <= 0.0);
        n_before.min(segments.len() - 1)
    }
}
