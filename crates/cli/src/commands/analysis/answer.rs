//! Answers: as JSON, as a table in a file, as text.

use std::io::Write;

use bksim::analysis::{AnalysisError, Column, Table};
use serde_json::{Value, json};

use crate::args::ModelArgs;
use crate::args::analysis::TableArgs;
use crate::exit::{Failure, Status};
use crate::output::{self, number, table};
use crate::output_file::OutputFile;
use crate::render;
use crate::source::{Loaded, Text, load, load_geometry};

/// A question that is ready: the model, and the file for its table.
pub(super) struct Asked {
    loaded: Loaded,
    file: Option<OutputFile>,
}

/// An answer in the three ways that it can be given.
pub struct Answer {
    /// The name of the command.
    pub command: &'static str,
    /// The object of `--json`, but for the diagnostics.
    pub json: Value,
    /// The text that is printed otherwise.
    pub text: String,
    /// The contents of a table.
    pub table: Table,
}

/// Reads the model, after a look at where the table goes.
pub(super) fn asked(model: &ModelArgs, file: &TableArgs, nesting: usize) -> Result<Asked, Failure> {
    asked_of(model, file, || load(model, nesting))
}

/// As [`asked`], for a question about positions, which masses have no part in.
pub(super) fn asked_geometry(
    model: &ModelArgs,
    file: &TableArgs,
    nesting: usize,
) -> Result<Asked, Failure> {
    asked_of(model, file, || load_geometry(model, nesting))
}

fn asked_of(
    model: &ModelArgs,
    file: &TableArgs,
    load: impl FnOnce() -> Result<Loaded, Failure>,
) -> Result<Asked, Failure> {
    let planned = file.file.as_ref().map(|path| {
        OutputFile::plan(path, ("model", &[&model.model]), file.force, "nothing was computed")
    });
    let file = planned.transpose()?;
    Ok(Asked { loaded: load()?, file })
}

/// Faults of a question as a failure of the command.
pub(super) fn failed(source: &Text) -> impl Fn(AnalysisError) -> Failure + '_ {
    |error| source.rejected(error.diagnostics()).into()
}

impl Asked {
    /// Writes the table, then prints the answer.
    pub(super) fn answer(
        source: &Text,
        warnings: &[bksim::model::diagnostic::Diagnostic],
        file: Option<OutputFile>,
        answer: Answer,
        as_json: bool,
    ) -> Result<Status, Failure> {
        let Answer { command, json, text, table } = answer;
        let rows = format!("{} rows", table.rows.len());
        let content = file.map(|file| (file, table.csv().into_bytes(), rows));
        Self::told(source, warnings, content, (command, json, text), as_json)
    }

    /// Writes the content of a file, which a few words describe, then prints an answer as JSON or text.
    pub(super) fn told(
        source: &Text,
        warnings: &[bksim::model::diagnostic::Diagnostic],
        content: Option<(OutputFile, Vec<u8>, String)>,
        (command, mut json, mut text): (&'static str, Value, String),
        as_json: bool,
    ) -> Result<Status, Failure> {
        if let Some((file, bytes, summary)) = content {
            let mut written = file.create()?;
            written.write_all(&bytes).map_err(|e| Failure::writing(file.path(), &e))?;
            written.finish()?;
            json["output"] = file.path().display().to_string().into();
            text.extend([format!("\nwrote {}: {summary}", file.path().display())]);
        }
        if as_json {
            json["diagnostics"] = render::json_all(source, warnings);
            output::json(command, json)?;
        } else {
            render::print_all(source, warnings);
            output::text(&text)?;
        }
        Ok(Status::Done)
    }

    /// The parts, so that the model can be given away.
    pub(super) fn parts(
        self,
    ) -> (Text, bksim::model::Model, Vec<bksim::model::diagnostic::Diagnostic>, Option<OutputFile>)
    {
        let Self { loaded: Loaded { source, model, warnings }, file } = self;
        (source, model, warnings, file)
    }
}

/// A table as JSON: heads, and rows; what is not finite is null.
pub(super) fn table_json(table: &Table) -> Value {
    json!({ "columns": columns_json(&table.columns), "rows": table.rows })
}

/// Names and units.
pub(super) fn columns_json(columns: &[Column]) -> Value {
    columns.iter().map(|c| json!({ "name": c.name, "unit": c.unit })).collect()
}

/// Names with values and units, as JSON by name.
pub(super) fn pose_json(pose: &[(String, f64, &'static str)]) -> Value {
    let values = pose.iter().map(|(name, value, _)| (name.clone(), json!(value)));
    Value::Object(values.collect())
}

/// Rows of text under heads.
pub(super) fn lines(heads: &[&str], rows: Vec<Vec<String>>) -> String {
    let heads = heads.iter().map(|head| (*head).to_owned()).collect();
    table(&[vec![heads], rows].concat())
}

/// Numbers below this, in SI units and radians, are shown as zero.
const ROUNDING: f64 = 1e-13;

/// An angle in degrees, else the number with its unit.
pub(super) fn shown(value: f64, unit: &str) -> String {
    // What is left by rounding is no result.
    let value = if value.abs() < ROUNDING { 0.0 } else { value };
    if unit == "rad" {
        format!("{} deg", number(value.to_degrees()))
    } else if unit.is_empty() {
        number(value)
    } else {
        format!("{} {unit}", number(value))
    }
}
