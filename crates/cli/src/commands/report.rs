//! `bksim report`: the numbers of a run.

use std::io::Write;

use bksim::model::file::ShownUnits;
use bksim::report::{Report, json_of, pin_sheet, report, tables};

use crate::args::report::{Report as Arguments, ReportFormat};
use crate::exit::{Failure, Status};
use crate::origin::{is_of_model, may_be_own, stamped};
use crate::output::{self, number, table};
use crate::output_file::OutputFile;
use crate::progress::StopWish;
use crate::source::logged::unplayable;
use crate::source::motion::{Opened, Opening, open};
use crate::source::shown::shown_units;

pub(crate) fn run(args: &Arguments, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let path = &args.run.input;
    let format = format(args)?;
    let planned = args.output.as_deref().map(|output| {
        let may_be_replaced = args.force || may_be_own(output);
        OutputFile::plan(output, ("run", &[path.as_path()]), may_be_replaced, UNDONE)
    });
    let planned = planned.transpose()?;
    let stop = StopWish::watch().map_err(|e| Failure::reading(path, &e))?;
    let opening = Opening { cannot: "reported", nesting, as_json, stop: &stop };
    let Opened { mut playback, file: label, is_complete, diagnostics } =
        open(&args.run.model(), opening)?;
    if let Some(status) = stop.status() {
        return Ok(status);
    }
    let found = report(&mut playback).map_err(|e| unplayable(path, "reported", &e))?;
    let model = &playback.mechanism().model.name;

    // The report in each of its formats.
    let mut body = json_of(&found);
    body["model"] = model.as_str().into();
    body["complete"] = is_complete.into();
    let text = match format {
        Format::Json => format!("{body:#}"),
        Format::Words(_) | Format::Pins => {
            let model_text = &playback.log().header.model_text;
            let stated = ShownUnits::of_model(model_text);
            let units = shown_units(args.run.reading.shown(path), model_text, stated)?;
            match format {
                Format::Words(format) => in_words(format, model, &found, is_complete, &units),
                _ => pin_sheet(&found, &units).trim_end().to_owned(),
            }
        }
    };

    // Written, printed, or both as JSON.
    if let Some(file) = &planned {
        let may_be_replaced = args.force || is_of_model(file.path(), &label);
        file.check_again(may_be_replaced, UNDONE)?;
        let mut out = file.create()?;
        let bytes = stamped(file.path(), (text.clone() + "\n").into_bytes(), &label);
        out.write_all(&bytes).map_err(|e| Failure::writing(file.path(), &e))?;
        out.finish()?;
    }
    let written = planned.as_ref().map(|file| file.path().display().to_string());
    if as_json {
        body["output"] = written.into();
        body["diagnostics"] = diagnostics;
        output::json("report", body)?;
    } else {
        match written {
            Some(name) => output::report(&format!("wrote {name}"))?,
            None => output::text(&text)?,
        }
    }
    Ok(if is_complete { Status::Done } else { Status::StoppedEarly })
}

/// The words for a report that was not written.
const UNDONE: &str = "no report was written";

/// The ways to write a report.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Format {
    Words(ReportFormat),
    /// The sheet of the largest pin forces, as CSV.
    Pins,
    Json,
}

/// The format that is asked for, by the name of the file or in words.
fn format(args: &Arguments) -> Result<Format, Failure> {
    let ending = args.output.as_ref().and_then(|path| path.extension());
    let ending = ending.map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let named = match ending.as_deref() {
        Some("md") => Some(Format::Words(ReportFormat::Markdown)),
        Some("txt") => Some(Format::Words(ReportFormat::Text)),
        Some("json") => Some(Format::Json),
        Some("csv") => Some(Format::Pins),
        _ => None,
    };
    let asked = args.format.map(Format::Words);
    match (&args.output, named, asked) {
        (Some(path), None, _) => {
            let message = format!("`{}` has no ending that names a report", path.display());
            Err(Failure::usage(message, "end the name with .txt, .md or .json"))
        }
        (Some(path), Some(named), Some(asked)) if named != asked => {
            let message = format!("`{}` promises another format than --format", path.display());
            Err(Failure::usage(message, "leave out --format"))
        }
        _ => Ok(named.or(asked).unwrap_or(Format::Words(ReportFormat::Text))),
    }
}

/// The report as text or Markdown.
fn in_words(
    format: ReportFormat,
    model: &str,
    found: &Report,
    is_complete: bool,
    units: &ShownUnits,
) -> String {
    let sections = tables(found, units);
    let title = title(model, found, is_complete, units);
    match format {
        ReportFormat::Text => {
            let bodies = sections.iter().map(|(name, rows)| format!("{name}\n{}", table(rows)));
            std::iter::once(title).chain(bodies).collect::<Vec<_>>().join("\n\n")
        }
        ReportFormat::Markdown => {
            let title = format!("# {title}");
            let bodies = sections.iter().map(|(name, rows)| markdown(name, rows));
            std::iter::once(title).chain(bodies).collect::<Vec<_>>().join("\n\n")
        }
    }
}

fn title(model: &str, report: &Report, is_complete: bool, units: &ShownUnits) -> String {
    let time = units.of("s");
    let [first, last] = report.span.map(|t| number(time.of_si(t)));
    let cut = if is_complete { "" } else { ", ended early" };
    format!("{model}: t = {first} to {last} {}{cut}", time.unit)
}

/// A table of Markdown, its numbers to the right.
fn markdown(name: &str, rows: &[Vec<String>]) -> String {
    let line = |cells: &[String]| {
        let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
        format!("| {} |", cells.join(" | "))
    };
    let [head, body @ ..] = rows else { return format!("## {name}") };
    let rule: Vec<String> =
        (0..head.len()).map(|column| if column == 0 { "---" } else { "---:" }.to_owned()).collect();
    let lines = [line(head), line(&rule)].into_iter().chain(body.iter().map(|row| line(row)));
    format!("## {name}\n\n{}", lines.collect::<Vec<_>>().join("\n"))
}
