//! The contents of a file, counted without making its messages into samples.

use std::{collections::BTreeMap, io::Read};

use mcap::records::{self, op};

use super::{Decoder, LogReader, Saved, bad_message, decode_note, message, metadata};
use crate::{
    EndStatus, Header, LogError, NotUnique, Note,
    frames::{self, Frames, RECORD_LIMIT, State},
    meta,
    wire::{Fields, Value},
};

/// A log in numbers.
#[derive(Clone, PartialEq, Debug)]
pub struct Survey {
    /// The description of the run.
    pub header: Header,
    /// SHA-256 of the model text, hexadecimal; verified.
    pub model_sha256: String,
    /// Samples of each topic of the header, in its order.
    pub topics: Vec<TopicCount>,
    /// Steps whose motion is kept.
    pub n_segments: u64,
    /// Bytes of that motion, before compression.
    pub motion_bytes: u64,
    /// First and last time of its samples, s.
    pub span: Option<[f64; 2]>,
    /// Warnings and events, the first 10 000 of them.
    pub notes: Vec<Note>,
    /// All warnings and events.
    pub n_notes: u64,
    /// Messages of channels that some other program added.
    pub n_foreign: u64,
    /// Bytes of the state from which a run goes on that was stopped, or whose log was cut short.
    pub checkpoint_bytes: Option<usize>,
    /// From when on which channels are not unique, in the order of the run.
    pub not_unique: Vec<NotUnique>,
    /// How the run ended; `None` if the log was cut short.
    pub end: Option<EndStatus>,
}

/// Samples of a topic.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct TopicCount {
    /// How many there are.
    pub n_samples: u64,
    /// Their bytes, before compression.
    pub bytes: u64,
}

/// More notes than anyone reads; those that are kept stay small.
const MAX_NOTES: usize = 10_000;

impl Survey {
    /// Reads a log to its end, or to where it was cut short.
    ///
    /// # Errors
    /// As [`LogReader::open`] and [`LogReader::next_record`].
    pub fn read(source: impl Read) -> Result<Survey, LogError> {
        let mut log = LogReader::open(source)?;
        let mut survey = Survey {
            header: log.header.clone(),
            model_sha256: std::mem::take(&mut log.model_sha256),
            topics: vec![TopicCount::default(); log.header.topics.len()],
            n_segments: 0,
            motion_bytes: 0,
            span: None,
            notes: Vec::new(),
            n_notes: 0,
            n_foreign: 0,
            checkpoint_bytes: None,
            not_unique: Vec::new(),
            end: None,
        };
        // Every record after the header.
        let mut checkpoint = None;
        while let Some((opcode, body)) = log.frames.next()? {
            match opcode {
                op::METADATA => {
                    let metadata = metadata(body)?;
                    match metadata.name.as_str() {
                        meta::END => survey.end = Some(meta::read_end(metadata)?),
                        meta::UNIQUENESS => {
                            meta::read_uniqueness(metadata)?.add_to(&mut survey.not_unique);
                        }
                        _ => (),
                    }
                }
                op::ATTACHMENT => {
                    let (name, bytes) = frames::attachment(body)?;
                    if name == meta::CHECKPOINT {
                        checkpoint = Some(Saved::new(bytes.len()));
                    }
                }
                op::MESSAGE => {
                    let (channel_id, log_time, message) = message(body)?;
                    let t = survey.header.time(log_time);
                    checkpoint.iter_mut().for_each(Saved::pass_message);
                    survey.count(log.decoders.get(&channel_id), t, message)?;
                }
                _ => (),
            }
        }
        let state = log.frames.state();
        let held =
            checkpoint.filter(|saved: &Saved<usize>| saved.holds(state, survey.end.as_ref()));
        survey.checkpoint_bytes = held.map(|saved| saved.checkpoint);
        // Without the checksum of the whole, its end is not to be trusted.
        if state != State::Complete {
            survey.end = None;
        }
        Ok(survey)
    }

    /// `t` is the time of the message to a nanosecond.
    fn count(&mut self, decoder: Option<&Decoder>, t: f64, message: &[u8]) -> Result<(), LogError> {
        let bytes = message.len() as u64;
        match decoder {
            None | Some(Decoder::Foreign) => self.n_foreign += 1,
            Some(Decoder::Segment) => {
                self.n_segments += 1;
                self.motion_bytes += bytes;
            }
            Some(Decoder::Note) => {
                self.n_notes += 1;
                if self.notes.len() < MAX_NOTES {
                    self.notes.push(decode_note(message, t)?);
                }
            }
            Some(Decoder::Sample { topic, t_number, .. }) => {
                let count = &mut self.topics[topic.0];
                count.n_samples += 1;
                count.bytes += bytes;
                let t = time(message, *t_number)?;
                self.span.get_or_insert([t, t])[1] = t;
            }
        }
        Ok(())
    }
}

/// Time of a sample, which writers put first.
fn time(message: &[u8], t_number: u64) -> Result<f64, LogError> {
    for field in Fields::new(message) {
        if let (number, Value::Fixed64(bits)) = field.map_err(bad_message)?
            && number == t_number
        {
            return Ok(f64::from_bits(bits));
        }
    }
    Ok(0.0)
}

/// The contents of an MCAP file that bksim did not write.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Contents {
    /// The kind of file it says it is; may be empty.
    pub profile: String,
    /// The program that wrote it; may be empty.
    pub library: String,
    /// Topics of the log, by their names.
    pub topics: Vec<ForeignTopic>,
    /// True if the file ends as it should.
    pub is_complete: bool,
}

/// A topic of such a file.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
pub struct ForeignTopic {
    /// Name of the topic.
    pub name: String,
    /// Name of its schema; may be empty.
    pub schema: String,
    /// How its messages are written, such as `protobuf` or `json`.
    pub encoding: String,
    /// Messages.
    pub n_messages: u64,
}

impl Contents {
    /// Reads any MCAP file to its end, or to where it was cut short.
    ///
    /// # Errors
    /// [`LogError::NotMcap`], [`LogError::Damaged`] (also for compressions other than Zstandard),
    /// [`LogError::TooLarge`] and [`LogError::Io`].
    pub fn read(source: impl Read) -> Result<Contents, LogError> {
        let mut frames = Frames::new(source)?;
        let mut contents = Contents::default();
        let mut schemas: BTreeMap<u16, String> = BTreeMap::new();
        let mut topics: BTreeMap<u16, ForeignTopic> = BTreeMap::new();
        // Hostile files could add names without end.
        let mut n_bytes = 0;
        while let Some((opcode, body)) = frames.next()? {
            // Messages are counted alone.
            match opcode {
                op::HEADER | op::SCHEMA | op::CHANNEL => n_bytes += body.len(),
                op::MESSAGE => {
                    let (channel_id, ..) = message(body)?;
                    if let Some(topic) = topics.get_mut(&channel_id) {
                        topic.n_messages += 1;
                    }
                    continue;
                }
                _ => continue,
            }
            if n_bytes > RECORD_LIMIT {
                let (bytes, limit) = (n_bytes as u64, RECORD_LIMIT as u64);
                return Err(LogError::TooLarge { what: "the list of topics", bytes, limit });
            }
            // Names of the file, its schemas and its channels.
            match mcap::parse_record(opcode, body)? {
                records::Record::Header(header) => {
                    (contents.profile, contents.library) = (header.profile, header.library);
                }
                records::Record::Schema { header, .. } => {
                    schemas.insert(header.id, header.name);
                }
                records::Record::Channel(channel) => {
                    let schema = schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                    let topic = ForeignTopic {
                        name: channel.topic,
                        schema,
                        encoding: channel.message_encoding,
                        n_messages: 0,
                    };
                    topics.entry(channel.id).or_insert(topic);
                }
                _ => (),
            }
        }
        contents.is_complete = frames.state() == State::Complete;
        contents.topics = topics.into_values().collect();
        contents.topics.sort();
        Ok(contents)
    }
}
