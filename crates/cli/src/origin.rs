//! Results of earlier commands: which model a file was made from, by what is in it.
//!
//! A command replaces what bksim made from the same file, and nothing else: a file is known by its name and that of
//! its folder, a log also by the text of its model. There is one rule for each kind of format. Logs and Parquet tables
//! name the file of their model. Whatever has remarks, comments or boxes that its readers pass
//! over ends with a mark, which [`stamped()`] sets and which has a checksum: a file that somebody has edited since
//! is no longer ours. A table of CSV has room for nothing but columns and numbers: it is known by its headings, when
//! each is one that this command knows, and by its numbers, each written as bksim writes it; see `table`.

mod mark;
mod table;

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;

use bksim::log::{Header, LogReader};
pub use bksim_load::label_of;

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

/// The option of a log that names the file of its model, as [`label_of`] does.
pub const MODEL_FILE: &str = "model_file";

/// The file that the run of a log was made from; the name of the model where the log does not say.
pub fn file_of(header: &Header) -> String {
    header.options.get(MODEL_FILE).unwrap_or(&header.model_name).clone()
}

/// True for a whole log of a run of exactly this text.
pub fn is_of_text(path: &Path, text: &str) -> bool {
    whole_log(path).is_ok_and(|header| header.is_some_and(|header| header.model_text == text))
}

/// True for a whole file that bksim made from the model in the file of this [label](label_of).
///
/// A log that is still being written, was cut off, or whose run was stopped before its end, is none: it may be all
/// that there is of a long run, which can go on from there.
pub fn is_of_model(path: &Path, label: &str) -> bool {
    read_model(path, label).unwrap_or(false)
}

/// True for a file that may be one of bksim's, of whichever model: a long question begins only then.
pub fn may_be_own(path: &Path) -> bool {
    is_table(path) || bytes_of(path).is_ok_and(|bytes| mark::is_marked(&bytes))
}

/// Sets the mark of a film or a picture that has been written, but for one larger than 256 MB.
///
/// # Errors
/// Those of the file.
pub fn stamp_file(path: &Path, ending: &Path, label: &str) -> io::Result<()> {
    let bytes = bytes_of(path)?;
    let n_before = bytes.len() as u64;
    if n_before == MOST_MARKED {
        return Ok(());
    }
    let marked = stamped(ending, bytes, label);
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

fn read_model(path: &Path, label: &str) -> io::Result<bool> {
    let mut file = File::open(path)?;
    // Nothing but a file has an end to look at.
    if !file.metadata()?.is_file() {
        return Ok(false);
    }
    let mut first = [0; 8];
    file.read_exact(&mut first)?;
    let last = tail(&mut file, 8)?;
    if first == MCAP {
        return Ok(whole_log(path)?.is_some_and(|header| file_of(&header) == label));
    }
    if first.starts_with(&PARQUET) && last.ends_with(&PARQUET) {
        let length = [last[0], last[1], last[2], last[3]];
        let metadata = tail(&mut file, (u64::from(u32::from_le_bytes(length)) + 8).min(MOST))?;
        return Ok(holds(&metadata, &parquet_entry("bksim.model_file", label)));
    }
    Ok(mark::is_stamped(&bytes_of(path)?, label))
}

/// The header of a whole log whose run has ended and cannot go on; none of any other file.
fn whole_log(path: &Path) -> io::Result<Option<Header>> {
    let mut file = File::open(path)?;
    if !file.metadata()?.is_file() || tail(&mut file, 8)? != MCAP {
        return Ok(None);
    }
    file.rewind()?;
    let Ok(mut log) = LogReader::open(BufReader::new(file)) else { return Ok(None) };
    // Whether a run can go on is known at the end of its log.
    let is_whole = read_through(&mut log) && log.end().is_some() && log.checkpoint().is_none();
    Ok(is_whole.then(|| log.header().clone()))
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
