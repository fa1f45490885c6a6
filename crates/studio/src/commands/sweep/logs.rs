//! Logs of chosen cases of a sweep, each as `bksim solve` with the values of the case writes it.

use std::path::{Path, PathBuf};

use bksim_sweep::{Chosen, NoCases, Study};
use serde_json::{Value, json};

use bksim_cli::args::ModelArgs;
use bksim_cli::args::changes::Changes;
use bksim_cli::args::sweep::Sweep;
use bksim_cli::commands::solve::solve_into_log;
use bksim_cli::exit::{Failure, Status};
use bksim_cli::progress::StopWish;

/// A chosen case, and what became of it.
pub(super) struct CaseLog {
    case: u64,
    /// Log of the run; none of a case that could not start.
    output: Option<PathBuf>,
}

/// The choice of `--log-cases`.
pub(super) fn chosen(args: &Sweep) -> Result<Option<Chosen>, Failure> {
    let Some(text) = &args.log_cases else { return Ok(None) };
    let chosen = Chosen::parse(text).map_err(|fault| {
        Failure::usage(format!("`--log-cases`: {fault}"), "see `bksim sweep --help`")
    })?;
    if args.model.as_os_str() == "-" {
        let help = "write the model into a file: it is read again for each log";
        return Err(Failure::usage("`--log-cases` with a model from standard input", help));
    }
    Ok(Some(chosen))
}

/// Solves the chosen cases again, each into its log; what has been asked to stop stops.
pub(super) fn write_logs(
    args: &Sweep,
    (study, table): (&Study, &Path),
    (chosen, fixed): (&Chosen, &[(String, String)]),
    (stop, nesting): (&StopWish, usize),
) -> Result<Vec<CaseLog>, Failure> {
    let cases = chosen.cases(study, table).map_err(|error| match error {
        NoCases::Unknown(what) => {
            let help = "the table is written; see `bksim sweep --help` on choosing cases";
            Failure::usage(format!("`--log-cases`: {what}"), help)
        }
        NoCases::Table(error) => Failure::file(table, format!("cannot be read: {error}"), None),
    })?;
    let folder = args.logs.clone().or_else(|| table.parent().map(Path::to_owned));
    let folder = folder.unwrap_or_default();
    if !folder.as_os_str().is_empty() {
        std::fs::create_dir_all(&folder).map_err(|error| Failure::writing(&folder, &error))?;
    }
    let stem = table.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut logs = Vec::with_capacity(cases.len());
    for case in cases {
        if stop.status().is_some() {
            break;
        }
        let path = folder.join(format!("{stem}-{case}.mcap"));
        let set = Changes([fixed, &study.overrides(case)].concat());
        let model = ModelArgs { model: args.model.clone(), set, drawing: args.drawing.clone() };
        let log = (path.as_path(), args.force);
        let output = match solve_into_log(model, log, &args.compliance, &args.tuning, nesting) {
            Ok(Status::Interrupted | Status::Terminated) => break,
            Ok(_) => Some(path),
            // Its values or its start are refused, as the table says.
            Err(Failure::Model { .. }) => None,
            Err(failure) => return Err(failure),
        };
        logs.push(CaseLog { case, output });
    }
    Ok(logs)
}

/// The lines on the logs of a report.
pub(super) fn lines(logs: &[CaseLog]) -> Vec<String> {
    let written = |log: &CaseLog| match &log.output {
        Some(path) => format!("  case {:<8}{}", log.case, path.display()),
        None => format!("  case {:<8}no log: its values or its start are refused", log.case),
    };
    logs.iter().map(written).collect()
}

/// The logs as JSON.
pub(super) fn described(logs: &[CaseLog]) -> Vec<Value> {
    let one = |log: &CaseLog| {
        let output = log.output.as_ref().map(|path| path.display().to_string());
        json!({ "case": log.case, "output": output })
    };
    logs.iter().map(one).collect()
}
