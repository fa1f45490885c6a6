//! Reading a log: record by record, or whole.

mod making;
mod prologue;
mod survey;

use std::{collections::BTreeMap, io::Read};

use mcap::records::{self, Metadata, op};

use crate::{
    EndStatus, Header, Level, LogError, NotUnique, Note, Outcome, Segment, Topic, TopicId,
    frames::{self, Frames, State},
    meta,
    schema::{T_NUMBER, motion_number},
    wire::{self, Fields, Malformed, Value},
};
use making::Made;
pub use making::{Make, Making};
use prologue::Prologue;
pub use survey::{Contents, ForeignTopic, Survey, TopicCount};

/// One record of a run.
#[derive(Clone, PartialEq, Debug)]
pub enum Record<'a> {
    /// A sample.
    Sample {
        /// Topic of the record.
        topic: TopicId,
        /// Time, s.
        t: f64,
        /// One value per field of the topic.
        values: &'a [f64],
    },
    /// A line of the topic `/log`.
    Note(Note),
    /// The motion over a step.
    Segment(&'a Segment),
    /// From when on which channels are not unique; of two at one time, the last holds.
    NotUnique(NotUnique),
}

/// The records that a reader makes: see [`LogReader::only`].
#[derive(Clone, PartialEq, Eq, Default, Debug)]
pub struct Request {
    /// Samples of these topics.
    pub topics: Vec<TopicId>,
    /// Lines of the topic `/log`.
    pub notes: bool,
    /// Segments of the motion.
    pub motion: bool,
}

impl Request {
    /// Segments of the motion alone.
    pub const MOTION: Request = Request { topics: Vec::new(), notes: false, motion: true };
}

/// Reads a log from any stream of bytes with bounded memory, checking every checksum.
///
/// A log that was cut short is read up to the cut: [`LogReader::next_record`] ends there, and
/// [`LogReader::end`] stays `None`.
pub struct LogReader<R> {
    frames: Frames<R>,
    header: Header,
    model_sha256: String,
    decoders: BTreeMap<u16, Decoder>,
    values: Vec<f64>,
    segment: Segment,
    checkpoint: Option<Saved<Vec<u8>>>,
    end: Option<EndStatus>,
    made: Option<Made>,
}

/// The last checkpoint so far.
struct Saved<T> {
    checkpoint: T,
    /// Nothing but the end has come after it.
    is_last: bool,
}

impl<T> Saved<T> {
    fn new(checkpoint: T) -> Self {
        Self { checkpoint, is_last: true }
    }

    fn pass_message(&mut self) {
        self.is_last = false;
    }

    /// True if the run goes on from here: one that was stopped has saved its state last of all, and one that
    /// failed would fail again.
    fn holds(&self, state: State, end: Option<&EndStatus>) -> bool {
        match state {
            State::Open => false,
            State::CutShort => true,
            State::Complete => self.is_last && end.is_some_and(|e| e.outcome == Outcome::Stopped),
        }
    }
}

/// The meaning of the messages of one channel.
enum Decoder {
    Sample {
        topic: TopicId,
        t_number: u64,
        /// Field numbers in the order of the topic's fields, which is ascending.
        numbers: Vec<u64>,
    },
    Note,
    Segment,
    /// For other programs.
    Foreign,
}

/// Field numbers of `foxglove.Log`.
mod log_number {
    pub(super) const LEVEL: u32 = 2;
    pub(super) const MESSAGE: u32 = 3;
}

impl<R: Read> LogReader<R> {
    /// Reads everything before the first sample.
    ///
    /// # Errors
    /// [`LogError::NotMcap`], [`LogError::NotARun`] (also for a log cut within its first records),
    /// [`LogError::Damaged`], [`LogError::TooLarge`] and [`LogError::Io`].
    pub fn open(source: R) -> Result<LogReader<R>, LogError> {
        let mut frames = Frames::new(source)?;
        let mut prologue = Prologue::default();
        while let Some(opcode) = frames.peek()? {
            let is_end = opcode == op::METADATA && prologue.is_complete();
            if opcode == op::MESSAGE || is_end {
                break;
            }
            if let Some((opcode, body)) = frames.next()? {
                prologue.add(opcode, body)?;
            }
        }
        prologue.into_reader(frames)
    }

    /// The description of the run.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// SHA-256 of the model text, hexadecimal; verified.
    pub fn model_sha256(&self) -> &str {
        &self.model_sha256
    }

    /// How the run ended: known once [`LogReader::next_record`] has returned `None`, and `None`
    /// then if the log was cut short.
    pub fn end(&self) -> Option<&EndStatus> {
        self.end.as_ref().filter(|_| self.frames.state() == State::Complete)
    }

    /// The state from which a run goes on that was stopped, or whose log was cut short: known once
    /// [`LogReader::next_record`] has returned `None`. In a log that was cut, no checksum but its own
    /// covers it.
    pub fn checkpoint(&self) -> Option<&[u8]> {
        let saved = self.checkpoint.as_ref()?;
        saved.holds(self.frames.state(), self.end.as_ref()).then_some(&saved.checkpoint)
    }

    /// Reader that passes over everything that is not asked for: its bytes are checked, but not
    /// made into records. Changes of uniqueness, the end and the checkpoint are known all the same.
    ///
    /// ```
    /// # use bksim_log::{EndStatus, Field, Header, LogReader, LogWriter, Outcome, Request, Topic};
    /// # let mut header = Header::new("pendulum", "toml", "", "0.1.0");
    /// # let state = header.add_topic(Topic::new("/state", [Field::new("angle", "rad", "")]));
    /// # let mut writer = LogWriter::create(Vec::new(), &header)?;
    /// # writer.write(state, 0.0, &[0.5])?;
    /// # let bytes = writer.finish(&EndStatus::new(Outcome::ReachedEnd, 0.1, ""))?;
    /// let mut motion = LogReader::open(&bytes[..])?.only(&Request::MOTION);
    /// assert_eq!(motion.next_record()?, None);
    /// # Ok::<(), bksim_log::LogError>(())
    /// ```
    #[must_use]
    pub fn only(mut self, request: &Request) -> LogReader<R> {
        self.decoders.retain(|_, decoder| match decoder {
            Decoder::Sample { topic, .. } => {
                let is_needed = |made: &Made| made.needs(*topic, &request.topics);
                request.topics.contains(topic) || self.made.as_ref().is_some_and(is_needed)
            }
            Decoder::Note => request.notes,
            Decoder::Segment => request.motion,
            Decoder::Foreign => false,
        });
        self
    }

    /// Reader with more topics in its header, whose samples it makes from those of the log and gives after
    /// them.
    #[must_use]
    pub fn making(mut self, making: Making) -> LogReader<R> {
        self.made = Some(Made::new(making, &mut self.header));
        self
    }

    /// The next sample, note, step or change of uniqueness, in the order they were written; `None` at the end of the data.
    ///
    /// # Errors
    /// [`LogError::Damaged`], [`LogError::TooLarge`] and [`LogError::Io`]. Records returned before had
    /// the right checksum.
    pub fn next_record(&mut self) -> Result<Option<Record<'_>>, LogError> {
        if self.made.as_ref().is_some_and(Made::is_pending) {
            return Ok(self.made.as_mut().and_then(Made::next));
        }
        while let Some((opcode, body)) = self.frames.next()? {
            match opcode {
                op::METADATA => {
                    let metadata = metadata(body)?;
                    match metadata.name.as_str() {
                        meta::END => self.end = Some(meta::read_end(metadata)?),
                        meta::UNIQUENESS => {
                            let change = meta::read_uniqueness(metadata)?;
                            return Ok(Some(Record::NotUnique(change)));
                        }
                        _ => (),
                    }
                }
                op::ATTACHMENT => {
                    let (name, bytes) = frames::attachment(body)?;
                    if name == meta::CHECKPOINT {
                        self.checkpoint = Some(Saved::new(bytes));
                    }
                }
                op::MESSAGE => {
                    let (channel_id, log_time, message) = message(body)?;
                    self.checkpoint.iter_mut().for_each(Saved::pass_message);
                    match self.decoders.get(&channel_id) {
                        // Some other program may have added a channel later.
                        None | Some(Decoder::Foreign) => (),
                        Some(Decoder::Note) => {
                            let t = self.header.time(log_time);
                            return Ok(Some(Record::Note(decode_note(message, t)?)));
                        }
                        Some(Decoder::Segment) => {
                            decode_segment(message, &mut self.segment).map_err(bad_message)?;
                            return Ok(Some(Record::Segment(&self.segment)));
                        }
                        Some(Decoder::Sample { topic, t_number, numbers }) => {
                            let topic = *topic;
                            let t = decode_sample(message, *t_number, numbers, &mut self.values)?;
                            self.made.iter_mut().for_each(|made| made.take(topic, t, &self.values));
                            return Ok(Some(Record::Sample { topic, t, values: &self.values }));
                        }
                    }
                }
                _ => (),
            }
        }
        Ok(None)
    }
}

fn metadata(body: &[u8]) -> Result<Metadata, LogError> {
    match mcap::parse_record(op::METADATA, body)? {
        records::Record::Metadata(metadata) => Ok(metadata),
        _ => Err(LogError::damaged("a metadata record is none")),
    }
}

/// Channel, log time and data of a message. In between are its number (u32) and, after the log time, the
/// time of publication (u64).
fn message(body: &[u8]) -> Result<(u16, u64, &[u8]), LogError> {
    let parts = || {
        let (channel_id, rest) = body.split_first_chunk::<2>()?;
        let (_, rest) = rest.split_first_chunk::<4>()?;
        let (log_time, rest) = rest.split_first_chunk::<8>()?;
        let (_, data) = rest.split_first_chunk::<8>()?;
        Some((u16::from_le_bytes(*channel_id), u64::from_le_bytes(*log_time), data))
    };
    parts().ok_or_else(|| LogError::damaged("a message is none"))
}

/// Fills `values` and returns the time.
fn decode_sample(
    message: &[u8],
    t_number: u64,
    numbers: &[u64],
    values: &mut Vec<f64>,
) -> Result<f64, LogError> {
    // bksim writes every field, nine bytes or more: refusing less keeps the work for a message in
    // proportion to its bytes.
    if message.len() / 9 <= numbers.len() {
        return Err(LogError::damaged("a sample lacks some of its fields"));
    }
    values.clear();
    values.resize(numbers.len(), 0.0);
    let mut t = 0.0;
    // Writers keep the order of the fields, so the next one is nearly always the one expected.
    let mut expected_idx = 0;
    for field in Fields::new(message) {
        let (number, Value::Fixed64(bits)) = field.map_err(bad_message)? else { continue };
        let value = f64::from_bits(bits);
        if number == t_number {
            t = value;
            continue;
        }
        let field_idx = match numbers.get(expected_idx) {
            Some(&expected) if expected == number => expected_idx,
            _ => match numbers.binary_search(&number) {
                Ok(field_idx) => field_idx,
                Err(_) => continue,
            },
        };
        values[field_idx] = value;
        expected_idx = field_idx + 1;
    }
    Ok(t)
}

fn decode_note(message: &[u8], t: f64) -> Result<Note, LogError> {
    let mut note = Note { level: Level::Info, t, text: String::new() };
    for field in Fields::new(message) {
        let (number, value) = field.map_err(bad_message)?;
        match (u32::try_from(number), value) {
            (Ok(log_number::LEVEL), Value::Varint(level)) => note.level = level_of(level),
            (Ok(log_number::MESSAGE), Value::Bytes(text)) => {
                note.text = String::from_utf8_lossy(text).into_owned();
            }
            _ => (),
        }
    }
    Ok(note)
}

fn decode_segment(message: &[u8], segment: &mut Segment) -> Result<(), Malformed> {
    (segment.t, segment.t_end) = (0.0, 0.0);
    segment.values.clear();
    segment.modes.clear();
    segment.dependent.clear();
    for field in Fields::new(message) {
        let (number, value) = field?;
        match (u32::try_from(number), value) {
            (Ok(T_NUMBER), Value::Fixed64(bits)) => segment.t = f64::from_bits(bits),
            (Ok(motion_number::T_END), Value::Fixed64(bits)) => {
                segment.t_end = f64::from_bits(bits);
            }
            (Ok(motion_number::VALUES), Value::Bytes(bytes)) => {
                segment.values.extend(wire::f64s(bytes)?);
            }
            (Ok(motion_number::MODES), Value::Bytes(bytes)) => {
                segment.modes.extend(wire::f64s(bytes)?);
            }
            (Ok(motion_number::DEPENDENT), Value::Bytes(bytes)) => {
                segment.dependent.extend(wire::u32s(bytes)?);
            }
            _ => (),
        }
    }
    Ok(())
}

fn level_of(number: u64) -> Level {
    match number {
        0 | 1 => Level::Debug,
        2 => Level::Info,
        3 => Level::Warning,
        _ => Level::Error,
    }
}

fn bad_message(_: Malformed) -> LogError {
    LogError::damaged("a message is not protobuf")
}

impl NotUnique {
    /// Adds a change to those before it; of two at one time, the last holds.
    pub fn add_to(self, changes: &mut Vec<NotUnique>) {
        match changes.last_mut() {
            Some(last) if last.t == self.t => *last = self,
            _ => changes.push(self),
        }
    }
}

/// A whole log in memory: samples take 8 bytes per value.
#[derive(Clone, PartialEq, Debug)]
pub struct Log {
    /// The description of the run.
    pub header: Header,
    /// SHA-256 of the model text, hexadecimal; verified.
    pub model_sha256: String,
    /// Warnings and events in the order they were written.
    pub notes: Vec<Note>,
    /// How the run ended; `None` if the log was cut short.
    pub end: Option<EndStatus>,
    series: Vec<Series>,
}

/// All samples of one topic.
#[derive(Clone, PartialEq, Default, Debug)]
pub struct Series {
    /// Times, s.
    pub t: Vec<f64>,
    /// The values of each field, each as long as `t`.
    pub columns: Vec<Vec<f64>>,
}

impl Log {
    /// Reads a log to its end, or to where it was cut short.
    ///
    /// # Errors
    /// As [`LogReader::open`] and [`LogReader::next_record`].
    pub fn read(source: impl Read) -> Result<Log, LogError> {
        let mut reader = LogReader::open(source)?;
        let empty = |topic: &Topic| Series { t: vec![], columns: vec![vec![]; topic.fields.len()] };
        let mut series: Vec<_> = reader.header.topics.iter().map(empty).collect();
        let mut notes = Vec::new();
        while let Some(record) = reader.next_record()? {
            match record {
                Record::Note(note) => notes.push(note),
                // As large as all samples, and read by those who ask for it.
                Record::Segment(_) | Record::NotUnique(_) => (),
                Record::Sample { topic, t, values } => {
                    let series = &mut series[topic.0];
                    series.t.push(t);
                    for (column, &value) in series.columns.iter_mut().zip(values) {
                        column.push(value);
                    }
                }
            }
        }
        let end = reader.end().cloned();
        let LogReader { header, model_sha256, .. } = reader;
        Ok(Log { header, model_sha256, notes, end, series })
    }

    /// The samples of a topic of [`Log::header`].
    ///
    /// # Panics
    /// If `topic` was made for another header with more topics.
    pub fn series(&self, topic: TopicId) -> &Series {
        &self.series[topic.0]
    }
}
