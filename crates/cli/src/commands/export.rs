//! `bksim export`: channels of a log as a table.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Write};
use std::path::Path;

use bksim::log::export::{Exported, to_csv};
use bksim::log::{LogError, LogReader, Record, Selection};
use serde_json::json;

use crate::args::Export;
use crate::exit::{Failure, Status};
use crate::origin::{has_columns, is_of_model};
use crate::output;
use crate::output_file::{OutputFile, Written};
use crate::render;
use crate::source::logged::measured;

/// A log that is open.
pub type OpenLog = LogReader<BufReader<File>>;

/// A format of tables.
#[derive(Clone, Copy, Debug)]
pub struct TableFormat {
    /// Its ending, lower case.
    pub name: &'static str,
    /// Writes the selected channels of a log.
    pub write: fn(OpenLog, &Selection, &mut BufWriter<Written>) -> Result<Exported, LogError>,
}

const CSV: TableFormat =
    TableFormat { name: "csv", write: |log, selection, out| to_csv(log, selection, out) };

pub(crate) fn run(args: &Export, as_json: bool) -> Result<Status, Failure> {
    let Some(path) = &args.output else { return to_stdout(args, as_json) };
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    if !ending.eq_ignore_ascii_case(CSV.name) {
        let message = format!("`{}` has no ending that names a table", path.display());
        return Err(Failure::usage(message, "end the name with .csv or .parquet"));
    }
    to_file(args, path, &CSV, as_json)
}

/// The log, and the channels of it that are asked for.
fn open(args: &Export) -> Result<(OpenLog, Selection), Failure> {
    let file = File::open(&args.log).map_err(|e| Failure::reading(&args.log, &e))?;
    let mut log = LogReader::open(BufReader::new(file)).map_err(|e| bad_log(&args.log, &e))?;
    if let Some(measured) = measured(&args.log, log.header(), &args.channels, "exported")? {
        log = log.making(measured.making());
    }
    let selection = if args.channels.is_empty() {
        Selection::all(log.header())
    } else {
        Selection::new(log.header(), &args.channels).map_err(|e| bad_log(&args.log, &e))?
    };
    Ok((log, selection))
}

fn to_stdout(args: &Export, as_json: bool) -> Result<Status, Failure> {
    // Write over nothing that exists, least of all over the log.
    let (log, selection) = open(args)?;
    if as_json {
        return Err(Failure::usage(
            "--json reports on a table, but there is none",
            "add `-o FILE`",
        ));
    }
    let mut stdout = Pipe { out: std::io::stdout().lock(), closed: false };
    let exported = to_csv(log, &selection, &mut stdout).map_err(|e| match e {
        _ if stdout.closed => Failure::OutputClosed,
        LogError::Io(error) => Failure::stdout(&error),
        other => bad_log(&args.log, &other),
    })?;
    warn_if_cut(args, &exported);
    Ok(Status::Done)
}

/// Exports to a file of this format.
///
/// # Errors
/// A log that cannot be read, channels it does not have, a file that cannot be written.
pub fn to_file(
    args: &Export,
    path: &Path,
    format: &TableFormat,
    as_json: bool,
) -> Result<Status, Failure> {
    let (log, selection) = open(args)?;
    let may_replace = args.force || is_own_table(path, format, &log);
    let output =
        OutputFile::plan(path, ("log", &[args.log.as_path()]), may_replace, "nothing was written")?;

    // Write the table.
    let mut out = BufWriter::new(output.create()?);
    let exported = (format.write)(log, &selection, &mut out);
    let exported = exported.map_err(|e| bad_log(&args.log, &e))?;
    out.into_inner().map_err(|e| Failure::writing(path, e.error()))?.finish()?;
    warn_if_cut(args, &exported);
    // Tell what was written.
    if as_json {
        let columns = selection.columns().iter();
        let columns = columns.map(|c| json!({ "name": c.name, "unit": c.unit }));
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
        let n_columns = selection.columns().len() + 1;
        output::text(&format!(
            "wrote {}: {} rows, {n_columns} columns",
            path.display(),
            exported.n_rows
        ))?;
    }
    Ok(Status::Done)
}

/// True for a table that is there already and was made from this log, or from another one of its model.
fn is_own_table(path: &Path, format: &TableFormat, log: &OpenLog) -> bool {
    if format.name != CSV.name {
        return is_of_model(path, &log.header().model_name);
    }
    let known = Selection::all(log.header());
    has_columns(path, "t", &known.columns().iter().map(|column| column.name.as_str()))
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

fn warn_if_cut(args: &Export, exported: &Exported) {
    if exported.end.is_none() {
        let last =
            last_time(&args.log).map_or_else(String::new, |t| format!(", the last at t = {t} s"));
        let message = format!(
            "`{}` was cut off before its run ended: {} rows were read{last}",
            args.log.display(),
            exported.n_rows
        );
        render::warning(&message);
    }
}
