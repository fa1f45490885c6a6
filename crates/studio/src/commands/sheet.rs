//! `bksim sheet`: the largest pin forces over a motion and over all load cases, to print, to calculate with, to hand on.

mod drawing;
mod loads;
mod page;
mod workbook;

use std::io::Write;
use std::path::Path;

use bksim::model::file::ShownUnits;
use bksim::report::{
    PinTable, Report, angle_unit, json_of, pin_table, report, six_digits, worst_cases,
};
use bksim::sim::run::Unreplayed;
use bksim::sim::wrenches::{ContactForces, WrenchAt};
use bksim_cli::args::ModelArgs;
use bksim_cli::args::sheet::Sheet;
use bksim_cli::exit::{Failure, Status};
use bksim_cli::origin::{is_of_model, may_be_own, stamped};
use bksim_cli::output::{self, number, table};
use bksim_cli::output_file::{OutputFile, check_ending};
use bksim_cli::progress::StopWish;
use bksim_cli::source::load;
use bksim_cli::source::logged::{is_log, unplayable};
use bksim_cli::source::motion::{Opened, Opening, open};
use bksim_cli::source::shown::shown_units;
use bksim_view::show::Show;
use serde_json::{Value, json};

const UNDONE: &str = "no sheet was written";
const ENDINGS: [&str; 6] = ["html", "pdf", "xlsx", "csv", "inp", "json"];

/// The run of a load case.
struct CaseRun {
    /// Name of the case; empty of a model that has none.
    name: String,
    title: Option<String>,
    /// Changes of the case, as written.
    changes: Vec<(String, String)>,
    report: Report,
    show: Show,
    contacts: Option<ContactForces>,
    is_complete: bool,
}

/// Reactions of all joints, then those of contacts, and the points where contacts press.
type Bearings = (Vec<[f64; 6]>, Vec<[f64; 3]>);

impl CaseRun {
    /// Reactions at an instant.
    fn bearings(&mut self, t: f64) -> Result<Bearings, Unreplayed> {
        self.show.seek(t)?;
        let playback = self.show.playback();
        let contacts = self.contacts.as_mut();
        let contacts = contacts.map(|of| of.at(playback.sample(), playback.modes()));
        let contacts = contacts.unwrap_or_default();
        let of_contacts = contacts.iter().map(WrenchAt::six);
        let all = playback.sample().reactions.iter().copied().chain(of_contacts).collect();
        Ok((all, contacts.iter().map(|contact| contact.point).collect()))
    }
}

/// The runs of all cases, and in which units they are shown.
struct Runs {
    model: String,
    cases: Vec<CaseRun>,
    units: ShownUnits,
}

impl Runs {
    fn named(&self) -> Vec<(&str, &Report)> {
        self.cases.iter().map(|case| (case.name.as_str(), &case.report)).collect()
    }

    /// For each joint the case in which its force is largest.
    fn worst(&self) -> Vec<usize> {
        worst_cases(&self.cases.iter().map(|case| &case.report).collect::<Vec<_>>())
    }

    /// The largest force of each joint over all cases.
    fn largest(&self) -> PinTable {
        let all = pin_table(&self.named(), &self.units);
        let n_joints = self.worst().len();
        let place = |(joint, case): (usize, usize)| all.rows[case * n_joints + joint].clone();
        PinTable { rows: self.worst().into_iter().enumerate().map(place).collect(), ..all }
    }

    /// The sheet as an object.
    fn json(&self) -> Value {
        let case = |case: &CaseRun| {
            let mut body = json_of(&case.report);
            body["name"] = case.name.as_str().into();
            body["title"] = case.title.as_deref().into();
            body["set"] = case.changes.iter().map(|(name, value)| json!([name, value])).collect();
            body["complete"] = case.is_complete.into();
            body
        };
        let reports: Vec<Value> = self.cases.iter().map(case).collect();
        let pins = self.worst().into_iter().enumerate().map(|(joint, worst)| {
            let mut pin = reports[worst]["reactions"][joint].clone();
            pin["case"] = self.cases[worst].name.as_str().into();
            pin
        });
        json!({ "model": self.model, "pins": pins.collect::<Vec<_>>(), "cases": reports })
    }
}

/// A table for people: headings and cells as texts, columns that are zero throughout left out, angles within half a turn
/// where they are beyond a whole one.
fn shown(found: &PinTable, units: &ShownUnits) -> Vec<Vec<String>> {
    let angle = angle_unit(units);
    let turn = angle.of_si(std::f64::consts::TAU);
    let is_angle = |k: usize| found.heads[k].ends_with(&format!("[{}]", angle.unit));
    let is_empty =
        |k: usize| found.rows.iter().all(|row| matches!(row[k].text().as_str(), "0" | ""));
    let is_component = |head: &str| {
        ["fx", "fy", "fz", "mx", "my", "mz", "direction"].iter().any(|name| head.starts_with(name))
    };
    let kept: Vec<usize> = (0..found.heads.len())
        .filter(|&k| !(is_component(&found.heads[k]) && is_empty(k)))
        .collect();
    let cell = |row: &Vec<bksim::report::Cell>, k: usize| match &row[k] {
        bksim::report::Cell::Number(x) if x.abs() > turn && is_angle(k) => {
            number(six_digits(x - turn * (x / turn).round(), turn))
        }
        bksim::report::Cell::Number(x) if !x.is_nan() => number(*x),
        other => other.text(),
    };
    let heads = kept.iter().map(|&k| found.heads[k].clone()).collect();
    let rows = found.rows.iter().map(|row| kept.iter().map(|&k| cell(row, k)).collect());
    std::iter::once(heads).chain(rows).collect()
}

/// The load cases in a table; empty where the model has none.
fn case_table(runs: &Runs) -> Vec<Vec<String>> {
    if runs.cases.iter().all(|case| case.name.is_empty()) {
        return Vec::new();
    }
    let row = |case: &CaseRun| {
        let changes: Vec<String> =
            case.changes.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        vec![case.name.clone(), case.title.clone().unwrap_or_default(), changes.join(", ")]
    };
    let heads = ["case", "title", "changes"].map(str::to_owned).to_vec();
    std::iter::once(heads).chain(runs.cases.iter().map(row)).collect()
}

/// Remarks on the tables: runs that ended early.
fn remarks(runs: &Runs) -> Vec<String> {
    let early = runs.cases.iter().filter(|case| !case.is_complete).map(|case| {
        let t = runs.units.of("s");
        let end = format!("{} {}", number(t.of_si(case.report.span[1])), t.unit);
        if case.name.is_empty() {
            return page::said(
                "The run ended early, at t = {}: later forces are not in this sheet.",
                &[&end],
            );
        }
        page::said(
            "The run of load case {} ended early, at t = {}: later forces are not in this sheet.",
            &[&case.name, &end],
        )
    });
    early.collect()
}

pub(crate) fn run(args: &Sheet, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let input = &args.run.input;
    let planned = args.output.as_deref().map(|path| {
        check_ending(path, &ENDINGS)?;
        let may_be_replaced = args.force || may_be_own(path);
        OutputFile::plan(path, ("run", &[input.as_path()]), may_be_replaced, UNDONE)
    });
    let planned = planned.transpose()?;
    let ending = args.output.as_deref().and_then(Path::extension).and_then(|e| e.to_str());
    let is_loads = ending == Some("inp");
    if !is_loads && (args.body.is_some() || !args.at.is_empty()) {
        let message = "--body and --at are for loads of CalculiX";
        return Err(Failure::usage(message, "end the name of the file with .inp"));
    }
    let stop = StopWish::watch().map_err(|e| Failure::reading(input, &e))?;
    let found = runs(args, (as_json, nesting), &stop)?;
    let Found { mut runs, label, diagnostics } = found;
    if let Some(status) = stop.status() {
        return Ok(status);
    }

    // The sheet in the format that is asked for.
    let undrawn = |error: &dyn std::fmt::Display| {
        Failure::file(
            args.output.as_deref().unwrap_or(input),
            format!("cannot be made: {error}"),
            None,
        )
    };
    let bytes = match ending {
        Some("csv") => pin_table(&runs.named(), &runs.units).csv().into_bytes(),
        Some("json") => format!("{:#}\n", runs.json()).into_bytes(),
        Some("xlsx") => workbook::of(&mut runs).map_err(|error| undrawn(&error))?,
        Some("inp") => loads::of(&mut runs, args)?.into_bytes(),
        Some("html") => {
            page::of(&mut runs).map_err(|error| undrawn(&error))?.to_html().into_bytes()
        }
        Some("pdf") => {
            let page = page::of(&mut runs).map_err(|error| undrawn(&error))?;
            page.to_pdf().map_err(|error| undrawn(&error))?
        }
        _ => Vec::new(),
    };
    if let Some(file) = &planned {
        let may_be_replaced = args.force || is_of_model(file.path(), &label);
        file.check_again(may_be_replaced, UNDONE)?;
        let mut out = file.create()?;
        let bytes = stamped(file.path(), bytes, &label);
        out.write_all(&bytes).map_err(|e| Failure::writing(file.path(), &e))?;
        out.finish()?;
    }
    let written = planned.as_ref().map(|file| file.path().display().to_string());
    if as_json {
        let mut body = runs.json();
        body["output"] = written.into();
        body["diagnostics"] = diagnostics;
        output::json("sheet", body)?;
    } else {
        match written {
            Some(name) => output::report(&format!("wrote {name}"))?,
            None => output::text(&in_words(&runs))?,
        }
    }
    Ok(Status::Done)
}

fn in_words(runs: &Runs) -> String {
    let cases = case_table(runs);
    let mut parts = vec![format!("{}: largest pin forces", runs.model)];
    if !cases.is_empty() {
        parts.push(format!("Load cases\n{}", table(&cases)));
    }
    parts.push(format!("Largest forces\n{}", table(&shown(&runs.largest(), &runs.units))));
    parts.extend(remarks(runs));
    parts.join("\n\n")
}

/// The runs with the label of their model's file and the diagnostics of the first.
struct Found {
    runs: Runs,
    label: String,
    diagnostics: Value,
}

/// Solves the model once, or for each of its cases.
fn runs(
    args: &Sheet,
    (as_json, nesting): (bool, usize),
    stop: &StopWish,
) -> Result<Found, Failure> {
    let path = &args.run.input;
    let model = args.run.model();
    let known = if is_log(path) { Vec::new() } else { load(&model, nesting)?.model.cases };
    let chosen = model.set.case().map(str::to_owned);
    let of_model = [(String::new(), None, Vec::new())];
    let all: Vec<_> = known.into_iter().map(|case| (case.name, case.title, case.changes)).collect();
    let wanted: Vec<_> = match chosen {
        Some(name) => all.into_iter().filter(|(case, ..)| *case == name).collect(),
        None if all.is_empty() => of_model.to_vec(),
        None => all,
    };
    let mut cases = Vec::new();
    let mut first = None;
    for (name, title, changes) in wanted {
        let is_chosen = model.set.case().is_some() || name.is_empty();
        let set = if is_chosen { model.set.clone() } else { model.set.of_case(&name) };
        let drawing = model.drawing.clone();
        let own = ModelArgs { model: model.model.clone(), set, drawing };
        let opening = Opening { cannot: "reported", nesting, as_json, stop };
        let Opened { mut playback, file, is_complete, diagnostics } = open(&own, opening)?;
        let report = report(&mut playback).map_err(|e| unplayable(path, "reported", &e))?;
        if first.is_none() {
            let header = &playback.log().header;
            let stated = ShownUnits::of_model(&header.model_text);
            let units = shown_units(args.run.reading.shown(path), &header.model_text, stated)?;
            first = Some((playback.mechanism().model.name.clone(), units, file, diagnostics));
        }
        let contacts = ContactForces::compile(playback.mechanism());
        let contacts = contacts.map_err(|e| unplayable(path, "reported", &e))?;
        let show = Show::new(playback);
        cases.push(CaseRun { name, title, changes, report, show, contacts, is_complete });
    }
    let (model, units, label, diagnostics) = first.expect("there is a case");
    Ok(Found { runs: Runs { model, cases, units }, label, diagnostics })
}
