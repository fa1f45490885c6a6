//! The file of a log: its name, and what can be read from one that was not finished.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use bksim::log::{LogReader, Record};
use bksim_load::name_of;

/// A file in the working directory that is called after the file of a model: two models have two, whatever they are
/// called inside.
pub fn named_after(model: &Path, ending: &str) -> PathBuf {
    let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    PathBuf::from(format!("{}.{ending}", name_of(model).chars().map(plain).collect::<String>()))
}

/// A sentence on what a log that was not finished holds.
pub(super) fn kept(path: &Path) -> String {
    let named = path.display();
    match last_sample(path) {
        Some(t) => format!("`{named}` can be read: it holds the samples up to t = {t} s"),
        None => format!("nothing of the run can be read from `{named}`"),
    }
}

/// Time of the last sample that can be read, s.
fn last_sample(path: &Path) -> Option<f64> {
    let mut log = LogReader::open(BufReader::new(File::open(path).ok()?)).ok()?;
    let mut last = None;
    while let Ok(Some(record)) = log.next_record() {
        if let Record::Sample { t, .. } = record {
            last = Some(t);
        }
    }
    last
}
