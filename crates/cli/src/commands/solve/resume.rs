//! `bksim solve --resume`: the model, its options and the checkpoint out of the log of a stopped run.

use std::fs::File;
use std::io::{BufReader, Write};
use std::path::{Path, PathBuf};

use bksim::VERSION;
use bksim::log::{Header, LogError, LogReader, Outcome};
use bksim::model::{Model, Outputs, SolveOptions};
use bksim::options::{FORMULATIONS, METHODS, choice};
use bksim::record::{Recorder, compliances, overrides};
use bksim::sim::run::{RunCheckpoint, Unfit};

use crate::args::{Channels, Solve};
use crate::exit::Failure;
use crate::origin::file_of;
use crate::source::{Loaded, Text, parse};

/// The first part of a run.
pub(super) struct FirstPart {
    pub(super) path: PathBuf,
    /// Parameters given on the command line.
    pub(super) set: Vec<(String, String)>,
    /// The file of its model, as logs name it.
    pub(super) file: String,
    /// Joints that yield.
    pub(super) compliance: Vec<(String, String)>,
    /// Which channels the log has.
    pub(super) channels: Channels,
    pub(super) checkpoint: RunCheckpoint,
}

/// Reads what a log says of its run.
pub(super) fn open(path: &Path, nesting: usize) -> Result<(Loaded, FirstPart), Failure> {
    let bad = |error: &LogError| refused(path, &error.to_string(), None);
    let mut log = reader(path)?;
    while log.next_record().map_err(|e| bad(&e))?.is_some() {}
    let header = log.header();
    let checkpoint = match (log.checkpoint(), log.end()) {
        (Some(bytes), _) => RunCheckpoint::from_bytes(bytes).map_err(|e| unfit(path, &e))?,
        (None, end) => {
            let (what, help) = match end {
                Some(end) if end.outcome == Outcome::ReachedEnd => (
                    format!("its run has reached its end, t = {} s", end.t_end),
                    "nothing is left to do",
                ),
                Some(end) => (
                    format!("its run was not stopped from outside: {}", end.reason),
                    "mend the model and solve it again",
                ),
                None => (
                    "it was cut off before its run ended and says nothing to go on from".to_owned(),
                    "solve the model again",
                ),
            };
            return Err(refused(path, &what, Some(help)));
        }
    };
    if header.version != VERSION {
        let what = format!("bksim {} has written it, this is {VERSION}", header.version);
        return Err(refused(path, &what, Some("numbers would differ: solve the model again")));
    }
    let set = overrides(&header.options);
    let source = Text::new(path.to_owned(), header.model_text.clone());
    let mut loaded = parse(source, &header.model_name, &set, nesting)?;
    apply(&mut loaded.model, header)
        .ok_or_else(|| refused(path, "its options cannot be read", None))?;
    let [key, own] = super::OWN_CHANNELS;
    let is_own = header.options.get(key).is_some_and(|channels| channels == own);
    let channels = if is_own { Channels::Own } else { Channels::All };
    let compliance = compliances(&header.options);
    let (path, file) = (path.to_owned(), file_of(header));
    Ok((loaded, FirstPart { path, set, file, compliance, channels, checkpoint }))
}

/// Puts the options of the log in place of the model's; `None` when one has no meaning.
fn apply(model: &mut Model, header: &Header) -> Option<()> {
    let text = |key: &str| header.options.get(key).map(String::as_str);
    let number = |key: &str| text(key)?.parse::<f64>().ok();
    let unless = |key: &str, word: &str| match text(key)? {
        stated if stated == word => Some(None),
        _ => number(key).map(Some),
    };
    let times = || -> Option<Vec<f64>> {
        text("times")?.split_whitespace().map(|time| time.parse().ok()).collect()
    };
    let (every, outputs) = match (text("every")?, text("times")) {
        (_, Some(_)) => (None, Outputs::Times(times()?)),
        ("step", _) => (None, Outputs::Steps),
        _ => (unless("every", "default")?, Outputs::Even),
    };
    let solve = &mut model.solve;
    *solve = SolveOptions {
        t_start: number("t_start")?,
        t_end: number("t_end")?,
        every,
        outputs,
        rtol: number("rtol")?,
        atol: number("atol")?,
        step: unless("step", "adaptive")?,
        method: choice(&METHODS, text("method")?)?,
        formulation: choice(&FORMULATIONS, text("formulation")?)?,
        ..solve.clone()
    };
    Some(())
}

/// The log to write: `run.mcap` is continued in `run-resumed.mcap` unless a name is given.
pub(super) fn output_path(args: &Solve) -> PathBuf {
    let log = &args.model.model;
    args.output.clone().unwrap_or_else(|| {
        let stem = log.file_stem().unwrap_or_default().to_string_lossy();
        log.with_file_name(format!("{stem}-resumed.mcap"))
    })
}

impl FirstPart {
    /// Copies its samples and warnings.
    pub(super) fn copy_into<W: Write>(
        &self,
        log: &mut Recorder<W>,
        path: &Path,
    ) -> Result<(), Failure> {
        let mut first = reader(&self.path)?;
        match log.copy(&mut first, &self.checkpoint) {
            Ok(true) => Ok(()),
            Ok(false) => Err(refused(&self.path, "its channels are not those of its model", None)),
            Err(error) => Err(Failure::writing(path, &error)),
        }
    }
}

/// A checkpoint that cannot be used.
pub(super) fn unfit(path: &Path, unfit: &Unfit) -> Failure {
    refused(path, &unfit.to_string(), Some("solve the model again"))
}

fn reader(path: &Path) -> Result<LogReader<BufReader<File>>, Failure> {
    let file = File::open(path).map_err(|e| Failure::reading(path, &e))?;
    LogReader::open(BufReader::new(file)).map_err(|e| match e {
        LogError::NotMcap | LogError::NotARun { .. } => refused(
            path,
            &e.to_string(),
            Some("name the log of a run, as `bksim solve` has written it"),
        ),
        _ => refused(path, &e.to_string(), None),
    })
}

fn refused(path: &Path, what: &str, help: Option<&str>) -> Failure {
    let (path, what) = (path.to_owned(), format!("cannot be resumed: {what}"));
    Failure::Input { path, what, help: help.map(str::to_owned) }
}
