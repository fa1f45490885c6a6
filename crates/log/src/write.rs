//! Writing a log while the run goes on.

use std::{
    borrow::Cow,
    collections::BTreeMap,
    io::Write,
    time::{Duration, Instant},
};

use foxglove::{Encode, messages};
use mcap::{Attachment, McapResult, WriteOptions, Writer, records::MessageHeader, write::NoSeek};

use crate::{
    EndStatus, Header, LOG_TOPIC, Level, LogError, MOTION_TOPIC, NotUnique, Segment, Topic,
    TopicId,
    compression::compressed,
    frames::RECORD_LIMIT,
    meta, names,
    schema::{self, field_number, motion_number},
    wire,
};

/// A killed run loses at most the samples of this long.
const FLUSH_INTERVAL: Duration = Duration::from_millis(125);
/// Chunks are closed at this size, bytes, if no flush closed them before.
const CHUNK_SIZE: usize = 1 << 20;
/// Chunks are closed at this size even between two samples of one time.
const LARGEST_CHUNK: usize = 8 << 20;
const NANOSECONDS: u64 = 1_000_000_000;

/// Writes one run to a stream of bytes.
///
/// Samples are collected in chunks. A chunk is written whole, when it is large or when an eighth of a
/// second has passed since the last one, and between two times, so that a run that is killed loses few
/// samples, and none by half. A sample waits for the next one, or for [`LogWriter::flush_if_due`]. Only [`LogWriter::finish`] makes the file complete: a writer that is dropped flushes what
/// it can and leaves a log that readers report as cut short, so that an error nobody saw never
/// passes for success. After the first error every call fails with [`LogError::Abandoned`].
#[must_use = "a log is complete only after `finish`"]
pub struct LogWriter<W: Write> {
    /// `None` once a write has failed or the log is finished.
    writer: Option<Writer<NoSeek<W>>>,
    t_start: f64,
    /// 1, or −1 for a run back in time.
    direction: f64,
    channels: Vec<Channel>,
    notes: Channel,
    motion: Channel,
    last_t: f64,
    flush_interval: Duration,
    last_flush: Instant,
    /// Bytes of messages since then.
    n_waiting: usize,
    /// The message being encoded; kept to allocate once.
    message: Vec<u8>,
}

/// A channel that is written to.
#[derive(Debug)]
pub(crate) struct Channel {
    name: String,
    id: u16,
    n_fields: usize,
    n_written: u32,
}

impl<W: Write> LogWriter<W> {
    /// Writes the header and flushes it.
    ///
    /// # Errors
    /// [`LogError::BadName`], [`LogError::DuplicateName`], [`LogError::BadTime`] (a start time that
    /// is not finite), [`LogError::TooLarge`] and [`LogError::Io`].
    pub fn create(out: W, header: &Header) -> Result<LogWriter<W>, LogError> {
        names::check(header)?;
        if !header.t_start.is_finite() {
            return Err(LogError::BadTime { t: header.t_start, previous: header.t_start });
        }
        check_sizes(header)?;

        // Model and metadata.
        let mut writer = write_options(&header.version).create(NoSeek::new(out))?;
        writer.attach(&Attachment {
            log_time: 0,
            create_time: 0,
            name: format!("model.{}", header.model_format),
            media_type: "text/plain".into(),
            data: Cow::Borrowed(header.model_text.as_bytes()),
        })?;
        for record in &meta::header_records(header) {
            writer.write_metadata(record)?;
        }

        // Channels: samples, notes, the motion.
        let channels = header.topics.iter().map(|topic| add_topic(&mut writer, topic));
        let channels = channels.collect::<Result<_, _>>()?;
        let notes = add_published::<messages::Log, W>(&mut writer, LOG_TOPIC, &BTreeMap::new())?;
        let motion_schema = writer.add_schema(
            schema::MOTION_SCHEMA,
            "protobuf",
            &schema::motion_descriptor_set(),
        )?;
        let motion_id =
            writer.add_channel(motion_schema, MOTION_TOPIC, "protobuf", &BTreeMap::new())?;
        writer.flush()?;
        Ok(LogWriter {
            writer: Some(writer),
            t_start: header.t_start,
            direction: header.direction(),
            channels,
            notes,
            motion: Channel::new(MOTION_TOPIC, motion_id, 0),
            last_t: header.t_start,
            flush_interval: FLUSH_INTERVAL,
            last_flush: Instant::now(),
            n_waiting: 0,
            message: Vec::new(),
        })
    }

    /// Sets the time after which a write also flushes: default 0.125 s, range from zero (every write
    /// is flushed at once, larger files) to [`Duration::MAX`] (by chunk size alone).
    pub fn flush_every(mut self, interval: Duration) -> LogWriter<W> {
        self.flush_interval = interval;
        self
    }

    /// Appends the sample of `topic` at time `t`, s: one value per field, any value.
    ///
    /// Time must not run back against the direction of the run, over all topics: readers join the
    /// samples of one time, so write all topics of one time before the next.
    ///
    /// # Errors
    /// [`LogError::WrongLength`], [`LogError::BadTime`] (nothing was written then), or
    /// [`LogError::Io`], after which the log ends with its last whole chunk.
    ///
    /// # Panics
    /// If `topic` was made for another header with more topics.
    pub fn write(&mut self, topic: TopicId, t: f64, values: &[f64]) -> Result<(), LogError> {
        let channel = &self.channels[topic.0];
        if values.len() != channel.n_fields {
            let (expected, given) = (channel.n_fields, values.len());
            return Err(LogError::WrongLength { topic: channel.name.clone(), expected, given });
        }
        self.advance(t)?;
        self.message.clear();
        wire::put_f64(&mut self.message, schema::T_NUMBER, t);
        for (field_idx, &value) in values.iter().enumerate() {
            wire::put_f64(&mut self.message, field_number(field_idx), value);
        }
        let log_time = self.log_time(t);
        let header = self.channels[topic.0].next_message(log_time);
        self.put(header)
    }

    /// Appends the motion over a step, ahead of the samples in it.
    ///
    /// # Errors
    /// [`LogError::BadTime`], [`LogError::TooLarge`] (nothing was written then), [`LogError::Io`].
    pub fn segment(&mut self, segment: &Segment) -> Result<(), LogError> {
        if !segment.t_end.is_finite() {
            return Err(LogError::BadTime { t: segment.t_end, previous: self.last_t });
        }
        let n_bytes = 8 * (segment.values.len() + segment.modes.len() + segment.dependent.len());
        check_size("a step", n_bytes)?;
        self.advance(segment.t)?;
        self.message.clear();
        wire::put_f64(&mut self.message, schema::T_NUMBER, segment.t);
        wire::put_f64(&mut self.message, motion_number::T_END, segment.t_end);
        wire::put_f64s(&mut self.message, motion_number::VALUES, &segment.values);
        wire::put_f64s(&mut self.message, motion_number::MODES, &segment.modes);
        wire::put_u32s(&mut self.message, motion_number::DEPENDENT, &segment.dependent);
        let log_time = self.log_time(segment.t);
        let header = self.motion.next_message(log_time);
        self.put(header)
    }

    /// Appends a line to the topic `/log`; `t` in seconds need not follow the samples. It is kept to
    /// the nanosecond, and not before the start.
    ///
    /// # Errors
    /// [`LogError::BadTime`] for a time that is not finite, [`LogError::Io`],
    /// [`LogError::TooLarge`].
    pub fn note(&mut self, level: Level, t: f64, text: &str) -> Result<(), LogError> {
        if !t.is_finite() {
            return Err(LogError::BadTime { t, previous: self.last_t });
        }
        check_size("a note", text.len())?;
        let log_time = self.log_time(t);
        let message = messages::Log {
            timestamp: Some(self.timestamp(t)),
            level: level as i32,
            message: text.into(),
            name: "bksim".into(),
            ..messages::Log::default()
        };
        self.message.clear();
        // A buffer that grows has room for every message.
        let _ = message.encode(&mut self.message);
        let header = self.notes.next_message(log_time);
        self.put(header)
    }

    /// Adds from when on which channels hold one of many solutions of the equilibrium. What was written
    /// so far is closed as a chunk.
    ///
    /// # Errors
    /// [`LogError::BadTime`] for a time that is not finite, [`LogError::TooLarge`] (nothing was written
    /// then), [`LogError::Io`].
    pub fn uniqueness(&mut self, change: &NotUnique) -> Result<(), LogError> {
        if !change.t.is_finite() {
            return Err(LogError::BadTime { t: change.t, previous: self.last_t });
        }
        let n_bytes = change.channels.iter().map(|name| name.len() + 1).sum();
        check_size("the names of channels that are not unique", n_bytes)?;
        self.attempt(|writer| writer.write_metadata(&meta::uniqueness_record(change)))
    }

    /// Adds the state from which a stopped run goes on: bytes that mean nothing to this crate. Readers
    /// keep the last ones.
    ///
    /// # Errors
    /// [`LogError::TooLarge`] (nothing was written then), [`LogError::Io`].
    pub fn checkpoint(&mut self, bytes: &[u8]) -> Result<(), LogError> {
        check_size("the checkpoint", bytes.len())?;
        self.attempt(|writer| {
            writer.attach(&Attachment {
                log_time: 0,
                create_time: 0,
                name: meta::CHECKPOINT.into(),
                media_type: "application/octet-stream".into(),
                data: Cow::Borrowed(bytes),
            })
        })
    }

    /// Flushes ([`LogWriter::flush`]) where the last flush is long ago; to be called when all samples of a time have
    /// been written, and the next may be long in coming.
    ///
    /// # Errors
    /// [`LogError::Io`].
    pub fn flush_if_due(&mut self) -> Result<(), LogError> {
        let is_due = self.n_waiting > 0
            && (self.n_waiting >= CHUNK_SIZE || self.last_flush.elapsed() >= self.flush_interval);
        if is_due { self.flush() } else { Ok(()) }
    }

    /// Hands everything written so far to the stream and flushes the stream.
    ///
    /// # Errors
    /// [`LogError::Io`].
    pub fn flush(&mut self) -> Result<(), LogError> {
        self.attempt(Writer::flush)?;
        self.last_flush = Instant::now();
        self.n_waiting = 0;
        Ok(())
    }

    /// Writes how the run ended, completes the file, flushes the stream and returns it.
    ///
    /// # Errors
    /// [`LogError::Io`]: the file is not complete, and readers will call it cut short.
    /// [`LogError::TooLarge`]: the summary is.
    pub fn finish(mut self, end: &EndStatus) -> Result<W, LogError> {
        let summary = end.summary.iter().map(|(key, value)| key.len() + value.len() + 16);
        check_size("the summary", summary.sum::<usize>() + end.reason.len() + end.details.len())?;
        self.attempt(|writer| {
            writer.write_metadata(&meta::end_record(end))?;
            writer.finish().map(drop)
        })?;
        let writer = self.writer.take().ok_or(LogError::Abandoned)?;
        Ok(writer.into_inner().into_inner())
    }

    /// Adds a channel of one of Foxglove's messages.
    pub(crate) fn add_published<M: Encode>(
        &mut self,
        topic: &str,
        metadata: &BTreeMap<String, String>,
    ) -> Result<Channel, LogError> {
        let mut channel = None;
        self.attempt(|writer| {
            channel = Some(add_published::<M, W>(writer, topic, metadata)?);
            Ok(())
        })?;
        channel.ok_or(LogError::Abandoned)
    }

    /// Appends one of Foxglove's messages at time `t`.
    pub(crate) fn put_published(
        &mut self,
        channel: &mut Channel,
        t: f64,
        message: &impl Encode,
    ) -> Result<(), LogError> {
        self.message.clear();
        // A buffer that grows has room for every message.
        let _ = message.encode(&mut self.message);
        let header = channel.next_message(self.log_time(t));
        self.put(header)
    }

    /// Time at which the run starts, s.
    pub(crate) fn t_start(&self) -> f64 {
        self.t_start
    }

    /// The log time of `t` as Foxglove's messages have it; saturates after 136 years.
    pub(crate) fn timestamp(&self, t: f64) -> messages::Timestamp {
        let log_time = self.log_time(t);
        let nanoseconds = u32::try_from(log_time % NANOSECONDS).expect("2³² ns are 4 s");
        let seconds = u32::try_from(log_time / NANOSECONDS).unwrap_or(u32::MAX);
        messages::Timestamp::new(seconds, nanoseconds)
    }

    /// Moves on to `t`, unless that is in the past of the run; what came before may be flushed then.
    pub(crate) fn advance(&mut self, t: f64) -> Result<(), LogError> {
        // Also false for a time that is not a number.
        let is_ahead = (t - self.last_t) * self.direction >= 0.0;
        if !is_ahead || !t.is_finite() {
            return Err(LogError::BadTime { t, previous: self.last_t });
        }
        if t != self.last_t || self.n_waiting > LARGEST_CHUNK {
            self.flush_if_due()?;
        }
        self.last_t = t;
        Ok(())
    }

    /// Distance of `t` from the start in nanoseconds; saturates at zero and after 584 years.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "meant to saturate"
    )]
    fn log_time(&self, t: f64) -> u64 {
        ((t - self.t_start) * self.direction * NANOSECONDS as f64).round() as u64
    }

    /// Appends `self.message`.
    fn put(&mut self, header: MessageHeader) -> Result<(), LogError> {
        let message = std::mem::take(&mut self.message);
        let result = self.attempt(|writer| writer.write_to_known_channel(&header, &message));
        self.n_waiting += message.len();
        self.message = message;
        result
    }

    /// Runs one write; after a failure nothing more is written after the torn bytes.
    fn attempt(
        &mut self,
        write: impl FnOnce(&mut Writer<NoSeek<W>>) -> McapResult<()>,
    ) -> Result<(), LogError> {
        let writer = self.writer.as_mut().ok_or(LogError::Abandoned)?;
        let result = write(writer);
        if result.is_err() {
            self.abandon();
        }
        Ok(result?)
    }

    /// Takes the stream out of the MCAP writer, which else would complete the file when dropped.
    fn abandon(&mut self) {
        drop(self.writer.take().map(Writer::into_inner));
    }
}

impl<W: Write> Drop for LogWriter<W> {
    fn drop(&mut self) {
        // A failure here cannot be returned; it shows in the file, which stays incomplete anyway.
        let _ = self.flush();
        self.abandon();
    }
}

impl Channel {
    fn new(name: &str, id: u16, n_fields: usize) -> Channel {
        Channel { name: name.into(), id, n_fields, n_written: 0 }
    }

    /// The sequence number wraps around, as MCAP leaves to the writer.
    fn next_message(&mut self, log_time: u64) -> MessageHeader {
        let sequence = self.n_written;
        self.n_written = sequence.wrapping_add(1);
        MessageHeader { channel_id: self.id, sequence, log_time, publish_time: log_time }
    }
}

fn write_options(version: &str) -> WriteOptions {
    let options = WriteOptions::new()
        .profile("bksim")
        .library(format!("bksim {version}"))
        // They are closed between two times.
        .chunk_size(None)
        // Whole chunks from memory: streams that cannot seek will do, and a kill tears no chunk
        // that had been begun long before.
        .disable_seeking(true);
    compressed(options)
}

fn add_topic<W: Write>(writer: &mut Writer<NoSeek<W>>, topic: &Topic) -> Result<Channel, LogError> {
    let name = schema::schema_name(&topic.name);
    let schema_id = writer.add_schema(&name, "protobuf", &schema::descriptor_set(topic))?;
    let mut metadata = BTreeMap::new();
    for field in &topic.fields {
        for (key, text) in [("unit", &field.unit), ("description", &field.description)] {
            if !text.is_empty() {
                metadata.insert(format!("{}.{key}", field.name), text.clone());
            }
        }
    }
    let id = writer.add_channel(schema_id, &topic.name, "protobuf", &metadata)?;
    Ok(Channel::new(&topic.name, id, topic.fields.len()))
}

/// A channel of one of Foxglove's messages; channels of one message share their schema.
fn add_published<M: Encode, W: Write>(
    writer: &mut Writer<NoSeek<W>>,
    topic: &str,
    metadata: &BTreeMap<String, String>,
) -> McapResult<Channel> {
    let schema_id = match M::get_schema() {
        Some(schema) => writer.add_schema(&schema.name, &schema.encoding, &schema.data)?,
        None => 0,
    };
    let id = writer.add_channel(schema_id, topic, &M::get_message_encoding(), metadata)?;
    Ok(Channel::new(topic, id, 0))
}

/// Refuses what no reader would take; a quarter of the limit leaves room for the framing.
fn check_sizes(header: &Header) -> Result<(), LogError> {
    check_size("the model", header.model_text.len())?;
    let parameters =
        header.parameters.iter().map(|(name, value)| name.len() + value.unit.len() + 40);
    check_size("the parameters", parameters.sum())?;
    check_size(
        "the options",
        header.options.iter().map(|(key, value)| key.len() + value.len() + 8).sum(),
    )?;
    for topic in &header.topics {
        let texts = |field: &crate::Field| {
            64 + 4 * field.name.len() + field.unit.len() + field.description.len()
        };
        check_size("a topic", topic.fields.iter().map(texts).sum())?;
    }
    Ok(())
}

pub(crate) fn check_size(what: &'static str, bytes: usize) -> Result<(), LogError> {
    let (bytes, limit) = (bytes as u64, (RECORD_LIMIT / 4) as u64);
    if bytes > limit { Err(LogError::TooLarge { what, bytes, limit }) } else { Ok(()) }
}
