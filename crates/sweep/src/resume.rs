//! A sweep on its way to one table: finished parts on disk, joined at the end.
//!
//! A table of Parquet ends with its index: cut short, it cannot be read. So the cases are done in
//! parts, each a small table of its own in `sweep.parquet.parts/`, and joined without decoding when
//! all are there. A part has its name only once it is whole, and a checksum next to it: so an interrupted
//! sweep, however it ended, goes on with the parts that are missing or damaged.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use ::parquet::file::metadata::KeyValue;
use bksim::model::diagnostic::Diagnostic;

use crate::codes;
use crate::csv::to_csv;
use crate::error::SweepError;
use crate::parquet::{entry, survey};
use crate::row::Row;
use crate::run::Monitor;
use crate::study::Study;
use crate::table::is_csv;

/// A policy for parts of a sweep that are there already.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Existing {
    /// Refuse to go on.
    Refuse,
    /// Go on with what is missing; refuse when they are of another sweep.
    Resume,
    /// Begin again.
    Replace,
}

/// How a sweep ended.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Report {
    /// Cases of the plan.
    pub n_cases: u64,
    /// Cases whose run reached its end.
    pub n_done: u64,
    /// Cases that failed.
    pub n_failed: u64,
    /// Cases that were there before.
    pub n_resumed: u64,
    /// True if it was stopped: the table is not written yet, parts are.
    pub is_stopped: bool,
    /// Failed cases by their code.
    pub faults: BTreeMap<String, FaultCount>,
}

/// Cases that failed for one reason.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct FaultCount {
    /// How many.
    pub n: u64,
    /// The first of them.
    pub first_case: u64,
    /// Fault in words.
    pub reason: String,
}

/// Where the parts of a table lie until it is whole.
pub fn parts_of(table: &Path) -> PathBuf {
    let mut name = table.as_os_str().to_owned();
    name.push(".parts");
    name.into()
}

/// Does the cases of `study` that are missing and writes the table. `n_jobs` threads, or one per
/// core for 0; neither they nor interruptions change a byte of it.
///
/// # Errors
/// [`SweepError`]; [`codes::OTHER_SWEEP`] when parts of another sweep lie where these belong, or
/// `existing` refuses any. The table itself is replaced.
pub fn write(
    study: &Study,
    table: &Path,
    existing: Existing,
    n_jobs: usize,
    monitor: &Monitor<'_>,
) -> Result<Report, SweepError> {
    let parts = Parts::open(study, table, existing)?;
    let mut report = Report { n_cases: study.n_cases(), ..Report::default() };
    let mut missing = Vec::new();
    for part in 0..study.n_parts() {
        match parts.known(part) {
            Some(tally) => tally.add_to(&mut report),
            None => missing.push(part),
        }
    }
    report.n_resumed = report.n_done + report.n_failed;

    let progress = |n_ended| (monitor.progress)(report.n_resumed + n_ended);
    let monitor = Monitor { progress: &progress, ..*monitor };
    let done = study.parts(&missing, n_jobs, &monitor, |part, rows| {
        parts.put(part, &study.table_of(&rows)?)?;
        Ok::<Tally, SweepError>(Tally::of(&rows))
    })?;
    for tally in done {
        match tally.transpose()? {
            Some(tally) => tally.add_to(&mut report),
            None => report.is_stopped = true,
        }
    }
    if !report.is_stopped {
        parts.join()?;
    }
    Ok(report)
}

/// True if a file is the whole table of this very sweep.
pub fn is_whole(study: &Study, table: &Path) -> bool {
    let found = File::open(table).ok().and_then(|file| survey(&file).ok());
    found.is_some_and(|(n_rows, about)| {
        let is_own = |entry: &KeyValue| {
            entry.key == "bksim.fingerprint" && entry.value.as_ref() == Some(&study.fingerprint())
        };
        n_rows == study.n_cases() && about.iter().any(is_own)
    })
}

impl Study {
    /// A part as a table of its own; `rows` are all of its.
    ///
    /// # Errors
    /// [`SweepError::Table`].
    pub fn table_of(&self, rows: &[Row]) -> Result<Vec<u8>, SweepError> {
        let mut bytes = Vec::new();
        let layout = self.layout();
        let written =
            layout.and_then(|layout| layout.write(rows, Tally::of(rows).metadata(), &mut bytes));
        written.map_err(SweepError::table(Path::new("a part")))?;
        Ok(bytes)
    }
}

/// Finished parts of a sweep on disk, done here or elsewhere.
pub struct Parts<'a> {
    study: &'a Study,
    table: PathBuf,
    directory: PathBuf,
}

/// Holds the fingerprint of the sweep that the parts are of.
const FINGERPRINT: &str = "fingerprint";

impl<'a> Parts<'a> {
    /// Makes the directory next to `table`, or finds that of this sweep.
    ///
    /// # Errors
    /// As for [`write()`].
    pub fn open(study: &'a Study, table: &Path, existing: Existing) -> Result<Self, SweepError> {
        let parts = Self { study, table: table.to_owned(), directory: parts_of(table) };
        parts.claim(existing)?;
        Ok(parts)
    }

    /// The parts that are still to be done.
    pub fn missing(&self) -> Vec<u64> {
        (0..self.study.n_parts()).filter(|&part| self.known(part).is_none()).collect()
    }

    fn claim(&self, existing: Existing) -> Result<(), SweepError> {
        let path = self.directory.join(FINGERPRINT);
        let shown = self.directory.display();
        let own = self.study.fingerprint();
        if self.directory.exists() {
            let known = fs::read_to_string(&path).unwrap_or_default();
            // Killed before anything was there.
            let is_empty = known.is_empty() && self.is_empty();
            match existing {
                Existing::Replace => self.remove()?,
                _ if is_empty => (),
                Existing::Resume if known.trim() == own => return Ok(()),
                Existing::Resume => {
                    let message = format!("`{shown}` holds parts of another sweep");
                    let fault = Diagnostic::error(codes::OTHER_SWEEP, message)
                        .note("model, values, outputs, settings and version must be the same")
                        .help("ask for the same, add --force to begin anew, or name another table");
                    return Err(fault.into());
                }
                Existing::Refuse => {
                    let message = format!("`{shown}` holds parts of a sweep that was interrupted");
                    let help = "add --resume to go on with it, or --force to begin anew";
                    return Err(Diagnostic::error(codes::OTHER_SWEEP, message).help(help).into());
                }
            }
        }
        fs::create_dir_all(&self.directory).map_err(SweepError::file(&self.directory))?;
        let written = self.directory.join("fingerprint.new");
        fs::write(&written, own).map_err(SweepError::file(&written))?;
        fs::rename(&written, &path).map_err(SweepError::file(&path))
    }

    fn is_empty(&self) -> bool {
        let entries = fs::read_dir(&self.directory).into_iter().flatten().flatten();
        !entries.map(|entry| entry.file_name()).any(|name| is_part(Path::new(&name)))
    }

    /// Removes what a sweep has written, and the directory if nothing else is in it.
    fn remove(&self) -> Result<(), SweepError> {
        let failed = SweepError::file(&self.directory);
        for entry in fs::read_dir(&self.directory).map_err(&failed)? {
            let path = entry.map_err(&failed)?.path();
            let name = path.file_name().map(Path::new);
            if name.is_some_and(|name| is_part(name) || name.starts_with(FINGERPRINT)) {
                fs::remove_file(&path).map_err(SweepError::file(&path))?;
            }
        }
        // Something of another kind may stay.
        let _ = fs::remove_dir(&self.directory);
        Ok(())
    }

    fn path(&self, part: u64) -> PathBuf {
        self.directory.join(format!("{part:06}.parquet"))
    }

    /// The checksum of a part, CRC-32 in hexadecimal.
    fn checksum_path(&self, part: u64) -> PathBuf {
        self.path(part).with_extension(CHECKSUM)
    }

    /// True for a part that has the bytes it was written with.
    fn is_sound(&self, part: u64) -> bool {
        let stored = fs::read_to_string(self.checksum_path(part));
        let found = fs::read(self.path(part)).map(|bytes| checksum(&bytes));
        stored.is_ok_and(|stored| found.is_ok_and(|found| stored == found))
    }

    /// The tally of a part that is there, whole and sound.
    fn known(&self, part: u64) -> Option<Tally> {
        if !self.is_sound(part) {
            return None;
        }
        let cases = self.study.cases_of(part);
        let (n_rows, about) = survey(&File::open(self.path(part)).ok()?).ok()?;
        let tally = Tally::from_metadata(&about)?;
        (n_rows == cases.end - cases.start).then_some(tally)
    }

    /// Keeps a part, as [`Study::table_of`] has made it here or elsewhere.
    ///
    /// # Errors
    /// [`SweepError::File`].
    pub fn put(&self, part: u64, table: &[u8]) -> Result<(), SweepError> {
        let path = self.path(part);
        // The checksum comes first: a part without its own would be done again.
        let own = self.checksum_path(part);
        fs::write(&own, checksum(table)).map_err(SweepError::file(&own))?;
        let written = path.with_extension("parquet.new");
        fs::write(&written, table).map_err(SweepError::file(&written))?;
        fs::rename(&written, &path).map_err(SweepError::file(&path))
    }

    /// Makes one table of all parts, and removes them.
    ///
    /// # Errors
    /// [`SweepError`], also when a part is missing.
    pub fn join(&self) -> Result<(), SweepError> {
        let written = self.directory.join("table.parquet.new");
        let failed = SweepError::file(&written);
        let bad = SweepError::table(&written);
        let mut out = BufWriter::new(File::create(&written).map_err(&failed)?);
        let layout = self.study.layout().map_err(&bad)?;
        let mut joined = layout.joined(&mut out).map_err(&bad)?;
        for part in 0..self.study.n_parts() {
            let path = self.path(part);
            if !self.is_sound(part) {
                let damaged = "it is damaged: the same command with --resume does its cases again";
                return Err(SweepError::file(&path)(io::Error::other(damaged)));
            }
            let file = File::open(&path).map_err(SweepError::file(&path))?;
            joined.append(&file).map_err(SweepError::table(&path))?;
        }
        joined.finish().map_err(&bad)?;
        let joined = out.into_inner().map_err(|e| failed(e.into_error()))?;
        joined.sync_all().map_err(&failed)?;
        if is_csv(&self.table) {
            let table = File::open(&written).map_err(&failed)?;
            let text = self.directory.join("table.csv.parquet.new");
            let mut out = BufWriter::new(File::create(&text).map_err(SweepError::file(&text))?);
            to_csv(&table, &mut out).map_err(SweepError::table(&text))?;
            let out = out.into_inner().map_err(|e| failed(e.into_error()))?;
            out.sync_all().map_err(&failed)?;
            fs::rename(&text, &self.table).map_err(SweepError::file(&self.table))?;
            return self.remove();
        }
        fs::rename(&written, &self.table).map_err(SweepError::file(&self.table))?;
        self.remove()
    }
}

/// True if a file is one that parts are written to.
fn is_part(name: &Path) -> bool {
    let name = name.to_string_lossy();
    [".parquet", ".parquet.new", ".crc32"].iter().any(|ending| name.ends_with(ending))
}

/// Ending of the checksum of a part.
const CHECKSUM: &str = "crc32";

/// CRC-32 (ISO 3309) of a part, as its file has it.
fn checksum(bytes: &[u8]) -> String {
    format!("{:08x}\n", crc32fast::hash(bytes))
}

/// How the cases of a part ended.
struct Tally {
    n_done: u64,
    faults: BTreeMap<String, FaultCount>,
}

/// Key of a tally in the metadata of a part, and of each fault in it.
const N_DONE: &str = "bksim.part.done";
const FAULT: &str = "bksim.part.fault.";

impl Tally {
    fn of(rows: &[Row]) -> Self {
        let mut tally = Self { n_done: 0, faults: BTreeMap::new() };
        for row in rows {
            let Some(fault) = row.ending.fault() else {
                tally.n_done += 1;
                continue;
            };
            let first = || FaultCount { n: 0, first_case: row.case, reason: fault.reason.clone() };
            tally.faults.entry(fault.code.to_owned()).or_insert_with(first).n += 1;
        }
        tally
    }

    fn metadata(&self) -> Vec<KeyValue> {
        let faults = self.faults.iter().map(|(code, FaultCount { n, first_case, reason })| {
            entry(&format!("{FAULT}{code}"), &format!("{n} {first_case} {reason}"))
        });
        std::iter::once(entry(N_DONE, &self.n_done.to_string())).chain(faults).collect()
    }

    fn from_metadata(about: &[KeyValue]) -> Option<Self> {
        let of = |key: &str| about.iter().find(|entry| entry.key == key)?.value.as_deref();
        let mut tally = Self { n_done: of(N_DONE)?.parse().ok()?, faults: BTreeMap::new() };
        for KeyValue { key, value } in about {
            let Some(code) = key.strip_prefix(FAULT) else { continue };
            let mut words = value.as_deref()?.splitn(3, ' ');
            let n = words.next()?.parse().ok()?;
            let first_case = words.next()?.parse().ok()?;
            let reason = words.next()?.to_owned();
            tally.faults.insert(code.to_owned(), FaultCount { n, first_case, reason });
        }
        Some(tally)
    }

    fn add_to(&self, report: &mut Report) {
        report.n_done += self.n_done;
        for (code, more) in &self.faults {
            report.n_failed += more.n;
            let known =
                report.faults.entry(code.clone()).or_insert(FaultCount { n: 0, ..more.clone() });
            known.n += more.n;
            if more.first_case < known.first_case {
                (known.first_case, known.reason) = (more.first_case, more.reason.clone());
            }
        }
    }
}
