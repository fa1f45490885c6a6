//! `bksim solve`: from the model file to the log.

mod cut;
mod events;
mod files;
mod logging;
mod recorded;
mod report;
mod resume;

use std::fs;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::time::{Duration, Instant};

use bksim::analysis::{compliances, diagnose_singular_start};
use bksim::log::{self, Level, LogError};
use bksim::model::diagnostic::Diagnostic;
use bksim::options::{BadOption, SolveChanges, described, in_words};
use bksim::record::{Contents, Recorder, compliance_options, set_option};
use bksim::sim::mobility::{Mobility, mobility};
use bksim::sim::run::{self, Summary, Unresumed};
use bksim::sim::sensitivity::Sensitive;
use bksim::sim::start::Start;
use bksim::{Mechanism, Rejected, SensitivityPlan, Simulation};

use self::cut::Cut;
pub use self::files::named_after;
use self::logging::{Logging, Size};
pub use self::recorded::RunFile;
pub(super) use self::report::not_unique;
use self::report::{Report, Times};
use self::resume::FirstPart;
use crate::args::analysis::ComplianceArgs;
use crate::args::{self, ModelArgs, Solve, Tuning};
use crate::each_case::of_case;
use crate::exit::{Failure, Status, without_number};
use crate::origin::{MODEL_FILE, is_of_model, is_of_text, label_of};
use crate::output;
use crate::output_file::{OutputFile, Written, check_ending, is_same_file};
use crate::progress::{Progress, StopWish};
use crate::render;
use crate::source::{Text, derive, load};
use crate::waiting::waiting;

/// The option of a log without the channels of other programs.
const OWN_CHANNELS: [&str; 2] = ["channels", "own"];

/// A run that is ready: the mechanism, its start, and where the log goes.
struct Prepared {
    source: Text,
    mechanism: Mechanism,
    simulation: Simulation,
    start: Start,
    /// Freedoms of the start, and conditions that repeat others.
    found: Mobility,
    /// Quantities that the motion is differentiated by, with the plan for it.
    sensitive: Vec<Sensitive>,
    plan: Option<SensitivityPlan>,
    warnings: Vec<Diagnostic>,
    /// The run that is continued, if one is.
    first: Option<FirstPart>,
    /// The file that the model is in, as logs name it.
    label: String,
    /// The log to be.
    output: OutputFile,
}

/// The file of a log that is being written.
struct LogFile {
    /// Where it is now.
    path: PathBuf,
    /// Bytes that have been written.
    n_bytes: Arc<AtomicU64>,
}

/// A run that has come to its end or was stopped.
struct Integrated {
    log: Log,
    outcome: Outcome,
    /// Time that writing the log has taken.
    taken: Duration,
    /// Why the log has stopped it, if it has.
    cut: Option<Cut>,
}

/// The end of a run, in the log and in the exit status.
struct Conclusion {
    summary: Summary,
    status: Status,
    reason: String,
}

pub(crate) fn run(args: &Solve, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let mut times = Times::default();
    let (prepared, summary, status) = solved(args, nesting, as_json, &mut times)?;
    let Prepared { source, mechanism, found, sensitive, warnings, output, .. } = &prepared;
    let (path, summary, times) = (output.path(), &summary, &times);
    let report = Report { source, path, summary, times, status, mechanism, found, sensitive };
    if as_json {
        let mut body = report.describe();
        body["diagnostics"] = render::json_all(source, warnings);
        output::json("solve", body)?;
    } else {
        output::report(&report.text())?;
    }
    Ok(status)
}

/// Solves a model into a log as `bksim solve` does, and prints nothing: what is said of the run stands in the log.
///
/// # Errors
/// Those of the model and the file; a run that stops early leaves its log, and says so in the status.
pub fn solve_into_log(
    model: ModelArgs,
    (output, force): (&Path, bool),
    compliance: &ComplianceArgs,
    tuning: &Tuning,
    nesting: usize,
) -> Result<Status, Failure> {
    let args = Solve {
        model,
        output: Some(output.to_owned()),
        force,
        resume: false,
        compliance: compliance.clone(),
        tuning: tuning.clone(),
        sensitivity: Vec::new(),
        channels: args::Channels::All,
        log_limit: args::LOG_LIMIT,
    };
    solved(&args, nesting, true, &mut Times::default()).map(|(.., status)| status)
}

/// Solves a model into its log; warnings and faults are printed, unless they go into JSON.
fn solved(
    args: &Solve,
    nesting: usize,
    as_json: bool,
    times: &mut Times,
) -> Result<(Prepared, Summary, Status), Failure> {
    let mut prepared = prepare(args, nesting, times)?;
    if !as_json {
        render::print_all(&prepared.source, &prepared.warnings);
    }

    // The log is opened only now: a rejected model touches no file.
    let mut clock = Clock::begin();
    let (log, written) = open_log(&prepared, args)?;
    let stop = StopWish::watch().map_err(|e| {
        Failure::file(&written.path, format!("is empty: signals cannot be handled: {e}"), None)
    })?;
    times.log = clock.lap();
    let Integrated { mut log, outcome, taken, cut } =
        integrate(&prepared, (log, &written), (&stop, args.log_limit), as_json)?;
    times.integrate = clock.lap().saturating_sub(taken);
    times.log += taken;

    let Conclusion { summary, status, reason } =
        conclude(&mut prepared, (outcome, cut), &stop, as_json);
    judge(&mut prepared, &mut log, (&summary, status), as_json)?;
    close_log(&prepared, log, &summary, status, &reason)?;
    times.log += clock.lap();
    Ok((prepared, summary, status))
}

/// Reads the model, derives its equations and finds the start.
fn prepare(args: &Solve, nesting: usize, times: &mut Times) -> Result<Prepared, Failure> {
    let mut clock = Clock::begin();

    // Read, and refuse an output that cannot be written before any work is done.
    let (mut loaded, first) = if args.resume {
        let (loaded, first) = resume::open(&args.model.model, nesting)?;
        (loaded, Some(first))
    } else {
        (load(&args.model, nesting)?, None)
    };
    let yielding = first.as_ref().map_or(&args.compliance.compliance, |first| &first.compliance);
    loaded.model.compliances = compliances(&loaded.model, yielding)
        .map_err(|error| loaded.source.rejected(error.diagnostics()))?;
    let solve = &mut loaded.model.solve;
    changes(&args.tuning, solve.t_start)?.apply(solve);
    let path = match first {
        Some(_) => resume::output_path(args),
        None => args.output.clone().unwrap_or_else(|| {
            let log = named_after(&args.model.model, "mcap");
            args.model.set.case().map_or_else(|| log.clone(), |case| of_case(&log, case).into())
        }),
    };
    let mut inputs = loaded.source.files();
    inputs.push(&args.model.model);
    // A log that is continued in its own place is replaced when all of it, and more, has been written.
    if first.is_some() && args.force {
        inputs.retain(|input| !is_same_file(&path, input));
    }
    let label = match &first {
        Some(first) => first.file.clone(),
        None => label_of(&loaded.source.path),
    };
    let is_own = || is_of_model(&path, &label) || is_of_text(&path, &loaded.source.text);
    let may_replace = args.force || is_own();
    let output = OutputFile::plan(&path, ("model", &inputs), may_replace, "nothing was solved")?;
    check_ending(&path, &["mcap"])?;
    times.parse = clock.lap();

    // Derive and compile.
    let source = loaded.source;
    let rejected = |Rejected(faults): Rejected| source.rejected(faults);
    let mechanism = derive(&source, loaded.model)?;
    times.derive = clock.lap();
    let simulation = mechanism.simulation().map_err(rejected)?;
    times.compile = clock.lap();

    // The start, and what is known about it.
    let start = waiting("looking for the start", || simulation.start()).map_err(rejected)?;
    simulation.check_first_sample(&start).map_err(rejected)?;
    let sensitive = mechanism.all_sensitive(&args.sensitivity).map_err(rejected)?;
    let plan = (!sensitive.is_empty()).then(|| simulation.plan_sensitivities(&start, &sensitive));
    let plan = plan.transpose().map_err(rejected)?;
    let found = mobility(&mechanism.model, &mechanism.system, &start);
    let mut warnings = mechanism.warnings_of(&start, &found, loaded.warnings);
    warnings.extend(diagnose_singular_start(&mechanism, &start));
    times.assemble = clock.lap();
    Ok(Prepared {
        source,
        mechanism,
        simulation,
        start,
        found,
        sensitive,
        plan,
        warnings,
        first,
        label,
        output,
    })
}

/// A log with everything ahead of the samples; of a run that is continued, with its first part.
fn open_log(prepared: &Prepared, args: &Solve) -> Result<(Log, LogFile), Failure> {
    let Prepared { mechanism, simulation, start, sensitive, first, output, .. } = prepared;
    let path = output.path();
    let unwritten = |error: LogError| Failure::writing(path, &error);

    // The options of the run and the channels, as the log has them.
    let mut options = described(&mechanism.model, sensitive);
    let set = first.as_ref().map_or(&*args.model.set, |first| &first.set);
    options.extend(set.iter().map(|(name, value)| set_option(name, value)));
    let yielding = first.as_ref().map_or(&args.compliance.compliance, |first| &first.compliance);
    options.extend(compliance_options(yielding));
    options.push((MODEL_FILE.to_owned(), prepared.label.clone()));
    let channels = first.as_ref().map_or(args.channels, |first| first.channels);
    if channels == args::Channels::Own {
        options.push(OWN_CHANNELS.map(str::to_owned).into());
    }
    let has_viewers = channels == args::Channels::All;
    let contents = Contents { options: &options, sensitive, has_viewers };

    // The file, with the warnings, or with what the first part holds.
    let file = output.create_growing()?;
    let written = LogFile { path: file.path_now().to_owned(), n_bytes: file.n_bytes() };
    let text = &prepared.source.text;
    let mut log = Recorder::create_with(BufWriter::new(file), simulation, text, start, &contents)
        .map_err(unwritten)?;
    if let Some(first) = first {
        first.copy_into(&mut log, path)?;
        return Ok((log, written));
    }
    for warning in &prepared.warnings {
        log.note(Level::Warning, start.t, &in_log(warning)).map_err(unwritten)?;
    }
    Ok((log, written))
}

/// Runs to the end, or until `stop` is wished, and writes samples to `log`; says how long that took.
fn integrate(
    prepared: &Prepared,
    (log, written): (Log, &LogFile),
    (stop, log_limit): (&StopWish, u64),
    as_json: bool,
) -> Result<Integrated, Failure> {
    let Prepared { simulation, start, plan, first, output, .. } = prepared;
    let progress = Progress::new(start.t, simulation.options().t_end);
    let reached = first.as_ref().map_or(start.t, |first| first.checkpoint.t());
    let size = || Size { n_bytes: written.n_bytes.clone(), limit: log_limit };
    let (size, own) = (size(), size());
    let mut logging = Logging::new((log, progress), reached, (prepared, !as_json), (stop, own));
    // Steps between two samples fill a log, too.
    let is_stop_wished = || stop.status().is_some() || size.is_reached();
    let outcome = match (plan, first) {
        (Some(plan), _) => {
            simulation.run_with_sensitivities(start, plan, &mut logging, &is_stop_wished)
        }
        (None, None) => simulation.run(start, &mut logging, &is_stop_wished),
        (None, Some(first)) => {
            match simulation.resume(start, &first.checkpoint, &mut logging, &is_stop_wished) {
                Ok(summary) => Ok(summary),
                Err(Unresumed::Failed(failure)) => Err(failure),
                Err(Unresumed::Unfit(unfit)) => {
                    drop(logging);
                    // Nothing but a copy is lost.
                    let _ = fs::remove_file(&written.path);
                    return Err(resume::unfit(&first.path, &unfit));
                }
            }
        }
    };
    let Logging { log, progress, fault, taken, .. } = logging;
    progress.finish();
    let cut = match fault {
        None => size.is_reached().then_some(Cut::Full(log_limit)),
        Some((_, LogError::NotFinite { channel, t, value })) => {
            Some(Cut::NotFinite { channel, t, value })
        }
        Some((t, error)) => {
            drop(log);
            let error = error.to_string();
            let what = format!("cannot be written beyond t = {t} s: {}", without_number(&error));
            return Err(Failure::file(output.path(), what, Some(files::kept(&written.path))));
        }
    };
    Ok(Integrated { log, outcome, taken, cut })
}

/// How a run ended; the fault of one that failed is said, and is a warning of the report.
fn conclude(
    prepared: &mut Prepared,
    (outcome, cut): (Outcome, Option<Cut>),
    stop: &StopWish,
    as_json: bool,
) -> Conclusion {
    let (summary, fault) = match outcome {
        Ok(summary) if summary.reached_end && !matches!(cut, Some(Cut::NotFinite { .. })) => {
            let reason = "end time reached".to_owned();
            return Conclusion { summary, status: Status::Done, reason };
        }
        Ok(summary) => {
            let Some(cut) = cut.filter(|_| stop.status().is_none()) else {
                let status = stop.status().unwrap_or(Status::Interrupted);
                let how = if status == Status::Terminated { "terminated" } else { "interrupted" };
                return Conclusion { summary, status, reason: how.to_owned() };
            };
            let fault = cut.fault(summary.t, prepared.output.path());
            (summary, fault)
        }
        Err(failure) => {
            let fault = prepared.simulation.diagnose(&failure);
            (failure.summary, fault)
        }
    };
    let reason = in_log(&fault);
    if !as_json {
        render::print_all(&prepared.source, std::slice::from_ref(&fault));
    }
    prepared.warnings.push(fault);
    Conclusion { summary, status: Status::StoppedEarly, reason }
}

/// Says what the numbers of the run are worth, where that is less than the tolerances promise.
fn judge(
    prepared: &mut Prepared,
    log: &mut Log,
    (summary, status): (&Summary, Status),
    as_json: bool,
) -> Result<(), Failure> {
    let Prepared { simulation, source, output, warnings, .. } = prepared;
    // That the run is slow has been said, and stands in the log.
    let slow = summary.slowness.as_ref().filter(|slowness| !slowness.is_hopeless);
    let slow = slow.map(|slowness| simulation.diagnose_slowness(slowness));
    // What is wrong with a run that failed has been said.
    let worth = match status {
        Status::StoppedEarly => Vec::new(),
        _ => simulation.diagnose_worth(summary),
    };
    if !as_json {
        render::print_all(source, &worth);
    }
    for warning in &worth {
        log.note(Level::Warning, summary.t, &in_log(warning))
            .map_err(|error| Failure::writing(output.path(), &error))?;
    }
    warnings.extend(slow.into_iter().chain(worth));
    Ok(())
}

/// A warning as a line of the log.
fn in_log(warning: &Diagnostic) -> String {
    format!("[{}] {}", warning.code.0, warning.message)
}

/// Ends the log, and puts it in the place of the one that it continues.
fn close_log(
    prepared: &Prepared,
    mut log: Log,
    summary: &Summary,
    status: Status,
    reason: &str,
) -> Result<(), Failure> {
    let Prepared { output, .. } = prepared;
    let path = output.path();
    let unwritten = |error: LogError| Failure::writing(path, &error);
    let outcome =
        if status == Status::Done { log::Outcome::ReachedEnd } else { log::Outcome::Stopped };
    if status != Status::Done {
        log.note(Level::Error, summary.t, reason).map_err(unwritten)?;
    }
    let out = log.finish(summary, outcome, reason).map_err(unwritten)?;
    let file = out.into_inner().map_err(|e| Failure::writing(path, e.error()))?;
    file.finish()
}

/// The outcome of a run.
type Outcome = Result<Summary, Box<run::Failure>>;

/// A log in the making.
type Log = Recorder<BufWriter<Written>>;

/// The time since it was asked last.
struct Clock(Instant);

impl Clock {
    fn begin() -> Self {
        Self(Instant::now())
    }

    fn lap(&mut self) -> Duration {
        std::mem::replace(&mut self.0, Instant::now()).elapsed()
    }
}

/// The options of the command line, checked; runs begin at `t_start`.
///
/// # Errors
/// An option out of its range.
pub fn changes(args: &Tuning, t_start: f64) -> Result<SolveChanges, Failure> {
    let changes = SolveChanges {
        t_end: args.t_end,
        rtol: args.rtol,
        atol: args.atol,
        step: args.step,
        every: args.every,
        method: args.method.map(Into::into),
        formulation: args.formulation.map(Into::into),
        jit: args.jit.map(Into::into),
    };
    changes.check(t_start).map_err(|BadOption { option, value, range }| {
        let flag = format!("--{}", option.replace('_', "-"));
        let message = format!("`{flag} {}` is not {range}", in_words(value));
        Failure::usage(message, &format!("give {flag} a value {range}"))
    })?;
    Ok(changes)
}
