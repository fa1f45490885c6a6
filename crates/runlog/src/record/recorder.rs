//! [`Recorder`]: the samples of a run on their way to a log.

use std::io::{Read, Write};

use bksim_log::{
    EndStatus, Header, Level, LogError, LogReader, LogWriter, NotUnique, Outcome, Quantity, Record,
    Topic, TopicId,
};
use bksim_sim::redundancy::UniquenessChange;
use bksim_sim::run::{RunCheckpoint, Sample, Segment, Summary};
use bksim_sim::sensitivity::StateSensitivity;
use bksim_sim::start::Start;
use bksim_sim::{Mechanism, Simulation};

use super::VERSION;
use super::contents::Contents;
use super::sensitivities::{sensitivity_row, sensitivity_topics};
use super::shown::Shown;
use crate::channels::{Channels, N_MADE};

/// Writes samples to a log.
pub struct Recorder<W: Write> {
    writer: LogWriter<W>,
    header: Header,
    /// The mechanism with the values and options of the simulation.
    mechanism: Mechanism,
    channels: Channels,
    /// One for each topic of the channels.
    topics: Vec<TopicId>,
    /// By quantity: the topics of the derivatives by it, with the number of their fields.
    sensitivities: Vec<Vec<(TopicId, usize)>>,
    /// The channels of programs that know nothing of bksim, where they are wanted.
    shown: Option<Shown>,
    values: Vec<f64>,
    segment: bksim_log::Segment,
}

/// The largest size of the details at the end of a log, bytes.
const MOST_DETAILS: usize = 8 << 20;

impl<W: Write> Recorder<W> {
    /// Opens a log of a run of `simulation`, with the values and options that it has; `options` are the
    /// settings to keep with the model's own.
    ///
    /// # Errors
    /// [`LogError`] when the start of the log cannot be written.
    pub fn create(
        out: W,
        simulation: &Simulation,
        model_text: &str,
        start: &Start,
        options: &[(String, String)],
    ) -> Result<Self, LogError> {
        let contents = Contents { options, ..Contents::default() };
        Self::create_with(out, simulation, model_text, start, &contents)
    }

    /// Recorder ([`Recorder::create`]) with further contents.
    ///
    /// # Errors
    /// [`LogError`] when the start of the log cannot be written.
    pub fn create_with(
        out: W,
        simulation: &Simulation,
        model_text: &str,
        start: &Start,
        contents: &Contents<'_>,
    ) -> Result<Self, LogError> {
        // The values are those of the simulation: the mechanism that it was made from may have others by now.
        let mechanism = simulation.mechanism();
        // The header: model, options, parameters and topics.
        let &Contents { options, sensitive, has_viewers } = contents;
        let mut header = Header::new(&mechanism.model.name, "toml", model_text, VERSION);
        (header.t_start, header.t_end) = (start.t, mechanism.model.solve.t_end);
        header.options = options.iter().cloned().collect();
        for parameter in &mechanism.model.parameters {
            let quantity = Quantity { value: parameter.value, unit: parameter.unit.clone() };
            header.parameters.insert(parameter.name.clone(), quantity);
        }
        let channels = Channels::new(&mechanism);
        let topics = channels.topics.iter().map(|(topic, _)| header.add_topic(topic.clone()));
        let topics = topics.collect();
        let mut add = |topic: Topic| {
            let n_fields = topic.fields.len();
            (header.add_topic(topic), n_fields)
        };
        let by = |&by| sensitivity_topics(&mechanism, by).into_iter().map(&mut add).collect();
        let sensitivities = sensitive.iter().map(by).collect();

        // The log itself, and the channels of other programs.
        let mut writer = LogWriter::create(out, &header)?;
        let shown = if has_viewers { Shown::add(&mut writer, &mechanism)? } else { None };
        let (values, segment) = (Vec::new(), bksim_log::Segment::default());
        let written = Self {
            writer,
            header,
            mechanism,
            channels,
            topics,
            sensitivities,
            shown,
            values,
            segment,
        };
        Ok(written)
    }

    /// Writes one sample to every channel.
    ///
    /// # Errors
    /// [`LogError`] when the log cannot be written, or a value is not finite: [`LogError::NotFinite`] names it.
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

    /// Writes the values of one topic, and after the last one of a sample the channels of viewers.
    fn put(&mut self, topic_idx: usize, t: f64, values: &[f64]) -> Result<(), LogError> {
        self.write_checked(self.topics[topic_idx], t, values)?;
        let Some(shown) = &mut self.shown else { return Ok(()) };
        shown.learn(self.channels.topics[topic_idx].1, values);
        let is_last = topic_idx + 1 == self.topics.len();
        if is_last { shown.write(&mut self.writer, t) } else { Ok(()) }
    }

    /// Writes the values of a topic, each of them finite.
    fn write_checked(&mut self, topic: TopicId, t: f64, values: &[f64]) -> Result<(), LogError> {
        refuse_not_finite(&self.header, topic, t, values)?;
        self.writer.write(topic, t, values)
    }

    /// Writes the motion over a step, ahead of the samples in it.
    ///
    /// # Errors
    /// [`LogError`] when the log cannot be written.
    ///
    /// # Panics
    /// If a dependent row has a number of 2³² or more, which no system has.
    pub fn segment(&mut self, segment: &Segment) -> Result<(), LogError> {
        let Segment { t0, t1, values, modes, dependent } = segment;
        let message = &mut self.segment;
        (message.t, message.t_end) = (*t0, *t1);
        message.values.clone_from(values);
        message.modes.clone_from(modes);
        message.dependent.clear();
        let rows = dependent
            .iter()
            .map(|&row| u32::try_from(row).expect("a system has fewer than 2^32 rows"));
        message.dependent.extend(rows);
        self.writer.segment(message)
    }

    /// Writes which channels are not unique from an instant on.
    ///
    /// # Errors
    /// [`LogError`] when the log cannot be written.
    pub fn uniqueness(&mut self, change: &UniquenessChange) -> Result<(), LogError> {
        self.writer.uniqueness(&NotUnique {
            t: change.t,
            n_self_stresses: change.uniqueness.n_self_stresses,
            channels: self.channels.not_unique(&change.uniqueness),
        })
    }

    /// Writes the sensitivities of a sample, one per quantity.
    ///
    /// # Errors
    /// [`LogError`] when the log cannot be written.
    pub fn write_sensitivities(&mut self, t: f64, by: &[StateSensitivity]) -> Result<(), LogError> {
        for (topics, by) in self.sensitivities.iter().zip(by) {
            self.values.clear();
            self.values.extend(sensitivity_row(by));
            let mut rest = self.values.as_slice();
            for &(topic, n_fields) in topics {
                let (own, after) = rest.split_at(n_fields.min(rest.len()));
                refuse_not_finite(&self.header, topic, t, own)?;
                self.writer.write(topic, t, own)?;
                rest = after;
            }
        }
        Ok(())
    }

    /// Hands the samples so far to the file where they have waited long; to be called between two samples.
    ///
    /// # Errors
    /// [`LogError`] when the log cannot be written.
    pub fn flush_if_due(&mut self) -> Result<(), LogError> {
        self.writer.flush_if_due()
    }

    /// Writes the bytes of a [`RunCheckpoint`] from which the run could go on, and hands all samples so far to the file.
    ///
    /// # Errors
    /// [`LogError`] when the log cannot be written; [`LogError::TooLarge`] leaves it as it was.
    pub fn checkpoint(&mut self, bytes: &[u8]) -> Result<(), LogError> {
        self.writer.checkpoint(bytes)?;
        self.writer.flush()
    }

    /// Copies what belongs to the run out of the log of its first part: the samples and the motion before
    /// `checkpoint`, and the warnings. False, with nothing written, when that log is of another run.
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
        let direction = self.header.direction();
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
                // A step that was not passed to its end is taken again.
                Record::Segment(segment) => {
                    if (checkpoint.t() - segment.t_end) * direction >= 0.0 {
                        self.writer.segment(segment)?;
                    }
                }
                // A change just there may be met again, and then holds the same.
                Record::NotUnique(change) => {
                    if (checkpoint.t() - change.t) * direction >= 0.0 {
                        self.writer.uniqueness(&change)?;
                    }
                }
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

    /// Closes the log with the end of the run, and with the checkpoint of a run that was stopped.
    ///
    /// # Errors
    /// [`LogError`] when the end of the log cannot be written.
    pub fn finish(
        mut self,
        summary: &Summary,
        outcome: Outcome,
        reason: &str,
    ) -> Result<W, LogError> {
        // The state that a stopped run goes on from.
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

        // The end in words, and the objects of `--json`.
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
        end.details = crate::describe::summary(&self.mechanism, summary).to_string();
        if end.details.len() > MOST_DETAILS {
            // Millions of events: the log is worth more than that.
            end.details.clear();
        }
        self.writer.finish(&end)
    }
}

/// The gate of a log: nothing but finite numbers passes.
fn refuse_not_finite(
    header: &Header,
    topic: TopicId,
    t: f64,
    values: &[f64],
) -> Result<(), LogError> {
    let Some(k) = values.iter().position(|value| !value.is_finite()) else { return Ok(()) };
    let topic = &header.topics[topic.index()];
    let channel = topic.fields.get(k).map(|field| topic.column_name(field)).unwrap_or_default();
    Err(LogError::NotFinite { channel, t, value: values[k] })
}
