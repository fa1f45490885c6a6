//! Answers: as JSON, as a table in a file, as text.

use std::cell::RefCell;
use std::io::Write;
use std::path::Path;

use bksim::analysis::{AnalysisError, Column, Panels, Table};
use bksim::model::Model;
use bksim::model::file::ShownUnits;
use bksim::sim::observable::Observables;
use serde_json::{Value, json};

use crate::args::ModelArgs;
use crate::args::analysis::TableArgs;
use crate::exit::{Failure, Status};
use crate::origin::{headings, is_of_model, is_table, label_of, may_be_own, stamped};
use crate::output::{self, counted, number, table};
use crate::output_file::{OutputFile, check_ending, is_same_file};
use crate::render;
use crate::source::shown::shown_units;
use crate::source::{Loaded, Text, load, load_geometry};

/// A question that is ready: the model, and the file for its table.
pub(super) struct Asked {
    loaded: Loaded,
    file: Option<AnswerFile>,
}

/// The file of an answer: a new one, or one in the place of an earlier answer about the same model.
#[derive(Debug)]
pub(super) struct AnswerFile {
    file: OutputFile,
    /// True where anything may be replaced.
    force: bool,
    /// The file of the model, as results name it.
    label: String,
    /// Headings of the table that is there which the model has no name for.
    unknown: Vec<String>,
    /// Units of a table: SI unless others are asked for.
    units: ShownUnits,
}

thread_local! {
    /// Units of the text of the answer that this thread makes: asked for, else the model's `[units]`.
    static SHOWN: RefCell<ShownUnits> = RefCell::default();
}

/// Units of the text of an answer.
pub(super) fn text_units() -> ShownUnits {
    SHOWN.with_borrow(Clone::clone)
}

/// The words for a file that was not written.
const UNDONE: &str = "nothing was computed";

impl AnswerFile {
    /// Refuses a file that is no answer about any model; `inputs` are the files that are read.
    pub(super) fn plan(path: &Path, force: bool, inputs: &[&Path]) -> Result<OutputFile, Failure> {
        OutputFile::plan(path, ("model", inputs), force || may_be_own(path), UNDONE)
    }

    /// A planned file, for an answer about this model.
    pub(super) fn about(loaded: &Loaded, file: OutputFile, force: bool) -> Self {
        let (model, units) = (&loaded.model, ShownUnits::default());
        let is_unknown = |name: &String| Observables::named(model, name).is_none();
        let unknown = headings(file.path()).into_iter().filter(is_unknown).collect();
        Self { file, force, label: label_of(&loaded.source.path), unknown, units }
    }

    /// A table as the content of the file, in the units that are asked for.
    pub(super) fn csv(&self, table: &Table) -> Vec<u8> {
        let units: Vec<_> =
            table.columns.iter().map(|column| self.units.of(&column.unit)).collect();
        let columns = table.columns.iter().zip(&units).map(|(column, shown)| {
            if shown.unit == column.unit {
                column.clone()
            } else {
                Column::new(format!("{} [{}]", column.name, shown.unit), shown.unit.clone())
            }
        });
        let row = |row: &Vec<f64>| row.iter().zip(&units).map(|(x, unit)| unit.of_si(*x)).collect();
        let rows = table.rows.iter().map(row).collect();
        Table { columns: columns.collect(), rows }.csv().into_bytes()
    }

    /// Path of the file.
    pub(super) fn path(&self) -> &Path {
        self.file.path()
    }

    /// Writes the content, with a mark where its format has one.
    fn write(&self, bytes: Vec<u8>) -> Result<(), Failure> {
        let path = self.path();
        // The first line of a table; of anything else, nothing that could be a heading there.
        let first = bytes.split(|&byte| byte == b'\n').next().unwrap_or_default();
        let first = String::from_utf8_lossy(first);
        let is_own_heading = |name: &String| {
            first.split(',').any(|own| own.split(" [").next() == Some(name.as_str()))
        };
        let is_earlier = || is_table(path) && self.unknown.iter().all(is_own_heading);
        let may_be_replaced = self.force || is_of_model(path, &self.label) || is_earlier();
        self.file.check_again(may_be_replaced, "nothing was written")?;
        let mut written = self.file.create()?;
        let bytes = stamped(path, bytes, &self.label);
        written.write_all(&bytes).map_err(|e| Failure::writing(path, &e))?;
        written.finish()
    }
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

/// An answer drawn as the contents of a picture; the title is the name of the model.
pub type Draw<'a, T = Panels> = &'a dyn Fn(&str, &T) -> Result<Vec<u8>, Failure>;

/// Reads the model, after a look at where the table goes.
pub(super) fn asked(model: &ModelArgs, file: &TableArgs, nesting: usize) -> Result<Asked, Failure> {
    check_table(file)?;
    asked_of(model, file, || load(model, nesting))
}

/// Refuses a name that promises another format than that of tables.
fn check_table(file: &TableArgs) -> Result<(), Failure> {
    file.file.as_deref().map_or(Ok(()), |path| check_ending(path, &["csv"]))
}

/// Refuses a table in the place of a file that is read.
pub(super) fn refuse_input(file: &TableArgs, input: &Path) -> Result<(), Failure> {
    let path = file.file.as_deref().filter(|path| is_same_file(path, input));
    let what = || format!("is read by this command and would be overwritten; {UNDONE}");
    let help = || Some("name another file with -o".to_owned());
    path.map_or(Ok(()), |path| Err(Failure::file(path, what(), help())))
}

/// Answer of [`asked`] that may be drawn in the file.
pub(super) fn asked_drawn(
    model: &ModelArgs,
    file: &TableArgs,
    is_drawn: bool,
    load: impl FnOnce() -> Result<Loaded, Failure>,
) -> Result<Asked, Failure> {
    if !is_drawn {
        check_table(file)?;
    }
    asked_of(model, file, load)
}

/// Answer of [`asked`] to a question about positions, which masses have no part in.
pub(super) fn asked_geometry(
    model: &ModelArgs,
    file: &TableArgs,
    nesting: usize,
) -> Result<Asked, Failure> {
    check_table(file)?;
    asked_of(model, file, || load_geometry(model, nesting))
}

fn asked_of(
    model: &ModelArgs,
    file: &TableArgs,
    load: impl FnOnce() -> Result<Loaded, Failure>,
) -> Result<Asked, Failure> {
    let planned = file.file.as_ref();
    let planned = planned.map(|path| AnswerFile::plan(path, file.force, &[&model.model]));
    let planned = planned.transpose()?;
    let loaded = load()?;
    let (asked, text) = (model.drawing.shown(&model.model), &loaded.source.text);
    let units = shown_units(asked, text, ShownUnits::default())?;
    SHOWN.set(if asked.is_some() { units.clone() } else { ShownUnits::of_model(text) });
    let about = |planned| AnswerFile::about(&loaded, planned, file.force);
    let file = planned.map(about).map(|file| AnswerFile { units, ..file });
    Ok(Asked { loaded, file })
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
        file: Option<AnswerFile>,
        answer: Answer,
        as_json: bool,
    ) -> Result<Status, Failure> {
        Self::drawn(source, warnings, (file, None), answer, as_json)
    }

    /// Answer of [`Asked::answer`], with a picture in place of the table where there is one.
    pub(super) fn drawn(
        source: &Text,
        warnings: &[bksim::model::diagnostic::Diagnostic],
        (file, picture): (Option<AnswerFile>, Option<(Vec<u8>, String)>),
        answer: Answer,
        as_json: bool,
    ) -> Result<Status, Failure> {
        let Answer { command, json, text, table } = answer;
        let content = file.map(|file| {
            let summary = || counted(table.rows.len(), "row", "rows");
            let (bytes, what) = picture.unwrap_or_else(|| (file.csv(&table), summary()));
            (file, bytes, what)
        });
        Self::told(source, warnings, content, (command, json, text), as_json)
    }

    /// Writes the content of a file, which a few words describe, then prints an answer as JSON or text.
    pub(super) fn told(
        source: &Text,
        warnings: &[bksim::model::diagnostic::Diagnostic],
        content: Option<(AnswerFile, Vec<u8>, String)>,
        (command, mut json, mut text): (&'static str, Value, String),
        as_json: bool,
    ) -> Result<Status, Failure> {
        let is_written = content.is_some();
        if let Some((file, bytes, summary)) = content {
            file.write(bytes)?;
            json["output"] = file.path().display().to_string().into();
            text.extend([format!("\nwrote {}: {summary}", file.path().display())]);
        }
        if as_json {
            json["diagnostics"] = render::json_all(source, warnings);
            output::json(command, json)?;
        } else {
            render::print_all(source, warnings);
            // What a file holds need not be printed as well.
            if is_written { output::report(&text)? } else { output::text(&text)? }
        }
        Ok(Status::Done)
    }

    /// The parts, so that the model can be given away.
    pub(super) fn parts(
        self,
    ) -> (Text, Model, Vec<bksim::model::diagnostic::Diagnostic>, Option<AnswerFile>) {
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

/// The number with its unit, in the [units of the text](text_units).
pub(super) fn shown(value: f64, unit: &str) -> String {
    // What is left by rounding is no result.
    let value = if value.abs() < ROUNDING { 0.0 } else { value };
    let (value, unit) = in_units(value, unit, &text_units());
    if unit.is_empty() { number(value) } else { format!("{} {unit}", number(value)) }
}

/// A value in SI in these units; an angle in degrees where there is none for it.
pub(super) fn in_units(value: f64, unit: &str, units: &ShownUnits) -> (f64, String) {
    let own = units.of(unit);
    if own.unit == "rad" {
        return (value.to_degrees(), "deg".to_owned());
    }
    (own.of_si(value), own.unit)
}

/// The note about stops and contacts that an answer about positions does not keep to.
pub(super) fn beyond(names: &[String]) -> String {
    match names {
        [] => String::new(),
        names => format!("\n  as if there were none of these: {}", names.join(", ")),
    }
}
