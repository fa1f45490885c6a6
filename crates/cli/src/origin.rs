//! Results of earlier commands: which model a file was made from, by what is in it.
//!
//! A command replaces what bksim made from the same model, and nothing else. There is one rule for each kind of
//! format. Logs and Parquet tables name their model. Whatever has remarks, comments or boxes that its readers pass
//! over ends with a mark, which [`stamped()`] sets and which has a checksum: a file that somebody has edited since
//! is no longer ours. A table of CSV has room for nothing but columns and numbers: it is known by its headings, when
//! each is one that this command knows, and by its numbers, each written as bksim writes it; see `table`.

mod mark;
mod table;

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;

use bksim::log::LogReader;

pub use self::mark::stamped;
pub use self::table::{has_headings, headings, is_table};

/// First and last bytes of a log that is whole.
const MCAP: [u8; 8] = *b"\x89MCAP0\r\n";
/// Last bytes of a Parquet table.
const PARQUET: [u8; 4] = *b"PAR1";
/// Most bytes that the end of a Parquet table may have.
const MOST: u64 = 1 << 20;
/// Most bytes of a picture, a film or a text with a mark.
const MOST_MARKED: u64 = 1 << 28;

/// True for a whole file that bksim made from the model of this name.
///
/// A log that is still being written, was cut off, or whose run was stopped before its end, is none: it may be all
/// that there is of a long run, which can go on from there.
pub fn is_of_model(path: &Path, model_name: &str) -> bool {
    read_model(path, model_name).unwrap_or(false)
}

/// True for a file that may be one of bksim's, of whichever model: a long question begins only then.
pub fn may_be_own(path: &Path) -> bool {
    is_table(path) || bytes_of(path).is_ok_and(|bytes| mark::is_marked(&bytes))
}

/// Sets the mark of a film or a picture that has been written, but for one larger than 256 MB.
///
/// # Errors
/// Those of the file.
pub fn stamp_file(path: &Path, ending: &Path, model_name: &str) -> io::Result<()> {
    let bytes = bytes_of(path)?;
    let n_before = bytes.len() as u64;
    if n_before == MOST_MARKED {
        return Ok(());
    }
    let marked = stamped(ending, bytes, model_name);
    if marked.len() as u64 == n_before {
        return Ok(());
    }
    std::fs::OpenOptions::new().write(true).truncate(true).open(path)?.write_all(&marked)
}

/// The bytes of a file, at most [`MOST_MARKED`] of them.
fn bytes_of(path: &Path) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    // Nothing but a file has an end.
    if !file.metadata()?.is_file() {
        return Err(io::ErrorKind::Unsupported.into());
    }
    let mut bytes = Vec::new();
    file.take(MOST_MARKED).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn read_model(path: &Path, model_name: &str) -> io::Result<bool> {
    let mut file = File::open(path)?;
    // Nothing but a file has an end to look at.
    if !file.metadata()?.is_file() {
        return Ok(false);
    }
    let mut first = [0; 8];
    file.read_exact(&mut first)?;
    let last = tail(&mut file, 8)?;
    if first == MCAP {
        file.rewind()?;
        let is_own = LogReader::open(BufReader::new(file)).is_ok_and(|mut log| {
            // Whether a run can go on is known at the end of its log.
            let is_named = log.header().model_name == model_name;
            let is_read = is_named && last == MCAP && read_through(&mut log);
            is_read && log.end().is_some() && log.checkpoint().is_none()
        });
        return Ok(is_own);
    }
    if first.starts_with(&PARQUET) && last.ends_with(&PARQUET) {
        let length = [last[0], last[1], last[2], last[3]];
        let metadata = tail(&mut file, (u64::from(u32::from_le_bytes(length)) + 8).min(MOST))?;
        return Ok(holds(&metadata, &parquet_entry("bksim.model_name", model_name)));
    }
    Ok(mark::is_stamped(&bytes_of(path)?, model_name))
}

/// True where a log can be read to its end.
fn read_through<R: Read>(log: &mut LogReader<R>) -> bool {
    loop {
        match log.next_record() {
            Ok(Some(_)) => (),
            Ok(None) => return true,
            Err(_) => return false,
        }
    }
}

/// The last `n` bytes of a file, or all of a shorter one.
fn tail(file: &mut File, n: u64) -> io::Result<Vec<u8>> {
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(n)))?;
    let mut bytes = Vec::new();
    file.take(n).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// An entry of key-value metadata as it stands in a Parquet table: the key, the type of a text in Thrift's compact
/// protocol, the length of the value in groups of seven bits, the value.
fn parquet_entry(key: &str, value: &str) -> Vec<u8> {
    const TEXT: u8 = 0x18;
    let mut bytes = key.as_bytes().to_vec();
    bytes.push(TEXT);
    let mut length = value.len();
    while length >= 0x80 {
        bytes.push(length.to_le_bytes()[0] | 0x80);
        length >>= 7;
    }
    bytes.push(length.to_le_bytes()[0]);
    bytes.extend(value.as_bytes());
    bytes
}

fn holds(bytes: &[u8], part: &[u8]) -> bool {
    bytes.windows(part.len()).any(|window| window == part)
}
