//! Results of earlier commands: which model a file was made from, by what is in it.
//!
//! A command replaces what bksim made from the same model, and nothing else. Logs and Parquet tables name their
//! model. Pictures and texts end with a mark, a PNG with it as its last comment, which [`stamped()`] sets and which has a checksum: one that somebody
//! has edited since is no longer ours. A table of CSV has nothing but its columns: it is known when each of
//! them is one that the same log has.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use bksim::log::LogReader;
use sha2::{Digest, Sha256};

/// First and last bytes of a log that is whole.
const MCAP: [u8; 8] = *b"\x89MCAP0\r\n";
/// Last bytes of a Parquet table.
const PARQUET: [u8; 4] = *b"PAR1";
/// Endings of formats with remarks.
const MARKED: [&str; 8] = ["svg", "html", "htm", "pdf", "py", "c", "h", "rs"];
/// First bytes of a PNG, and its last chunk.
const PNG: [u8; 8] = *b"\x89PNG\r\n\x1a\n";
const PNG_END: [u8; 12] = *b"\0\0\0\0IEND\xaeB\x60\x82";
/// Most bytes that the heading of a table or the end of a table may have.
const MOST: u64 = 1 << 20;
/// Most bytes of a picture or a text with a mark.
const MOST_MARKED: u64 = 1 << 28;

/// True for a whole file that bksim made from the model of this name.
///
/// A log that is still being written, was cut off, or whose run was stopped before its end, is none: it may be all
/// that there is of a long run, which can go on from there.
pub fn is_of_model(path: &Path, model_name: &str) -> bool {
    read_model(path, model_name).unwrap_or(false)
}

/// True for a table (CSV) that bksim made, all of whose columns are among these; the first is `first`.
pub(crate) fn has_columns<'a>(
    path: &Path,
    first: &str,
    known: &(impl Iterator<Item = &'a str> + Clone),
) -> bool {
    let Ok(file) = File::open(path) else { return false };
    let mut line = String::new();
    if BufReader::new(file.take(MOST)).read_line(&mut line).is_err() || !line.ends_with('\n') {
        return false;
    }
    // Names of channels have no commas.
    let mut names = line.trim_end().split(',').map(without_unit);
    names.next() == Some(first) && names.all(|name| known.clone().any(|known| known == name))
}

/// The name in a heading such as `A.angle [deg]`.
fn without_unit(heading: &str) -> &str {
    heading
        .strip_suffix(']')
        .and_then(|rest| rest.rsplit_once(" ["))
        .map_or(heading, |(name, _)| name)
}

/// A picture, a page or a text with a mark at its end that names the model. The ending of `path` tells how its
/// format has remarks; what has none, such as JSON, has no mark.
pub fn stamped(path: &Path, mut bytes: Vec<u8>, model_name: &str) -> Vec<u8> {
    let ending = path.extension().and_then(OsStr::to_str).unwrap_or_default().to_ascii_lowercase();
    if bytes.starts_with(&PNG) && bytes.ends_with(&PNG_END) {
        let end = bytes.len() - PNG_END.len();
        let comment = png_comment(&mark(model_name, &bytes));
        bytes.splice(end..end, comment);
        return bytes;
    }
    if !MARKED.contains(&ending.as_str()) {
        return bytes;
    }
    if bytes.last().is_some_and(|&last| last != b'\n') {
        bytes.push(b'\n');
    }
    let mark = mark(model_name, &bytes);
    let remark = match ending.as_str() {
        "svg" | "html" | "htm" => format!("<!-- {mark} -->\n"),
        "pdf" => format!("% {mark}\n"),
        "py" => format!("# {mark}\n"),
        _ => format!("// {mark}\n"),
    };
    bytes.extend(remark.into_bytes());
    bytes
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
    file.rewind()?;
    let mut bytes = Vec::new();
    file.take(MOST_MARKED).read_to_end(&mut bytes)?;
    if bytes.starts_with(&PNG) {
        let length = PNG_END.len() + png_comment(&mark(model_name, &[])).len();
        let Some(end) = bytes.len().checked_sub(length) else { return Ok(false) };
        let content = [&bytes[..end], &PNG_END].concat();
        return Ok(stamped(path, content, model_name) == bytes);
    }
    let ends = bytes.iter().rev().skip(1).position(|&byte| byte == b'\n');
    let content = ends.map_or(&[][..], |remark| &bytes[..bytes.len() - 1 - remark]);
    Ok(content.len() < bytes.len() && stamped(path, content.to_vec(), model_name) == bytes)
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

/// The chunk of a comment in a PNG: its length, its type and text, and their checksum.
fn png_comment(text: &str) -> Vec<u8> {
    let chunk = [b"tEXtComment\0", text.as_bytes()].concat();
    // Texts are short, and the four letters of the type do not count.
    let length = u32::try_from(chunk.len() - 4).unwrap_or_default();
    [&length.to_be_bytes()[..], &chunk, &crc32fast::hash(&chunk).to_be_bytes()].concat()
}

/// A mark that ends no remark of any format, whatever the model is called.
fn mark(model_name: &str, content: &[u8]) -> String {
    let letter = |byte: u8| match byte {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'_' | b'.' => char::from(byte).to_string(),
        byte => format!("%{byte:02x}"),
    };
    let name: String = model_name.bytes().map(letter).collect();
    let hex = |sum: String, byte: &u8| sum + &format!("{byte:02x}");
    let sum = Sha256::digest(content).iter().fold(String::new(), hex);
    format!("made by bksim from the model {name}, sha256 {sum}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_mark_names_one_model_in_every_format_of_remarks() {
        let folder = tempfile::tempdir().expect("a folder");
        let names = ["four-bar", "four-bar-2", "bar", "-->", "a\nb", "Kurbel ä"];
        for file in ["a.svg", "a.html", "a.pdf", "a.py", "a.h", "a.rs"] {
            let path = folder.path().join(file);
            for name in names {
                fs::write(&path, stamped(&path, b"some content".to_vec(), name)).expect("written");
                let known: Vec<&str> =
                    names.into_iter().filter(|name| is_of_model(&path, name)).collect();
                assert_eq!(known, [name], "{file}");
            }
            let edited = fs::read_to_string(&path).expect("text").replace("some", "Some");
            for content in [edited.as_str(), "x", "strange content", "\n\n\n\n\n\n\n\n\n\n"] {
                fs::write(&path, content).expect("written");
                assert!(!names.iter().any(|name| is_of_model(&path, name)), "{file}: {content}");
            }
        }
        // A PNG, of no picture here.
        let path = folder.path().join("a.png");
        let picture = [&PNG[..], b"some chunks", &PNG_END].concat();
        let marked = stamped(&path, picture, "bar");
        assert!(marked.ends_with(&PNG_END) && marked.windows(4).any(|part| part == b"tEXt"));
        fs::write(&path, &marked).expect("written");
        assert!(is_of_model(&path, "bar") && !is_of_model(&path, "four-bar"));
        fs::write(&path, [&marked[..9], b"S", &marked[10..]].concat()).expect("written");
        assert!(!is_of_model(&path, "bar"), "it was edited");

        let json = folder.path().join("a.json");
        fs::write(&json, stamped(&json, b"{\n\n\n\n\n\n\n}".to_vec(), "bar")).expect("written");
        assert!(!is_of_model(&json, "bar"), "it has no mark");
    }

    #[test]
    fn a_table_is_known_by_its_columns_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.csv");
        for (content, is_own) in [
            ("t,state.x\n0,1\n", true),
            ("t\n", true),
            ("t,state.y\n0,1\n", false),
            ("state.x,t\n0,1\n", false),
            ("t,state.x", false),
            ("", false),
        ] {
            fs::write(&path, content).expect("written");
            let known = ["state.x", "state.v"].into_iter();
            assert_eq!(has_columns(&path, "t", &known), is_own, "{content:?}");
        }
    }
}
