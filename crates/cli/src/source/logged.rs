//! Logs: told from models, and opened to be played.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use bksim::log::LogReader;
use bksim::playback::{Playback, PlaybackError};

use crate::exit::Failure;

/// The first bytes of every MCAP file.
const MCAP: [u8; 8] = *b"\x89MCAP0\r\n";

/// Whether a file is a log: by how it begins, or, where it begins otherwise, by its name.
pub fn is_log(path: &Path) -> bool {
    let mut first = [0; MCAP.len()];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut first));
    let is_named = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"));
    is_named || read.is_ok() && first == MCAP
}

/// Opens a log; `cannot` says in a word what comes to nothing when it has no motion.
///
/// # Errors
/// A file that cannot be read, that is no log, or that has no motion.
pub fn playback(path: &Path, cannot: &str) -> Result<Playback, Failure> {
    let file = File::open(path).map_err(|e| Failure::reading(path, &e))?;
    let bad = |error: &PlaybackError| unplayable(path, cannot, error);
    let log = LogReader::open(BufReader::new(file)).map_err(|e| bad(&e.into()))?;
    Playback::open(log).map_err(|e| bad(&e))
}

/// A log that cannot be `drawn`, `shown`.
pub fn unplayable(path: &Path, cannot: &str, error: &dyn std::fmt::Display) -> Failure {
    let what = format!("cannot be {cannot}: {error}");
    Failure::Input { path: path.to_owned(), what, help: None }
}
