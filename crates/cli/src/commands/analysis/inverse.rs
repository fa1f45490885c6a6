//! `bksim inverse`: the efforts of a motion.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use bksim::analysis::{
    Actuators, AnalysisError, Duty, EffortLimit, Inverse, LimitUse, Load, Motion, MotorCurve,
    Range, compliances, inverse, position,
};
use bksim::log::export::to_csv_as;
use bksim::log::{LogReader, Selection};
use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{Limits, Source, WrittenUnit, suggest};
use bksim::model::message::short;
use bksim::model::{Measure, Model};
use serde_json::{Value, json};

use super::answer::{
    Answer, Asked, Draw, asked_drawn, failed, lines, refuse_input, shown, table_json, text_units,
};
use crate::args::analysis::Inverse as Args;
use crate::exit::{Failure, Status};
use crate::output::{counted, number};
use crate::source::logged::{is_log, measured};
use crate::source::{Text, load, read_bytes};
use crate::waiting::waiting;

/// Number of times where none is given.
const N_TIMES: usize = 101;

/// Asks, writes the table or what `draw` makes of the efforts, and prints the answer.
///
/// # Errors
/// [`Failure`] when there is no answer, or the file cannot be written.
pub fn run(
    args: &Args,
    draw: Option<Draw<'_, Inverse>>,
    as_json: bool,
    nesting: usize,
) -> Result<Status, Failure> {
    for path in args.motion.iter().filter_map(|(_, motion)| motion.strip_prefix('@')) {
        refuse_input(&args.table, Path::new(path))?;
    }
    let (source, mut model, mut warnings, file) =
        asked_drawn(&args.model, &args.table, draw.is_some(), || load(&args.model, nesting))?
            .parts();
    let name = model.name.clone();
    let failed = failed(&source);
    model.compliances = compliances(&model, &args.compliance.compliance).map_err(&failed)?;
    let written = Source {
        overrides: &args.model.set,
        limits: Limits { nesting },
        ..Source::new(&source.text, &name)
    };
    let motions: Vec<Given> = (args.motion.iter())
        .map(|motion| read_motion((&source, &written), &model, motion, args.smoothing))
        .collect::<Result<_, _>>()?;
    let mut times = times(&model, args.times.as_deref()).map_err(&failed)?;
    // A log or a table has times of its own.
    for logged in motions.iter().filter_map(|given| given.times.filter(|_| args.times.is_none())) {
        keep_within(&mut times, &logged);
    }
    let motions: Vec<Motion> = motions.into_iter().map(|given| given.motion).collect();
    warnings.extend(motions.iter().filter_map(like_degrees));
    warnings.extend(motions.iter().filter_map(|motion| motion.replaced_drive(&model)));
    let actuators = Actuators {
        named: args.actuator.clone(),
        limits: limits(&args.limit).map_err(&failed)?,
        curves: read_curves(&source, &model, &args.curve)?,
    };
    let found = || inverse(model, &motions, &times, &actuators);
    let found = waiting("computing efforts", found).map_err(&failed)?;
    let what = "efforts over speeds".to_owned();
    let picture = draw.map(|draw| Ok::<_, Failure>((draw(&name, &found)?, what))).transpose()?;
    Asked::drawn(&source, &warnings, (file, picture), told(&name, &found), as_json)
}

/// The warning of a motion whose amplitude looks like degrees.
pub fn like_degrees(motion: &Motion) -> Option<Diagnostic> {
    let value = motion.amplitude?;
    let turns = value / std::f64::consts::TAU;
    let name = &motion.name;
    let message = format!("{value} in the motion of `{name}` is {value} rad = {turns:.1} turns");
    let fault = Diagnostic::warning(bksim::model::file::code::LOOKS_LIKE_DEGREES, message);
    Some(fault.help(format!(
        "write `{}*…` in place of `{value}*…`, or `{value} rad` and a unit of each rate if it is right",
        short(value.to_radians())
    )))
}

/// Limits of efforts, each by name and size.
///
/// # Errors
/// [`AnalysisError::BadRange`] for what is no effort.
pub fn limits(written: &[(String, String)]) -> Result<Vec<EffortLimit>, AnalysisError> {
    written.iter().map(|(name, limit)| EffortLimit::parse(name, limit)).collect()
}

/// Curves of motors from tables of speeds and efforts: of the model by name, or of files.
fn read_curves(
    source: &Text,
    model: &Model,
    written: &[(String, String)],
) -> Result<Vec<MotorCurve>, Failure> {
    let read = |(name, table): &(String, String)| {
        let Some(path) = table.strip_prefix('@') else {
            return MotorCurve::of_table(model, name, table).map_err(failed(source));
        };
        let units = motor_units(model, name);
        let text = table_text(Path::new(path))?;
        let table = (Path::new(path), text.as_str());
        let (speeds, efforts) = read_pairs(table, [0, 1], ["speed", "effort"], units)?;
        let points = speeds.into_iter().zip(efforts).map(|(speed, effort)| [speed, effort]);
        MotorCurve::new(name, points.collect()).map_err(failed(source))
    };
    written.iter().map(read).collect()
}

/// Units of the speed and effort of an actuator.
fn motor_units(model: &Model, name: &str) -> [&'static str; 2] {
    let named = [format!("{name}.angle"), format!("{name}.position"), name.to_owned()];
    let of_drive = model.drives.iter().find(|drive| drive.name == name);
    let of_drive = of_drive.map(|d| Measure::JointPosition(d.joint, d.motion_idx));
    let measure = of_drive.or_else(|| named.iter().find_map(|name| position(model, name).ok()));
    match measure.map(|measure| measure.unit(model)) {
        Some("m") => ["m/s", "N"],
        _ => ["rad/s", "N*m"],
    }
}

/// Reads times; those of the model's solution unless given.
///
/// # Errors
/// [`AnalysisError::BadRange`] for what are none.
pub fn times(model: &Model, times: Option<&str>) -> Result<Range, AnalysisError> {
    match times {
        Some(times) => Range::parse(times, "s"),
        None => Ok(Range { from: model.solve.t_start, to: model.solve.t_end, n: N_TIMES }),
    }
}

/// Leaves out times before the first and after the last of those that are known.
pub fn keep_within(times: &mut Range, known: &[f64]) {
    if let (Some(first), Some(last)) = (known.first(), known.last()) {
        (times.from, times.to) = (times.from.max(*first), times.to.min(*last));
    }
}

/// The answer about a model of this name.
pub fn told(name: &str, found: &Inverse) -> Answer {
    let units = text_units();
    let row = |load: &Load| {
        let [peak, rms] = [load.peak, load.rms].map(|value| units.of(&load.unit).of_si(value));
        vec![
            load.name.clone(),
            number(peak),
            shown(load.at, "s"),
            number(rms),
            units.of(&load.unit).unit,
        ]
    };
    // What is left by rounding of forces that cancel is no load.
    let largest = found.loads.iter().fold(0.0, |most: f64, load| most.max(load.peak.abs()));
    let is_shown = |load: &&Load| load.peak.abs() > 1e-12 * largest;
    let rows = found.loads.iter().filter(is_shown).map(row).collect();
    let text = format!(
        "{name}: efforts at {}\n\n{}",
        counted(found.table.rows.len(), "time", "times"),
        lines(&["", "peak", "at", "rms", "unit"], rows)
    ) + &remarks(found);
    let loads = found.loads.iter().map(|load| {
        json!({
            "name": load.name,
            "unit": load.unit,
            "peak": load.peak,
            "at": load.at,
            "rms": load.rms,
        })
    });
    let json = json!({
        "table": table_json(&found.table),
        "loads": loads.collect::<Vec<_>>(),
        "inner_forces": found.n_inner,
        "missing": found.missing,
        "open": found.open,
        "impossible": found.impossible,
        "limits": found.limits.iter().map(limit_json).collect::<Vec<_>>(),
        "controllers": found.controllers,
        "duties": found.duties.iter().map(duty_json).collect::<Vec<_>>(),
    });
    Answer { command: "inverse", json, text, table: found.table.clone() }
}

/// All there is to say besides peaks and means, a line each.
fn remarks(found: &Inverse) -> String {
    let mut all = Vec::new();
    if found.n_inner > 0 {
        all.push(format!(
            "inner forces: {} of changing efforts without moving anything; the efforts are the smallest, \
             `effort_min` and `effort_max` in the table are the ends of their ranges",
            counted(found.n_inner, "way", "ways")
        ));
    }
    if !found.open.is_empty() {
        let names = found.open.join(", ");
        all.push(format!(
            "friction at rest and stops that bear leave efforts open: {names}; the efforts are the smallest, \
             `effort_min` and `effort_max` in the table are the ends of their ranges"
        ));
    }
    if !found.missing.is_empty() {
        let names = found.missing.join(", ");
        all.push(format!(
            "the motion of {names} is met but for a small part, which the samples of a motion are off by: `missing`"
        ));
    }
    if let Some(first) = found.impossible.first() {
        all.push(format!(
            "at {} no efforts keep to the limits, first at {} s",
            counted(found.impossible.len(), "time", "times"),
            number(*first)
        ));
    }
    if !found.controllers.is_empty() {
        let names = found.controllers.join(", ");
        all.push(format!(
            "states and signals of controllers follow the motion from their start: {names}; efforts are those needed \
             besides the loads of the model"
        ));
    }
    for LimitUse { name, share, at, .. } in &found.limits {
        let percent = number((share * 1000.0).round() / 10.0);
        all.push(format!("{name}: {percent} % of its limit at {} s", number(*at)));
    }
    for duty in &found.duties {
        let (n, of) = (duty.outside().count(), duty.points.len());
        let worst = duty.worst().map(|[t, speed, effort, limit]| {
            let [per, unit] = &duty.units;
            format!(
                "; at most at {} s: {} {unit} of {} {unit} at {} {per}",
                number(*t),
                number(effort.abs()),
                number(*limit),
                number(*speed)
            )
        });
        let name = &duty.curve.name;
        all.push(format!(
            "{name}: {n} of {} outside of the motor's curve{}",
            counted(of, "point", "points"),
            worst.unwrap_or_default()
        ));
    }
    if all.is_empty() { String::new() } else { format!("\n  {}", all.join("\n  ")) }
}

fn limit_json(of: &LimitUse) -> Value {
    json!({ "name": of.name, "limit": of.limit, "share": of.share, "at": of.at })
}

fn duty_json(duty: &Duty) -> Value {
    json!({
        "name": duty.curve.name,
        "units": duty.units,
        "curve": duty.curve.points(),
        "points": duty.points,
        "outside": duty.outside().map(|point| point[0]).collect::<Vec<_>>(),
        "worst": duty.worst(),
    })
}

/// A motion, and of a log or a table its first and last time.
struct Given {
    motion: Motion,
    times: Option<[f64; 2]>,
}

/// A formula, `@table.csv` with times and values in its first two columns, or `@run.mcap`.
fn read_motion(
    (source, written): (&Text, &Source<'_>),
    model: &Model,
    (name, motion): &(String, String),
    smoothing: f64,
) -> Result<Given, Failure> {
    let given = |motion| Given { motion, times: None };
    let Some(path) = motion.strip_prefix('@') else {
        let motion = Motion::written(model, name, motion, written);
        return motion.map(given).map_err(failed(source));
    };
    let path = Path::new(path);
    if is_log(path) {
        let names = position(model, name).map_err(failed(source))?.motion_names(model);
        let (times, values) = logged_motion(path, name, names)?;
        let ends = times.first().zip(times.last()).map(|(first, last)| [*first, *last]);
        let motion = Motion::samples(model, name, times, values).map_err(failed(source))?;
        return Ok(Given { motion, times: ends });
    }
    let text = table_text(path)?;
    let measure = position(model, name).map_err(failed(source))?;
    if smoothing == 0.0
        && let Some(rows) = whole_motion(path, &text, model, (name, measure))?
    {
        let (times, values): (Vec<f64>, Vec<[f64; 3]>) =
            rows.into_iter().map(|[t, x, v, a]| (t, [x, v, a])).unzip();
        let ends = times.first().zip(times.last()).map(|(first, last)| [*first, *last]);
        let motion = Motion::samples(model, name, times, values).map_err(failed(source))?;
        return Ok(Given { motion, times: ends });
    }
    let names =
        [name.to_owned()].into_iter().chain(measure.motion_names(model).map(|all| all[0].clone()));
    let names: Vec<String> = names.collect();
    let columns = motion_columns(path, &text, &names)?;
    let (times, values) =
        read_pairs((path, &text), columns, ["time", "value"], ["s", measure.unit(model)])?;
    let ends = times.first().zip(times.last()).map(|(first, last)| [*first, *last]);
    let motion = Motion::spline(model, name, &times, &values, smoothing);
    motion.map(|motion| Given { motion, times: ends }).map_err(failed(source))
}

/// The content of a table.
fn table_text(path: &Path) -> Result<String, Failure> {
    Ok(String::from_utf8_lossy(&read_bytes(path)?).trim_start_matches('\u{feff}').to_owned())
}

/// Names of the columns of a table, without their units; none where its first line has numbers.
fn column_names(text: &str) -> Vec<String> {
    let cells = text.lines().next().unwrap_or_default().split(DIVIDERS);
    let name = |cell: &str| {
        let cell = cell.trim().trim_matches('"');
        cell.split(['[', '(']).next().unwrap_or_default().trim().to_owned()
    };
    let names: Vec<String> = cells.map(name).collect();
    if names.iter().any(|name| name.parse::<f64>().is_ok()) { Vec::new() } else { names }
}

/// Time, value, rate and acceleration of each row of a table that has columns of all, such as that of `bksim kinematics`.
fn whole_motion(
    path: &Path,
    text: &str,
    model: &Model,
    (name, measure): (&str, Measure),
) -> Result<Option<Vec<[f64; 4]>>, Failure> {
    let names = column_names(text);
    let place = |wanted: &str| names.iter().position(|known| known == wanted);
    let all = measure.motion_names(model).and_then(|[own, rate, acceleration]| {
        let value = place(name).or_else(|| place(&own))?;
        Some((place("t")?, [value, place(&rate)?, place(&acceleration)?]))
    });
    let Some((time, places)) = all else { return Ok(None) };
    let unit = measure.fixed_unit(model);
    let units = [unit.to_owned(), format!("{unit}/s"), format!("{unit}/s^2")];
    let what = ["time", "number"];
    let mut rows: Vec<[f64; 4]> = Vec::new();
    for (k, (place, unit)) in places.into_iter().zip(&units).enumerate() {
        let (times, values) = read_pairs((path, text), [time, place], what, ["s", unit])?;
        rows.resize(times.len(), [0.0; 4]);
        for (row, (t, value)) in rows.iter_mut().zip(times.into_iter().zip(values)) {
            (row[0], row[k + 1]) = (t, value);
        }
    }
    Ok(Some(rows))
}

/// Places of the time and of the motion in a table: by name, or its two columns.
fn motion_columns(path: &Path, text: &str, names: &[String]) -> Result<[usize; 2], Failure> {
    let known = column_names(text);
    let value = known.iter().position(|known| names.contains(known));
    if value.is_none() && known.len() <= 2 {
        return Ok([0, 1]);
    }
    let time = known.iter().position(|name| ["t", "time"].contains(&name.to_lowercase().as_str()));
    let refused = |what: String, help: String| Failure::Input {
        path: path.to_owned(),
        what,
        help: Some(help),
    };
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    match (time, value) {
        (Some(time), Some(value)) => Ok([time, value]),
        (None, Some(_)) => Err(refused(
            "has no column `t`".to_owned(),
            "a motion is over time: `bksim kinematics --drive t=0:2 s:201` writes such a table"
                .to_owned(),
        )),
        (_, None) => {
            Err(refused(format!("has no column `{}`", names[0]), suggest(&names[0], &known)))
        }
    }
}

/// Letters that divide the cells of a line.
const DIVIDERS: [char; 3] = [',', ';', '\t'];

/// Two columns of a table, in SI: each has the unit that the first line writes, `x [mm]`, or that of SI.
fn read_pairs(
    (path, text): (&Path, &str),
    places: [usize; 2],
    what: [&str; 2],
    si: [&str; 2],
) -> Result<(Vec<f64>, Vec<f64>), Failure> {
    let (mut first, mut second) = (Vec::new(), Vec::new());
    let mut units: [Option<WrittenUnit>; 2] = [None, None];
    let bad = |what: String, help: &str| Failure::Input {
        path: path.to_owned(),
        what,
        help: Some(help.to_owned()),
    };
    for (number, line) in text.lines().enumerate() {
        let cells: Vec<&str> = line.split(DIVIDERS).map(str::trim).collect();
        let cells = places.map(|place| cells.get(place).copied().unwrap_or_default());
        match cells.map(|cell| cell.parse::<f64>().ok()) {
            [Some(a), Some(b)] if a.is_finite() && b.is_finite() => {
                let in_si = |k: usize, value| units[k].as_ref().map_or(value, |u| u.to_si(value));
                first.push(in_si(0, a));
                second.push(in_si(1, b));
            }
            // The first line may hold names, with units.
            _ if number == 0 => {
                for (k, cell) in cells.iter().enumerate() {
                    units[k] = heading_unit(cell, si[k])
                        .map_err(|fault| bad(format!("line 1: {fault}"), UNIT_HELP))?;
                }
            }
            _ if line.trim().is_empty() => {}
            _ => {
                let [a, b] = what;
                let read = line.trim();
                let what = format!("line {} holds no {a} and {b}: `{read}`", number + 1);
                return Err(bad(what, "write lines such as `0.1,0.25`"));
            }
        }
    }
    Ok((first, second))
}

const UNIT_HELP: &str =
    "write the unit of a column in brackets, as in `t [s], x [mm]`, or none for SI";

/// The unit in the brackets of a heading; none where it has no brackets.
fn heading_unit(heading: &str, si: &str) -> Result<Option<WrittenUnit>, String> {
    let in_brackets = |open: char, close: char| {
        let rest = heading.trim_matches('"').trim().strip_suffix(close)?;
        rest.rsplit_once(open).map(|(_, unit)| unit.trim())
    };
    let Some(text) = in_brackets('[', ']').or_else(|| in_brackets('(', ')')) else {
        return Ok(None);
    };
    let written = WrittenUnit::parse(text);
    let written = written.ok_or_else(|| format!("`{text}` in `{heading}` is no unit"))?;
    let is_fitting = match si {
        "" => written.is_alike(&WrittenUnit::PURE),
        si => WrittenUnit::parse(si).is_some_and(|si| written.is_alike(&si)),
    };
    if is_fitting {
        Ok(Some(written))
    } else {
        Err(format!("`{text}` in `{heading}` is no unit for {si}"))
    }
}

/// Times of a log, and value, rate and acceleration there of what has this name; an event has two samples at one time.
fn logged_motion(
    path: &Path,
    name: &str,
    names: Option<[String; 3]>,
) -> Result<(Vec<f64>, Vec<[f64; 3]>), Failure> {
    let bad = |error: &dyn std::fmt::Display| Failure::Input {
        path: path.to_owned(),
        what: format!("has no motion of `{name}`: {error}"),
        help: Some("name a quantity that `bksim info` lists of the log".to_owned()),
    };
    let names = names.ok_or_else(|| bad(&"its rates have no names"))?;
    let file = File::open(path).map_err(|e| Failure::reading(path, &e))?;
    let mut log = LogReader::open(BufReader::new(file)).map_err(|e| bad(&e))?;
    if let Some(measured) = measured(path, log.header(), &names, "read")? {
        log = log.making(measured.making());
    }
    let selection = Selection::new(log.header(), &names).map_err(|e| bad(&e))?;
    let headings: Vec<String> = ["t"].into_iter().map(str::to_owned).chain(names).collect();
    let mut text = Vec::new();
    to_csv_as(log, &selection, &headings, &|_, value| value, &mut text).map_err(|e| bad(&e))?;
    let text = String::from_utf8_lossy(&text).into_owned();
    let (mut times, mut values): (Vec<f64>, Vec<[f64; 3]>) = (Vec::new(), Vec::new());
    for line in text.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').filter_map(|cell| cell.trim().parse().ok()).collect();
        let [t, value, rate, acceleration] = cells[..] else { continue };
        times.push(t);
        values.push([value, rate, acceleration]);
    }
    Ok((times, values))
}
