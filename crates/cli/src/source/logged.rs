//! Logs: told from models, and opened to be played.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use bksim::Mechanism;
use bksim::log::{Header, LogReader, Selection, glob};
use bksim::measured::Measured;
use bksim::model::Measure;
use bksim::model::file::did_you_mean;
use bksim::playback::{Playback, PlaybackError, RunLog};
use bksim::record::INPUTS;
use bksim::sim::observable::Observables;
pub use bksim_load::is_log;

use crate::exit::Failure;

/// The mechanism of a log, for what its samples do not say.
///
/// # Errors
/// A log that cannot be read, or whose model this version refuses.
pub fn mechanism(path: &Path, cannot: &str) -> Result<Mechanism, Failure> {
    let bad = |error: &dyn std::fmt::Display| unplayable(path, cannot, error);
    let file = File::open(path).map_err(|e| Failure::reading(path, &e))?;
    let log = LogReader::open(BufReader::new(file)).map_err(|e| bad(&e))?;
    let has_inputs = log.header().topics.iter().any(|topic| topic.name == INPUTS);
    let log = if has_inputs {
        RunLog::read(log).map_err(|e| bad(&e))?
    } else {
        RunLog::unlogged(log.header().clone(), Vec::new())
    };
    log.mechanism().map_err(|e| bad(&e))
}

/// The quantities among `channels` that a log does not have as channels, to be computed from it; `None` where it has
/// all of them, or where the model has nothing of these names either.
///
/// # Errors
/// As [`mechanism`], and a log without the samples that they are computed from.
pub fn measured(
    path: &Path,
    header: &Header,
    channels: &[String],
    cannot: &str,
) -> Result<Option<Measured>, Failure> {
    let is_missing = |name: &&String| Selection::new(header, [name]).is_err();
    let mut missing: Vec<String> = channels.iter().filter(is_missing).cloned().collect();
    if missing.is_empty() {
        return Ok(None);
    }
    let mechanism = mechanism(path, cannot)?;
    let model = &mechanism.model;
    let is_known = |name: &String| Observables::named(model, name).is_some();
    let mut known = Measure::names(model);
    known.retain(is_known);
    // A pattern is replaced by all names of the model that it matches.
    let of_pattern = |pattern: String| -> Vec<String> {
        let all = known.iter().filter(|name| glob(&pattern, name)).cloned();
        if pattern.contains(['*', '?']) { all.collect() } else { vec![pattern] }
    };
    missing = missing.into_iter().flat_map(of_pattern).collect();
    if let Some(unknown) = missing.iter().find(|name| !is_known(name)) {
        let of_log = Selection::all(header);
        let of_log = of_log.columns().iter().map(|column| column.name.as_str());
        let known: Vec<&str> = of_log.chain(known.iter().map(String::as_str)).collect();
        if let Some(help) = did_you_mean(unknown, &known) {
            let message =
                format!("`{}` cannot be {cannot}: no channel matches `{unknown}`", path.display());
            return Err(Failure::usage(message, &help));
        }
        missing.retain(is_known);
    }
    missing.dedup();
    let measured = || Measured::new(&mechanism, header, &missing);
    let measured = (!missing.is_empty()).then(measured).transpose();
    measured.map_err(|error| unplayable(path, cannot, &error))
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
