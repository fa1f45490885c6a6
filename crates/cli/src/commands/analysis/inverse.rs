//! `bksim inverse`: the efforts of a motion.

use std::path::Path;

use bksim::analysis::{AnalysisError, Inverse, Load, Motion, Range, inverse};
use bksim::model::Model;
use serde_json::json;

use super::answer::{Answer, Asked, asked, failed, lines, refuse_input, table_json};
use crate::args::analysis::Inverse as Args;
use crate::exit::{Failure, Status};
use crate::output::number;
use crate::source::{Text, read_bytes};

/// Number of times where none is given.
const N_TIMES: usize = 101;

pub(crate) fn run(args: &Args, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    for path in args.motion.iter().filter_map(|(_, motion)| motion.strip_prefix('@')) {
        refuse_input(&args.table, Path::new(path))?;
    }
    let (source, model, warnings, file) = asked(&args.model, &args.table, nesting)?.parts();
    let name = model.name.clone();
    let times = times(&model, args.times.as_deref()).map_err(failed(&source))?;
    let motions: Vec<Motion> = (args.motion.iter())
        .map(|(name, motion)| read_motion(&source, &model, name, motion, args.smoothing))
        .collect::<Result<_, _>>()?;
    let found = inverse(model, &motions, &times).map_err(failed(&source))?;
    Asked::answer(&source, &warnings, file, told(&name, &found), as_json)
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

/// The answer about a model of this name.
pub fn told(name: &str, found: &Inverse) -> Answer {
    let row = |load: &Load| {
        vec![
            load.name.clone(),
            number(load.peak),
            format!("{} s", number(load.at)),
            number(load.rms),
            load.unit.clone(),
        ]
    };
    let is_shown = |load: &&Load| load.peak != 0.0;
    let rows = found.loads.iter().filter(is_shown).map(row).collect();
    let text = format!(
        "{name}: efforts at {} times\n\n{}",
        found.table.rows.len(),
        lines(&["", "peak", "at", "rms", "unit"], rows)
    );
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
    });
    Answer { command: "inverse", json, text, table: found.table.clone() }
}

/// A formula, or `@table.csv` with times and values in its first two columns.
fn read_motion(
    source: &Text,
    model: &Model,
    name: &str,
    motion: &str,
    smoothing: f64,
) -> Result<Motion, Failure> {
    let Some(path) = motion.strip_prefix('@') else {
        return Motion::formula(model, name, motion).map_err(failed(source));
    };
    let path = Path::new(path);
    let text = String::from_utf8_lossy(&read_bytes(path)?).into_owned();
    let (mut times, mut values) = (Vec::new(), Vec::new());
    for (number, line) in text.lines().enumerate() {
        let mut cells = line.split([',', ';', '\t']).map(|cell| cell.trim().parse::<f64>());
        match (cells.next(), cells.next()) {
            (Some(Ok(t)), Some(Ok(value))) => {
                times.push(t);
                values.push(value);
            }
            // The first line may hold names.
            _ if number == 0 || line.trim().is_empty() => {}
            _ => {
                let what = format!("line {} holds no time and value", number + 1);
                let help = Some("write lines such as `0.1,0.25`, in SI units".to_owned());
                return Err(Failure::Input { path: path.to_owned(), what, help });
            }
        }
    }
    Motion::spline(model, name, &times, &values, smoothing).map_err(failed(source))
}
