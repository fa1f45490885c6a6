//! Runs to read: a log, or that of a model, which is solved first.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use tempfile::TempDir;

use super::{Times, solved};
use crate::args::analysis::ComplianceArgs;
use crate::args::run::RunArgs;
use crate::args::{Channels, LOG_LIMIT, Solve, Tuning};
use crate::exit::{Failure, Status};
use crate::render;
use crate::source::logged::is_log;

/// A log that can be opened, as often as is needed.
#[derive(Debug)]
pub struct RunFile {
    /// The file that was named: a log, or a model.
    pub name: PathBuf,
    /// How the run of a model ended.
    pub status: Status,
    /// Warnings of the model, and why its run ended early.
    pub diagnostics: Value,
    /// The log of a model, while it is needed.
    solved: Option<TempDir>,
}

/// Name of the log of a model.
const LOG: &str = "run.mcap";

impl RunFile {
    /// The log that is named, or that of the model. Options for models are refused where there is none.
    ///
    /// # Errors
    /// A model that is refused or has no start; a log that cannot be written.
    pub fn open(args: &RunArgs, nesting: usize, as_json: bool) -> Result<Self, Failure> {
        let name = args.input.clone();
        if is_log(&name) {
            if !args.reading.set.is_empty() || args.reading.drawing.tolerance.is_some() {
                return Err(Failure::usage(
                    "--set and --tolerance are for models, and this is a log",
                    "solve the model with them, or name the model",
                ));
            }
            let diagnostics = json!([]);
            return Ok(Self { name, status: Status::Done, diagnostics, solved: None });
        }
        // What is no log is read as a model, and its faults told.
        let folder = tempfile::tempdir().map_err(|e| Failure::writing(Path::new(LOG), &e))?;
        let request = Solve {
            model: args.model(),
            output: Some(folder.path().join(LOG)),
            force: false,
            resume: false,
            tuning: Tuning::default(),
            compliance: ComplianceArgs::default(),
            sensitivity: Vec::new(),
            channels: Channels::Own,
            log_limit: LOG_LIMIT,
        };
        let (prepared, _, status) = solved(&request, nesting, as_json, &mut Times::default())?;
        let diagnostics = render::json_all(&prepared.source, &prepared.warnings);
        Ok(Self { name, status, diagnostics, solved: Some(folder) })
    }

    /// The log.
    pub fn log(&self) -> PathBuf {
        self.solved.as_ref().map_or_else(|| self.name.clone(), |folder| folder.path().join(LOG))
    }

    /// The status of an interrupted run, of which nothing is to be told.
    pub fn interrupted(&self) -> Option<Status> {
        [Status::Interrupted, Status::Terminated].contains(&self.status).then_some(self.status)
    }

    /// True where a model was solved.
    pub fn is_of_model(&self) -> bool {
        self.solved.is_some()
    }
}
