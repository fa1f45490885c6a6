//! A sweep on its way to one table: finished parts on disk, joined at the end.
//!
//! A table of Parquet ends with its index: cut short, it cannot be read. So the cases are done in
//! parts, each a small table of its own in `sweep.parquet.parts/`, and joined without decoding when
//! all are there. A part has its name only once it is whole, so an interrupted sweep, however it
//! ended, goes on with the parts that are missing.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

use ::parquet::file::metadata::KeyValue;
use bksim::mbs::diagnostic::Diagnostic;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use crate::case::Row;
use crate::codes;
use crate::error::SweepError;
use crate::parquet::{Layout, entry, survey};
use crate::run::{Counter, Monitor, threads};
use crate::study::Study;

/// What to do about parts of a sweep that are there already.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Existing {
    /// Refuse to go on.
    Refuse,
    /// Go on with what is missing; refuse when they are of another sweep.
    Resume,
    /// Begin anew.
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
    /// Whether it was stopped: the table is not written yet, parts are.
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
    /// What was wrong with it.
    pub reason: String,
}

/// Where the parts of a table lie until it is whole.
pub fn parts_of(table: &Path) -> PathBuf {
    let mut name = table.as_os_str().to_owned();
    name.push(".parts");
    name.into()
}

/// Cases of a part, so that there are some 256 of them: few enough for the table's index, many
/// enough that little is lost, whatever the number of threads.
fn part_size(n_cases: u64) -> u64 {
    n_cases.div_ceil(256).next_power_of_two().clamp(16, 8192)
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
    let parts = Parts { study, layout: layout(study, table)?, directory: parts_of(table) };
    parts.open(existing)?;
    let size = part_size(study.n_cases());
    let n_parts = study.n_cases().div_ceil(size);
    let cases = |part: u64| part * size..((part + 1) * size).min(study.n_cases());

    let mut report = Report { n_cases: study.n_cases(), ..Report::default() };
    let mut missing = Vec::new();
    for part in 0..n_parts {
        match parts.known(part, cases(part)) {
            Some(tally) => tally.add_to(&mut report),
            None => missing.push(part),
        }
    }
    report.n_resumed = report.n_done + report.n_failed;

    let counter = Counter::new(*monitor, report.n_resumed);
    let done = threads(n_jobs)?.install(|| {
        let part = |part: u64| parts.write(part, cases(part), &counter);
        missing.into_par_iter().map(part).collect::<Result<Vec<_>, SweepError>>()
    })?;
    for tally in &done {
        match tally {
            Some(tally) => tally.add_to(&mut report),
            None => report.is_stopped = true,
        }
    }
    if !report.is_stopped {
        parts.join(n_parts, table)?;
    }
    Ok(report)
}

fn layout(study: &Study, table: &Path) -> Result<Layout, SweepError> {
    Layout::new(study).map_err(SweepError::table(table))
}

/// The finished parts of a sweep.
struct Parts<'a> {
    study: &'a Study,
    layout: Layout,
    directory: PathBuf,
}

/// Holds the fingerprint of the sweep that the parts are of.
const FINGERPRINT: &str = "fingerprint";

impl Parts<'_> {
    /// Makes the directory, or finds that of this sweep.
    fn open(&self, existing: Existing) -> Result<(), SweepError> {
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

    /// What came of a part that is there and whole.
    fn known(&self, part: u64, cases: Range<u64>) -> Option<Tally> {
        let (n_rows, about) = survey(&File::open(self.path(part)).ok()?).ok()?;
        let tally = Tally::from_metadata(&about)?;
        (n_rows == cases.end - cases.start).then_some(tally)
    }

    /// Does the cases of a part and writes them; `None` when that was stopped.
    fn write(
        &self,
        part: u64,
        cases: Range<u64>,
        counter: &Counter<'_>,
    ) -> Result<Option<Tally>, SweepError> {
        let Some(rows) = self.study.rows_counted(cases, counter) else { return Ok(None) };
        let tally = Tally::of(&rows);
        let path = self.path(part);
        let written = path.with_extension("parquet.new");
        let failed = SweepError::file(&written);
        let mut out = BufWriter::new(File::create(&written).map_err(&failed)?);
        let layout = &self.layout;
        layout.write(&rows, tally.metadata(), &mut out).map_err(SweepError::table(&written))?;
        out.flush().map_err(&failed)?;
        fs::rename(&written, &path).map_err(SweepError::file(&path))?;
        Ok(Some(tally))
    }

    /// Makes one table of all parts, and removes them.
    fn join(&self, n_parts: u64, table: &Path) -> Result<(), SweepError> {
        let written = self.directory.join("table.parquet.new");
        let failed = SweepError::file(&written);
        let bad = SweepError::table(&written);
        let mut out = BufWriter::new(File::create(&written).map_err(&failed)?);
        let mut joined = self.layout.joined(&mut out).map_err(&bad)?;
        for part in 0..n_parts {
            let path = self.path(part);
            let file = File::open(&path).map_err(SweepError::file(&path))?;
            joined.append(&file).map_err(SweepError::table(&path))?;
        }
        joined.finish().map_err(&bad)?;
        out.into_inner().map_err(|e| failed(e.into_error()))?.sync_all().map_err(&failed)?;
        fs::rename(&written, table).map_err(SweepError::file(table))?;
        self.remove()
    }
}

/// Whether a file is one that parts are written to.
fn is_part(name: &Path) -> bool {
    let name = name.to_string_lossy();
    name.ends_with(".parquet") || name.ends_with(".parquet.new")
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
