//! From bytes to records: framing, decompression and checksums, with memory bounded by constants.
//!
//! Traps that shape this file. The reader of whole files in `mcap` believes the lengths it reads and
//! asks for gigabytes; its record-by-record reader takes a limit, but subtracts past zero when a
//! record in an uncompressed chunk is longer than the chunk, so chunks are opened here. Checksums
//! are verified only when asked for. `mcap::parse_record` slices past the end of an attachment
//! that is too short.

use std::io::{ErrorKind, Read};

use mcap::{
    McapError,
    records::{ChunkHeader, op},
    sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions},
};

use crate::LogError;
use crate::compression::Decompressor;

/// Largest record, and largest chunk after decompression, bytes.
pub(crate) const RECORD_LIMIT: usize = 64 << 20;
/// Bytes asked for at a time, so that memory follows what is there, not what a length claims.
const READ_SIZE: usize = 64 << 10;
/// Opcode and length.
const PREFIX: usize = 1 + 8;

/// The records of the data section, one after the other, those in chunks included.
pub(crate) struct Frames<R> {
    source: R,
    linear: LinearReader,
    /// Records not yet handed out: one chunk after decompression, or one record by itself.
    records: Vec<u8>,
    position: usize,
    decompressor: Decompressor,
    state: State,
}

/// How far the stream was read.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum State {
    /// More may come.
    Open,
    /// The data section ended as it should, and its checksum is right.
    Complete,
    /// The bytes ended before the data section did.
    CutShort,
}

impl<R: Read> Frames<R> {
    pub(crate) fn new(source: R) -> Result<Frames<R>, LogError> {
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_skip_end_magic(true)
            .with_validate_data_section_crc(true)
            .with_record_length_limit(RECORD_LIMIT);
        Ok(Frames {
            source,
            linear: LinearReader::new_with_options(options),
            records: Vec::new(),
            position: 0,
            decompressor: Decompressor::new()?,
            state: State::Open,
        })
    }

    pub(crate) fn state(&self) -> State {
        self.state
    }

    /// Opcode of the next record, which stays the next one; `None` at the end of the data.
    pub(crate) fn peek(&mut self) -> Result<Option<u8>, LogError> {
        while self.position == self.records.len() {
            if self.state != State::Open {
                return Ok(None);
            }
            self.load()?;
        }
        Ok(Some(self.records[self.position]))
    }

    /// Opcode and body of the next record; `None` at the end of the data.
    pub(crate) fn next(&mut self) -> Result<Option<(u8, &[u8])>, LogError> {
        let Some(opcode) = self.peek()? else {
            return Ok(None);
        };
        let broken = || LogError::damaged("a record is longer than its chunk");
        let (prefix, rest) =
            self.records[self.position..].split_at_checked(PREFIX).ok_or_else(broken)?;
        let length = prefix[1..].try_into().map_or(u64::MAX, u64::from_le_bytes);
        let length = usize::try_from(length).map_err(|_| broken())?;
        let body = rest.get(..length).ok_or_else(broken)?;
        self.position += PREFIX + length;
        Ok(Some((opcode, body)))
    }

    /// Fills `records` with the next chunk or record, or leaves it empty and sets the state.
    fn load(&mut self) -> Result<(), LogError> {
        self.position = 0;
        self.records.clear();
        while let Some(event) = self.linear.next_event() {
            match event {
                Ok(LinearReadEvent::ReadRequest(n_bytes)) => {
                    let space = self.linear.insert(n_bytes.min(READ_SIZE));
                    let n_read = read_some(&mut self.source, space)?;
                    self.linear.notify_read(n_read);
                }
                Ok(LinearReadEvent::Record { opcode: op::DATA_END, .. }) => {
                    self.state = State::Complete;
                    return Ok(());
                }
                Ok(LinearReadEvent::Record { opcode: op::CHUNK, data }) => {
                    return open_chunk(data, &mut self.decompressor, &mut self.records);
                }
                Ok(LinearReadEvent::Record { opcode, data }) => {
                    self.records.push(opcode);
                    self.records.extend_from_slice(&(data.len() as u64).to_le_bytes());
                    self.records.extend_from_slice(data);
                    return Ok(());
                }
                Err(McapError::UnexpectedEof) => break,
                Err(error) => return Err(error.into()),
            }
        }
        self.state = State::CutShort;
        Ok(())
    }
}

fn read_some(source: &mut impl Read, space: &mut [u8]) -> Result<usize, LogError> {
    loop {
        match source.read(space) {
            Err(error) if error.kind() == ErrorKind::Interrupted => (),
            result => return Ok(result?),
        }
    }
}

/// Decompresses a chunk into `records` and verifies its checksum before anyone sees it.
fn open_chunk(
    body: &[u8],
    decompressor: &mut Decompressor,
    records: &mut Vec<u8>,
) -> Result<(), LogError> {
    let mcap::records::Record::Chunk { header, data } = mcap::parse_record(op::CHUNK, body)? else {
        return Err(LogError::damaged("a chunk is none"));
    };
    let ChunkHeader { uncompressed_size: bytes, uncompressed_crc, compression, .. } = header;
    let limit = RECORD_LIMIT as u64;
    let size = usize::try_from(bytes).unwrap_or(usize::MAX);
    if size > RECORD_LIMIT {
        return Err(LogError::TooLarge { what: "a chunk", bytes, limit });
    }
    match compression.as_str() {
        "" => records.extend_from_slice(&data),
        "zstd" => *records = decompressor.open(&data, size)?,
        other => return Err(LogError::damaged(format!("unknown compression `{other}`"))),
    }
    if records.len() != size {
        return Err(LogError::damaged("a chunk does not have its size"));
    }
    if uncompressed_crc != 0 && crc32fast::hash(records) != uncompressed_crc {
        return Err(LogError::damaged("the checksum of a chunk is wrong"));
    }
    Ok(())
}

/// Name and data of an attachment.
pub(crate) fn attachment(body: &[u8]) -> Result<(String, Vec<u8>), LogError> {
    let broken = || LogError::damaged("an attachment is shorter than it says");
    // log_time and create_time (u64), name and media type (u32 and text), data length (u64), data,
    // CRC (u32): the last two are what `parse_record` does not check.
    let text_end = |start: usize| {
        let length =
            body.get(start..)?.first_chunk::<4>().map(|bytes| u32::from_le_bytes(*bytes))?;
        (start + 4).checked_add(usize::try_from(length).ok()?)
    };
    let texts_end = text_end(16).and_then(text_end).ok_or_else(broken)?;
    if body.len().checked_sub(8 + 4).is_none_or(|room| room < texts_end) {
        return Err(broken());
    }
    match mcap::parse_record(op::ATTACHMENT, body)? {
        mcap::records::Record::Attachment { header, data, .. } => {
            Ok((header.name, data.into_owned()))
        }
        _ => Err(broken()),
    }
}
