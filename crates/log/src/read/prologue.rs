//! Everything before the first message, gathered and checked.

use std::collections::BTreeMap;

use mcap::records::{self, Metadata, op};

use super::{Decoder, LogReader, metadata};
use crate::{
    Field, Header, LOG_TOPIC, LogError, MOTION_TOPIC, Segment, Topic,
    frames::{self, Frames, RECORD_LIMIT},
    meta, names,
    schema::{self, Layout},
};

/// The records before the first message.
#[derive(Default)]
pub(super) struct Prologue {
    model_text: Option<Vec<u8>>,
    parameters: Option<Metadata>,
    options: Option<Metadata>,
    run: Option<Metadata>,
    schemas: BTreeMap<u16, (String, Vec<u8>)>,
    channels: Vec<records::Channel>,
    /// Bytes of all records so far.
    n_bytes: usize,
}

impl Prologue {
    pub(super) fn is_complete(&self) -> bool {
        self.parameters.is_some() && self.options.is_some() && self.run.is_some()
    }

    pub(super) fn add(&mut self, opcode: u8, body: &[u8]) -> Result<(), LogError> {
        // Hostile files could repeat records without end.
        self.n_bytes = self.n_bytes.saturating_add(body.len());
        if self.n_bytes > RECORD_LIMIT {
            let (bytes, limit) = (self.n_bytes as u64, RECORD_LIMIT as u64);
            return Err(LogError::TooLarge { what: "the header", bytes, limit });
        }
        match opcode {
            op::ATTACHMENT => {
                let (name, text) = frames::attachment(body)?;
                if name.starts_with("model.") {
                    self.model_text = Some(text);
                }
            }
            op::METADATA => {
                let metadata = metadata(body)?;
                match metadata.name.as_str() {
                    meta::PARAMETERS => self.parameters = Some(metadata),
                    meta::OPTIONS => self.options = Some(metadata),
                    meta::RUN => self.run = Some(metadata),
                    _ => (),
                }
            }
            op::SCHEMA => {
                if let records::Record::Schema { header, data } = mcap::parse_record(opcode, body)?
                {
                    self.schemas.insert(header.id, (header.name, data.into_owned()));
                }
            }
            op::CHANNEL => {
                if let records::Record::Channel(channel) = mcap::parse_record(opcode, body)? {
                    self.channels.push(channel);
                }
            }
            _ => (),
        }
        Ok(())
    }

    pub(super) fn into_reader<R>(self, frames: Frames<R>) -> Result<LogReader<R>, LogError> {
        // The model and the metadata of the run, each with its checksum.
        let missing = |missing| LogError::NotARun { missing };
        let model_text = self.model_text.ok_or(missing("the model"))?;
        let model_sha256 = meta::sha256(&model_text);
        let model_text = String::from_utf8(model_text)
            .map_err(|_| LogError::damaged("the model is not text"))?;

        let mut header = Header::new("", "", &model_text, "");
        let parameters = self.parameters.ok_or(missing("the list of parameters"))?;
        let options = self.options.ok_or(missing("the list of options"))?;
        let mut run = self.run.ok_or(missing("the description of the run"))?;
        if meta::read_header(&parameters, options, &mut run, &mut header)? != model_sha256 {
            return Err(LogError::damaged("the SHA-256 of the model is wrong"));
        }

        // The channels: notes, the motion, samples, and those of other programs.
        let mut decoders = BTreeMap::new();
        for channel in self.channels {
            let (schema_name, schema) = match self.schemas.get(&channel.schema_id) {
                Some((name, schema)) => (name.as_str(), &schema[..]),
                // MCAP leaves channels without a schema to their programs.
                None if channel.schema_id == 0 => ("", &[][..]),
                None => {
                    return Err(LogError::damaged(format!("`{}` has no schema", channel.topic)));
                }
            };
            let id = channel.id;
            let decoder = if channel.topic == LOG_TOPIC && schema_name == schema::LOG {
                Decoder::Note
            } else if !schema::is_own(schema_name) {
                Decoder::Foreign
            } else if channel.topic == MOTION_TOPIC {
                Decoder::Segment
            } else {
                let broken = || LogError::damaged(format!("the schema of `{}`", channel.topic));
                let layout =
                    schema::layout(schema, schema_name).ok().flatten().ok_or_else(broken)?;
                let t_number = layout.t_number.ok_or_else(broken)?;
                let numbers = layout.signals.iter().map(|(_, number)| *number).collect::<Vec<_>>();
                if !numbers.is_sorted_by(|a, b| a < b) {
                    return Err(broken());
                }
                Decoder::Sample {
                    topic: header.add_topic(topic(channel, layout)),
                    t_number,
                    numbers,
                }
            };
            if decoders.insert(id, decoder).is_some() {
                return Err(LogError::damaged(format!("channel {id} is there twice")));
            }
        }
        names::check(&header)?;
        Ok(LogReader {
            frames,
            header,
            model_sha256,
            decoders,
            values: Vec::new(),
            segment: Segment::default(),
            checkpoint: None,
            end: None,
            made: None,
        })
    }
}

fn topic(channel: records::Channel, layout: Layout) -> Topic {
    let mut texts = channel.metadata;
    let mut text =
        |name: &str, key: &str| texts.remove(&format!("{name}.{key}")).unwrap_or_default();
    let field = |(name, _): (String, u64)| Field {
        unit: text(&name, "unit"),
        description: text(&name, "description"),
        name,
    };
    Topic { fields: layout.signals.into_iter().map(field).collect(), name: channel.topic }
}
