//! `bksim solve`: from the model file to the log.

mod events;
mod report;
mod resume;

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bksim::dae::Control;
use bksim::log::{Level, LogError, Outcome};
use bksim::options::{BadOption, SolveChanges, described, in_words};
use bksim::record::{Contents, Recorder, set_option};
use bksim::sim::fault::diagnose_mobility;
use bksim::sim::mobility::mobility;
use bksim::sim::run::{Observer, Sample, Segment, Unresumed};
use bksim::sim::sensitivity::StateSensitivity;

use self::report::{Report, Times};
use crate::args::{self, Solve, Tuning};
use crate::exit::{Failure, Status, without_number};
use crate::output;
use crate::progress::{Progress, StopWish};
use crate::render;
use crate::source::{derive, load};

/// The option of a log without the channels of other programs.
const OWN_CHANNELS: [&str; 2] = ["channels", "own"];

pub(crate) fn run(args: &Solve, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let mut times = Times::default();
    let mut clock = Instant::now();
    let mut lap = || std::mem::replace(&mut clock, Instant::now()).elapsed();

    // Read, and refuse an output that cannot be written before any work is done.
    let (mut loaded, first) = if args.resume {
        let (loaded, first) = resume::open(&args.model.model, nesting)?;
        (loaded, Some(first))
    } else {
        (load(&args.model, nesting)?, None)
    };
    let solve = &mut loaded.model.solve;
    changes(&args.tuning, solve.t_start)?.apply(solve);
    let set = first.as_ref().map_or(&args.model.set, |first| &first.set);
    let path = match first {
        Some(_) => resume::output_path(args),
        None => output_path(args, &loaded.model.name),
    };
    let is_same = first.is_some() && is_same_file(&path, &args.model.model);
    if !(is_same && args.force) {
        let mut inputs = loaded.source.files();
        inputs.push(&args.model.model);
        check_output(&path, &inputs, args.force)?;
    }
    // The log that is read is replaced only when all of it, and more, has been written.
    let written = if is_same { resume::beside(&path) } else { path.clone() };
    times.parse = lap();

    let mechanism = derive(&loaded.source, loaded.model)?;
    times.derive = lap();
    let source = &loaded.source;
    let equations = mechanism.formulate().map_err(|rejected| source.rejected(rejected.0))?;
    times.compile = lap();
    let start = mechanism.start().map_err(|rejected| source.rejected(rejected.0))?;
    let sensitive = mechanism
        .all_sensitive(&args.sensitivity)
        .map_err(|rejected| source.rejected(rejected.0))?;
    let plan = (!sensitive.is_empty()).then(|| mechanism.plan_sensitivities(&start, &sensitive));
    let plan = plan.transpose().map_err(|rejected| source.rejected(rejected.0))?;
    let found = mobility(&mechanism.model, &mechanism.system, &start);
    let mut warnings = loaded.warnings;
    warnings.extend(diagnose_mobility(&mechanism.model, &found));
    times.assemble = lap();
    if !as_json {
        render::print_all(source, &warnings);
    }

    // The log is opened only now: a rejected model touches no file.
    let file = File::create(&written).map_err(|e| Failure::writing(&written, &e))?;
    let mut options = described(&mechanism.model, &sensitive);
    options.extend(set.iter().map(|(name, value)| set_option(name, value)));
    let channels = match &first {
        Some(first) => first.channels,
        None => args.channels,
    };
    if channels == args::Channels::Own {
        options.push(OWN_CHANNELS.map(str::to_owned).into());
    }
    let has_viewers = channels == args::Channels::All;
    let contents = Contents { options: &options, sensitive: &sensitive, has_viewers };
    let out = BufWriter::new(file);
    let text = &source.text;
    let mut log = Recorder::create_with(out, &mechanism, text, &start, &contents)
        .map_err(|e| Failure::writing(&path, &e))?;
    if let Some(first) = &first {
        first.copy_into(&mut log, &path)?;
    }
    for warning in warnings.iter().filter(|_| first.is_none()) {
        let text = format!("[{}] {}", warning.code.0, warning.message);
        log.note(Level::Warning, start.t, &text).map_err(|e| Failure::writing(&path, &e))?;
    }
    times.log = lap();

    let stop = StopWish::watch().map_err(|e| {
        Failure::file(&path, format!("is empty: signals cannot be handled: {e}"), None)
    })?;
    let progress = Progress::new(start.t, mechanism.model.solve.t_end);
    let reached = first.as_ref().map_or(start.t, |first| first.checkpoint.t());
    let mut logging = Logging { log, progress, reached, fault: None, taken: Duration::ZERO };
    let is_stop_wished = || stop.status().is_some();
    let result = match (&plan, &first) {
        (Some(plan), _) => mechanism.run_with_sensitivities(
            &equations,
            &start,
            plan,
            &mut logging,
            &is_stop_wished,
        ),
        (None, None) => mechanism.run(&equations, &start, &mut logging, &is_stop_wished),
        (None, Some(first)) => {
            let from = &first.checkpoint;
            match mechanism.resume(&equations, &start, from, &mut logging, &is_stop_wished) {
                Err(Unresumed::Unfit(unfit)) => {
                    drop(logging);
                    // Nothing but a copy is lost.
                    let _ = fs::remove_file(&written);
                    return Err(resume::unfit(&args.model.model, &unfit));
                }
                Err(Unresumed::Failed(failure)) => Err(failure),
                Ok(summary) => Ok(summary),
            }
        }
    };
    let Logging { mut log, progress, fault, taken, .. } = logging;
    progress.finish();
    times.integrate = lap().saturating_sub(taken);
    times.log += taken;
    if let Some((t, error)) = fault {
        let error = error.to_string();
        let what = format!("cannot be written beyond t = {t} s: {}", without_number(&error));
        let help = "everything up to there is in the log".to_owned();
        return Err(Failure::file(&path, what, Some(help)));
    }

    // How it ended, in the log and in the exit status.
    let (summary, status, reason) = match result {
        Ok(summary) if summary.reached_end => {
            (summary, Status::Done, "end time reached".to_owned())
        }
        Ok(summary) => {
            let status = stop.status().unwrap_or(Status::Interrupted);
            let how = if status == Status::Terminated { "terminated" } else { "interrupted" };
            (summary, status, how.to_owned())
        }
        Err(failure) => {
            let fault = mechanism.diagnose(&equations, &failure);
            let reason = format!("[{}] {}", fault.code.0, fault.message);
            if !as_json {
                render::print_all(source, std::slice::from_ref(&fault));
            }
            warnings.push(fault);
            (failure.summary, Status::StoppedEarly, reason)
        }
    };
    let outcome = if status == Status::Done { Outcome::ReachedEnd } else { Outcome::Stopped };
    if status != Status::Done {
        log.note(Level::Error, summary.t, &reason).map_err(|e| Failure::writing(&path, &e))?;
    }
    let out = log.finish(&mechanism, &summary, outcome, &reason);
    let out = out.map_err(|e| Failure::writing(&path, &e))?;
    let file = out.into_inner().map_err(|e| Failure::writing(&path, e.error()))?;
    if is_same {
        resume::replace(&file, &written, &path)?;
    }
    times.log += lap();

    let report = Report {
        source,
        path: &path,
        summary: &summary,
        times: &times,
        status,
        mechanism: &mechanism,
        sensitive: &sensitive,
    };
    if as_json {
        let mut body = report.describe();
        body["diagnostics"] = render::json_all(source, &warnings);
        output::json("solve", body)?;
    } else {
        output::text(&report.text())?;
    }
    Ok(status)
}

/// Writes a run to its log as it goes on.
struct Logging<W: Write> {
    log: Recorder<W>,
    progress: Progress,
    /// Time of the last sample that was written, s.
    reached: f64,
    /// Why the log cannot be written any more, and the last time in it.
    fault: Option<(f64, LogError)>,
    /// Time spent here.
    taken: Duration,
}

impl<W: Write> Logging<W> {
    fn write(&mut self, write: impl FnOnce(&mut Recorder<W>) -> Result<(), LogError>) {
        let begun = Instant::now();
        if self.fault.is_none()
            && let Err(error) = write(&mut self.log)
        {
            self.fault = Some((self.reached, error));
        }
        self.taken += begun.elapsed();
    }
}

impl<W: Write> Observer for Logging<W> {
    fn sample(&mut self, sample: &Sample, by: &[StateSensitivity]) -> Control {
        self.write(|log| log.write(sample).and_then(|()| log.write_sensitivities(sample.t, by)));
        if self.fault.is_some() {
            return Control::Stop;
        }
        self.reached = sample.t;
        self.progress.reached(sample.t);
        Control::Continue
    }

    fn wants_segments(&self) -> bool {
        true
    }

    fn segment(&mut self, segment: &Segment) {
        // A fault stops the run at its next sample.
        self.write(|log| log.segment(segment));
    }
}

/// The options of the command line, checked; runs begin at `t_start`.
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

fn output_path(args: &Solve, model_name: &str) -> PathBuf {
    args.output.clone().unwrap_or_else(|| named_after(model_name, "mcap"))
}

/// A file in the working directory that is called after a model.
pub fn named_after(model_name: &str, ending: &str) -> PathBuf {
    let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    PathBuf::from(format!("{}.{ending}", model_name.chars().map(plain).collect::<String>()))
}

fn is_same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// Refuses an output that exists, is the model itself, or has no directory to lie in.
pub fn check_output(path: &Path, inputs: &[&Path], force: bool) -> Result<(), Failure> {
    let nothing_solved = "nothing was solved";
    let directory = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if !directory.is_dir() {
        let there = directory.display();
        let what = format!("cannot be written: there is no directory `{there}`; {nothing_solved}");
        let help = format!("make it with `mkdir -p {}`", directory.display());
        return Err(Failure::file(path, what, Some(help)));
    }
    if inputs.iter().any(|input| is_same_file(path, input)) {
        let what = format!("is the model itself and would be overwritten; {nothing_solved}");
        return Err(Failure::file(path, what, Some("name another file with -o".to_owned())));
    }
    if let Ok(known) = fs::metadata(path) {
        if known.is_dir() {
            let what = format!("is a directory; {nothing_solved}");
            return Err(Failure::file(path, what, Some("name a file in it".to_owned())));
        }
        if !force {
            let written = known.modified().ok().map_or_else(String::new, |time| {
                format!(", written {}", humantime::format_rfc3339_seconds(time))
            });
            let what = format!("exists ({} bytes{written}); {nothing_solved}", known.len());
            let help = "add --force to overwrite it, or name another file with -o".to_owned();
            return Err(Failure::file(path, what, Some(help)));
        }
    }
    Ok(())
}
