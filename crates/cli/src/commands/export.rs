//! `bksim export`: channels of a log as a table.

use std::cell::OnceCell;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Write};
use std::path::Path;

use bksim::log::export::{Exported, to_csv_as};
use bksim::log::{LogError, LogReader, Record, Selection};
use bksim::model::file::{ShownUnit, ShownUnits};
use bksim::model::message::counted;
use bksim::sim::observable::Observables;
use serde_json::json;

use crate::args::Export;
use crate::commands::solve::RunFile;
use crate::exit::{Failure, Status};
use crate::origin::{file_of, has_headings, is_of_model};
use crate::output;
use crate::output_file::{OutputFile, Written};
use crate::render;
use crate::source::logged::{measured, mechanism as mechanism_of};
use crate::source::shown::shown_units;

/// A log that is open.
pub type OpenLog = LogReader<BufReader<File>>;

/// A format of tables.
#[derive(Clone, Copy, Debug)]
pub struct TableFormat {
    /// Ending of the format, lower case.
    pub name: &'static str,
    /// Writes the selected channels of a log.
    pub write: fn(OpenLog, &Asked, &mut BufWriter<Written>) -> Result<Exported, LogError>,
}

const CSV: TableFormat = TableFormat {
    name: "csv",
    write: |log, asked, out| {
        let Asked { selection, headings, units } = asked;
        let shown = |column: usize, value: f64| units[column].of_si(value);
        to_csv_as(log, selection, headings, &shown, out)
    },
};

/// The channels that are asked for, with their units.
#[derive(Clone, Debug)]
pub struct Asked {
    /// The channels.
    pub selection: Selection,
    /// Headings of a table, that of the time first: `A.angle [deg]` where a unit was asked for.
    headings: Vec<String>,
    /// Units of the columns, that of the time first.
    units: Vec<ShownUnit>,
}

impl Asked {
    /// True if every value is in SI.
    pub fn is_si(&self) -> bool {
        !self.headings.iter().any(|heading| heading.ends_with(']'))
    }
}

pub(crate) fn run(args: &Export, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let Some(path) = &args.output else { return to_stdout(args, as_json, nesting) };
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    if !ending.eq_ignore_ascii_case(CSV.name) {
        let message = format!("`{}` has no ending that names a table", path.display());
        return Err(Failure::usage(message, "end the name with .csv or .parquet"));
    }
    to_file(args, path, &CSV, (as_json, nesting))
}

/// A channel as it is asked for: `A.angle:deg`.
fn name_and_unit(asked: &str) -> Result<(&str, Option<ShownUnit>), Failure> {
    let Some((name, unit)) = asked.rsplit_once(':') else { return Ok((asked, None)) };
    let unit = ShownUnit::parse(unit).ok_or_else(|| {
        let message = format!("`{unit}` in `{asked}` is no unit");
        Failure::usage(message, "write a channel, a colon and a unit: `A.angle:deg`")
    })?;
    Ok((name, Some(unit)))
}

/// The log, and the channels of it that are asked for.
fn open(args: &Export, run: &RunFile) -> Result<(OpenLog, Asked), Failure> {
    let name = &run.name;
    let asked = args.channels.iter().map(|asked| name_and_unit(asked));
    let asked = asked.collect::<Result<Vec<_>, _>>()?;
    let names: Vec<String> = asked.iter().map(|(name, _)| (*name).to_owned()).collect();
    let file = File::open(run.log()).map_err(|e| Failure::reading(name, &e))?;
    let mut log = LogReader::open(BufReader::new(file)).map_err(|e| bad_log(name, &e))?;
    if let Some(measured) = measured(&run.log(), log.header(), &names, "exported")? {
        log = log.making(measured.making());
    }
    let header = log.header();
    let selection = if names.is_empty() {
        Selection::all(header)
    } else {
        Selection::new(header, &names).map_err(|e| bad_log(name, &e))?
    };

    // Units of all, and those of single channels before them.
    let asked_units = args.run.reading.shown(name);
    let all = shown_units(asked_units, &header.model_text, ShownUnits::default())?;
    let mut units = vec![all.of("s")];
    let mut headings = vec![heading("t", "s", &units[0])];
    for column in selection.columns() {
        let own = asked.iter().find_map(|(name, unit)| {
            let named = Selection::new(header, [name]).ok()?;
            let unit = unit.clone()?;
            named.columns().iter().any(|known| known.name == column.name).then_some(unit)
        });
        let unit = match own {
            Some(unit) if !unit.measures(&column.unit) => {
                let message =
                    format!("`{}` is in {}, not in {}", column.name, column.unit, unit.unit);
                return Err(Failure::usage(message, "give it a unit of the same quantity"));
            }
            Some(unit) => unit,
            None => all.of(&column.unit),
        };
        headings.push(heading(&column.name, &column.unit, &unit));
        units.push(unit);
    }
    Ok((log, Asked { selection, headings, units }))
}

/// The heading of a column; of one in its SI unit the name alone.
fn heading(name: &str, si: &str, shown: &ShownUnit) -> String {
    if shown.unit == si { name.to_owned() } else { format!("{name} [{}]", shown.unit) }
}

fn to_stdout(args: &Export, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let run = RunFile::open(&args.run, nesting, as_json)?;
    // Write over nothing that exists, least of all over the log.
    let (log, asked) = open(args, &run)?;
    if as_json {
        return Err(Failure::usage(
            "--json reports on a table, but there is none",
            "add `-o FILE`",
        ));
    }
    let mut stdout = Pipe { out: std::io::stdout().lock(), closed: false };
    let shown = |column: usize, value: f64| asked.units[column].of_si(value);
    let exported = to_csv_as(log, &asked.selection, &asked.headings, &shown, &mut stdout);
    let exported = exported.map_err(|e| match e {
        _ if stdout.closed => Failure::OutputClosed,
        LogError::Io(error) => Failure::stdout(&error),
        other => bad_log(&run.name, &other),
    })?;
    warn_if_cut(&run, &exported);
    Ok(run.status)
}

/// Exports to a file of this format.
///
/// # Errors
/// A log that cannot be read, channels it does not have, a file that cannot be written.
pub fn to_file(
    args: &Export,
    path: &Path,
    format: &TableFormat,
    (as_json, nesting): (bool, usize),
) -> Result<Status, Failure> {
    let run = RunFile::open(&args.run, nesting, as_json)?;
    let (log, asked) = open(args, &run)?;
    if format.name != CSV.name && !asked.is_si() {
        let message = format!("a table as {} is in SI units", format.name);
        return Err(Failure::usage(message, "leave out the units, or end the name with .csv"));
    }
    let may_replace = args.force || is_own_table(path, format, &log, &run);
    let inputs = ("log", &[run.name.as_path()][..]);
    let output = OutputFile::plan(path, inputs, may_replace, "nothing was written")?;

    // Write the table.
    let mut out = BufWriter::new(output.create()?);
    let exported = (format.write)(log, &asked, &mut out);
    let exported = exported.map_err(|e| bad_log(&run.name, &e))?;
    out.into_inner().map_err(|e| Failure::writing(path, e.error()))?.finish()?;
    warn_if_cut(&run, &exported);
    // Tell what was written.
    if as_json {
        let columns = asked.selection.columns().iter().zip(&asked.units[1..]);
        let columns = columns.map(|(c, unit)| json!({ "name": c.name, "unit": unit.unit }));
        output::json(
            "export",
            json!({
                "output": path.display().to_string(),
                "format": format.name,
                "rows": exported.n_rows,
                "complete": exported.end.is_some(),
                "columns": columns.collect::<Vec<_>>(),
            }),
        )?;
    } else {
        let n_columns = asked.selection.columns().len() + 1;
        output::report(&format!(
            "wrote {}: {}, {}",
            path.display(),
            counted(exported.n_rows, "row", "rows"),
            counted(n_columns, "column", "columns")
        ))?;
    }
    Ok(run.status)
}

/// True for a table that is there already and was made from this log, or from another one of its model.
fn is_own_table(path: &Path, format: &TableFormat, log: &OpenLog, run: &RunFile) -> bool {
    if format.name != CSV.name {
        return is_of_model(path, &file_of(log.header()));
    }
    let known = Selection::all(log.header());
    let is_logged = |name: &str| known.columns().iter().any(|column| column.name == name);
    // The model is derived for a table of what no channel has, alone.
    let mechanism = OnceCell::new();
    let is_measured = |name: &str| {
        let mechanism = mechanism.get_or_init(|| mechanism_of(&run.log(), "exported").ok());
        mechanism.as_ref().is_some_and(|of| Observables::named(&of.model, name).is_some())
    };
    has_headings(path, &|name| name == "t" || is_logged(name) || is_measured(name))
}

/// A stream that remembers whether its reader has gone, whatever the writers above make of it.
struct Pipe<W> {
    out: W,
    closed: bool,
}

impl<W: Write> Pipe<W> {
    fn note<T>(&mut self, result: io::Result<T>) -> io::Result<T> {
        result.inspect_err(|error| self.closed |= error.kind() == io::ErrorKind::BrokenPipe)
    }
}

impl<W: Write> Write for Pipe<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes);
        self.note(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        let flushed = self.out.flush();
        self.note(flushed)
    }
}

/// Time of the last sample that can be read.
fn last_time(path: &Path) -> Option<f64> {
    let mut log = LogReader::open(BufReader::new(File::open(path).ok()?)).ok()?;
    let mut last = None;
    while let Ok(Some(record)) = log.next_record() {
        if let Record::Sample { t, .. } = record {
            last = Some(t);
        }
    }
    last
}

fn bad_log(path: &Path, error: &LogError) -> Failure {
    let what = format!("cannot be exported: {error}");
    match error {
        LogError::UnknownChannel { .. } => Failure::usage(
            format!("`{}` {what}", path.display()),
            "the first line of `bksim export LOG` names all channels; without any, all are exported",
        ),
        LogError::Io(_) => Failure::file(path, what, None),
        _ => Failure::Input { path: path.to_owned(), what, help: None },
    }
}

fn warn_if_cut(run: &RunFile, exported: &Exported) {
    if exported.end.is_none() {
        let last =
            last_time(&run.log()).map_or_else(String::new, |t| format!(", the last at t = {t} s"));
        let message = format!(
            "`{}` was cut off before its run ended: {} read{last}",
            run.name.display(),
            counted(exported.n_rows, "row was", "rows were")
        );
        render::warning(&message);
    }
}
