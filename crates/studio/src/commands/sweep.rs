//! `bksim sweep`: from a model and its axes to one table.

mod logs;

use std::path::{Path, PathBuf};
use std::time::Instant;

use bksim::model::diagnostic::Diagnostic;
use bksim::model::message::counted;
use bksim_sweep::{
    Axis, Design, Existing, Monitor, Plan, Report, Request, Study, SweepError, axes_of_table,
    stated_axes, write,
};
use serde_json::{Value, json};

use self::logs::CaseLog;
use bksim_cli::args::ModelArgs;
use bksim_cli::args::changes::Changes;
use bksim_cli::args::sweep::Sweep;
use bksim_cli::commands::solve::{changes, named_after};
use bksim_cli::exit::{Failure, Status, without_number};
use bksim_cli::origin::{has_headings, is_of_model, label_of, may_be_own};
use bksim_cli::output;
use bksim_cli::output_file::{OutputFile, check_ending};
use bksim_cli::progress::{Progress, StopWish};
use bksim_cli::render;
use bksim_cli::source::{Text, load, read_bytes};
use bksim_cli::waiting::waiting;

pub(crate) fn run(args: &Sweep, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let begun = Instant::now();
    // Take the values that vary apart from those that do not, and read the model with the latter.
    let Settings { axes, fixed, fault } = Settings::of(&args.set);
    let chosen = logs::chosen(args)?;
    if args.drawing.shown(&args.model).is_some_and(|units| !units.eq_ignore_ascii_case("si")) {
        let help = "leave out the units; an output in another unit is one divided by it, as in `max(A.angle)/(1 deg)`";
        return Err(Failure::usage("the table of a sweep is in SI units", help));
    }
    let model = args.model.clone();
    let set = Changes(fixed);
    let set = args.case.as_ref().map_or_else(|| set.clone(), |case| set.of_case(case));
    let model = ModelArgs { model, set, drawing: args.drawing.clone() };
    let loaded = load(&model, nesting)?;
    let source = &loaded.source;
    let rejected = |fault: Diagnostic| source.rejected(vec![fault]);
    let of_table = match &args.cases {
        Some(path) => {
            let bytes = read_bytes(path)?;
            axes_of_table(&String::from_utf8_lossy(&bytes)).map_err(rejected)?
        }
        None => Vec::new(),
    };
    let design = design(args);
    let axes = match fault {
        Some(fault) => Err(fault),
        // Samples of a model that states ranges need no axes.
        None if axes.is_empty() && design.is_sampled() => stated_axes(&source.text, &model.set.0),
        None => Ok([axes, of_table].concat()),
    };
    let plan = axes.and_then(|axes| Plan::new(axes, design)).map_err(rejected)?;
    if plan.axes().is_empty() {
        let help = "add `--set NAME=FROM:TO:COUNT`, or `--sobol 64` for samples between the `[ranges]` of the model; without any, `bksim solve` is the command";
        return Err(Failure::usage("a sweep needs something that varies", help));
    }
    let path = output_path(args);
    let label = label_of(&loaded.source.path);
    check_ending(&path, &["parquet", "csv"])?;
    OutputFile::plan(
        &path,
        ("model", &[]),
        args.force || args.resume || may_be_own(&path) || is_of_model(&path, &label),
        "nothing was solved",
    )?;

    // Derive and compile once.
    let mut request = Request::new(&source.text, &loaded.model.name, plan);
    request.limits.nesting = nesting;
    request.file = label;
    request.fixed.clone_from(&model.set);
    request.compliance.clone_from(&args.compliance.compliance);
    request.outputs.clone_from(&args.keep);
    request.changes = changes(&args.tuning, loaded.model.solve.t_start)?;
    let study = waiting("deriving the equations", || Study::prepare(request));
    let study = study.map_err(|rejected| source.rejected(rejected.0))?;
    let path = table_path(args, &study, source)?;
    let warnings = loaded.warnings;
    if !as_json {
        render::print_all(source, &warnings);
    }

    // Solve the cases, until a signal comes.
    let stop = StopWish::watch().map_err(|e| {
        Failure::file(&path, format!("is not written: signals cannot be handled: {e}"), None)
    })?;
    let written = solved(&study, &path, args, &stop);
    let report = written.map_err(|error| failure(source, error))?;

    // The logs of cases that are asked for.
    let logs = match &chosen {
        Some(chosen) if !report.is_stopped => {
            let what = (chosen, model.set.as_slice());
            logs::write_logs(args, (&study, &path), what, (&stop, nesting))?
        }
        _ => Vec::new(),
    };

    // Tell how it went.
    let status = match stop.status() {
        Some(status) if report.is_stopped || chosen.is_some() => status,
        _ if report.n_done == 0 => Status::Rejected,
        _ => Status::Done,
    };
    let told = SweepReport {
        study: &study,
        path: &path,
        report: &report,
        logs: &logs,
        seconds: begun.elapsed().as_secs_f64(),
    };
    if as_json {
        let mut body = told.describe(status);
        body["diagnostics"] = render::json_all(source, &warnings);
        output::json("sweep", body)?;
    } else {
        tell(&told)?;
    }
    Ok(status)
}

/// The file of the table; refuses to write over what is not ours before any work is done.
fn table_path(args: &Sweep, study: &Study, source: &Text) -> Result<PathBuf, Failure> {
    let path = output_path(args);
    let mut inputs = source.files();
    inputs.push(&args.model);
    check_ending(&path, &["parquet", "csv"])?;
    // What is to be gone on with is not whole yet: a table in its place is of another sweep.
    let is_own = || is_of_model(&path, &label_of(&source.path)) || is_own_csv(&path, study);
    let may_replace = args.force || !args.resume && is_own();
    OutputFile::plan(&path, ("model", &inputs), may_replace, "nothing was solved")?;
    Ok(path)
}

/// Where the table goes.
fn output_path(args: &Sweep) -> PathBuf {
    args.out.clone().unwrap_or_else(|| named_after(&args.model, "parquet"))
}

/// True for a table in text whose columns this sweep has, too, or that a sweep of this model may have.
fn is_own_csv(path: &Path, study: &Study) -> bool {
    let columns = study.input_columns().into_iter().chain(study.output_columns());
    let names: Vec<String> = columns.map(|column| column.name).collect();
    let of_all = ["case", "status", "code", "reason", "t_reached", "steps"];
    has_headings(path, &|name| of_all.contains(&name) || names.iter().any(|own| own == name))
}

/// Solves the cases into a table, with progress on a terminal.
fn solved(study: &Study, path: &Path, args: &Sweep, stop: &StopWish) -> Result<Report, SweepError> {
    let progress = Progress::of("sweeping", 0.0, 1.0);
    let n_cases = study.n_cases();
    let monitor = Monitor {
        stop: &|| stop.status().is_some(),
        progress: &|n_ended| progress.ended(n_ended, n_cases),
    };
    let existing = match (args.resume, args.force) {
        (true, _) => Existing::Resume,
        (_, true) => Existing::Replace,
        _ => Existing::Refuse,
    };
    let written = write(study, path, existing, args.jobs, &monitor);
    progress.finish();
    written
}

/// Tells people how a sweep went.
fn tell(told: &SweepReport<'_>) -> Result<(), Failure> {
    let (report, n_cases) = (told.report, told.study.n_cases());
    output::report(&told.text())?;
    if report.is_stopped {
        let how = format!(
            "interrupted: {} of {n_cases} cases are kept; the same command with --resume goes on",
            report.n_done + report.n_failed
        );
        render::warning(&how);
    } else if report.n_failed > 0 {
        render::warning(&format!("{} of {n_cases} cases failed", report.n_failed));
    }
    Ok(())
}

/// Parameters that vary, and those that have one value.
#[derive(Default)]
struct Settings {
    axes: Vec<Axis>,
    fixed: Vec<(String, String)>,
    /// The first thing that is neither.
    fault: Option<Diagnostic>,
}

impl Settings {
    fn of(set: &[(String, String)]) -> Self {
        let mut settings = Self::default();
        for (name, value) in set {
            match Axis::parse(name, value) {
                Ok(Some(axis)) => settings.axes.push(axis),
                Ok(None) => settings.fixed.push((name.clone(), value.clone())),
                Err(fault) => settings.fault = settings.fault.or(Some(fault)),
            }
        }
        settings
    }
}

fn design(args: &Sweep) -> Design {
    let seed = args.seed;
    if args.pairs || args.cases.is_some() {
        return Design::Pairs;
    }
    match (args.random, args.lhs, args.sobol) {
        (Some(n), ..) => Design::Random { n, seed },
        (_, Some(n), _) => Design::LatinHypercube { n, seed },
        (.., Some(n)) => Design::Sobol { n, seed },
        _ => Design::Grid,
    }
}

fn failure(source: &Text, error: SweepError) -> Failure {
    match error {
        SweepError::Rejected(rejected) => source.rejected(rejected.0).into(),
        SweepError::File { path, error } => Failure::writing(&path, &error),
        SweepError::Table { path, error } => {
            let what = format!("cannot be written: {}", without_number(&error.to_string()));
            Failure::file(&path, what, None)
        }
        error => Failure::usage(error.to_string(), "ask for fewer with --jobs"),
    }
}

/// The last words of the command.
struct SweepReport<'a> {
    study: &'a Study,
    path: &'a Path,
    report: &'a Report,
    logs: &'a [CaseLog],
    seconds: f64,
}

impl SweepReport<'_> {
    fn text(&self) -> String {
        let Self { study, path, report, logs, seconds } = self;
        let varied = study.plan().axes().iter().map(|axis| axis.name.as_str());
        let varied: Vec<&str> = varied.collect();
        let design = match study.plan().design() {
            Design::Grid => "grid",
            Design::Pairs => "pairs",
            Design::Random { .. } => "random samples",
            Design::LatinHypercube { .. } => "Latin hypercube",
            Design::Sobol { .. } => "Sobol's sequence",
        };
        let mut lines = vec![
            format!("{}: {} of {} cases done", study.model_name(), report.n_done, report.n_cases),
            format!("  varied       {} ({design})", varied.join(", ")),
            format!(
                "  kept         {} of each run",
                counted(study.outputs().len(), "number", "numbers")
            ),
        ];
        if report.n_resumed > 0 {
            lines.push(format!("  from before  {}", counted(report.n_resumed, "case", "cases")));
        }
        for (code, fault) in &report.faults {
            let set: Vec<String> = study
                .settings(fault.first_case)
                .into_iter()
                .map(|(name, value)| format!("{name}={value}"))
                .collect();
            lines.push(format!(
                "  {code}         {} failed, the first with {}: {}",
                fault.n,
                set.join(" "),
                fault.reason
            ));
        }
        lines.push(format!("  time         {seconds:.1} s"));
        if !report.is_stopped {
            lines.push(format!("  table        {}", path.display()));
        }
        lines.extend(logs::lines(logs));
        lines.join("\n")
    }

    fn describe(&self, status: Status) -> Value {
        let Self { study, path, report, logs, seconds } = self;
        let column =
            |column: &bksim_sweep::Column| json!({ "name": column.name, "unit": column.unit });
        let columns =
            |all: Vec<bksim_sweep::Column>| all.iter().map(column).collect::<Vec<Value>>();
        let faults = report.faults.iter().map(|(code, fault)| {
            json!({
                "code": code,
                "cases": fault.n,
                "first_case": fault.first_case,
                "reason": fault.reason,
            })
        });
        json!({
            "ok": status == Status::Done,
            "exit_status": status.code(),
            "model": study.model_name(),
            "output": if report.is_stopped { Value::Null } else { path.display().to_string().into() },
            "cases": report.n_cases,
            "done": report.n_done,
            "failed": report.n_failed,
            "resumed": report.n_resumed,
            "stopped": report.is_stopped,
            "inputs": columns(study.input_columns()),
            "outputs": columns(study.output_columns()),
            "faults": faults.collect::<Vec<_>>(),
            "logs": logs::described(logs),
            "seconds": seconds,
        })
    }
}
