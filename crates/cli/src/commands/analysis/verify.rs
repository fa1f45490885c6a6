//! `bksim verify`: a run next to the same motion by an independent formulation.

use std::cell::{Cell, RefCell};
use std::time::Instant;

use bksim::analysis::{AnalysisError, Compared, Verified, Watch, Way, verify};
use bksim::model::Model;
use serde_json::{Value, json};

use super::answer::{Answer, Asked, asked, failed, lines, shown};
use crate::args::analysis::Verify as Args;
use crate::exit::{Failure, Status};
use crate::output::{counted, number};
use crate::progress::Progress;

pub(crate) fn run(args: &Args, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let (source, mut model, warnings, file) = asked(&args.model, &args.table, nesting)?.parts();
    if let Some(t_end) = args.t_end {
        model.solve.t_end = t_end;
    }
    let name = model.name.clone();
    let found = watched(model, args.patience).map_err(failed(&source))?;
    Asked::answer(&source, &warnings, file, told(&name, &found), as_json)?;
    Ok(if found.is_within() { Status::Done } else { Status::Rejected })
}

/// Verifies with a bar for each run, each of which ends after so many seconds.
fn watched(model: Model, patience: f64) -> Result<Verified, AnalysisError> {
    let (t_start, t_end) = (model.solve.t_start, model.solve.t_end);
    let bar: RefCell<(&str, Progress)> =
        RefCell::new(("", Progress::of("verifying", t_start, t_end)));
    within(model, patience, &|name, t| {
        let mut bar = bar.borrow_mut();
        if bar.0 != name || t == t_start {
            *bar = (name, Progress::of(name, t_start, t_end));
        }
        bar.1.reached(t);
    })
}

/// Verifies with runs each of which ends after so many seconds; `reached` is told the name of a run and its time, s.
///
/// # Errors
/// As [`verify`].
pub fn within(
    model: Model,
    patience: f64,
    reached: &dyn Fn(&'static str, f64),
) -> Result<Verified, AnalysisError> {
    let t_start = model.solve.t_start;
    let begun = Cell::new(("", Instant::now()));
    let reached = |name: &'static str, t: f64| {
        if begun.get().0 != name || t == t_start {
            begun.set((name, Instant::now()));
        }
        reached(name, t);
    };
    let stop = || begun.get().1.elapsed().as_secs_f64() > patience;
    verify(model, Watch { reached: &reached, stop: &stop })
}

/// The answer about a model of this name.
pub fn told(name: &str, found: &Verified) -> Answer {
    Answer {
        command: "verify",
        json: told_json(found),
        text: text(name, found),
        table: found.table(),
    }
}

/// Channels by how much of what is allowed they take, the worst first.
fn by_share(found: &Verified) -> Vec<&Compared> {
    let share = |channel: &Compared| channel.largest / channel.allowed;
    let mut all: Vec<&Compared> = found.channels.iter().collect();
    all.sort_by(|a, b| share(b).total_cmp(&share(a)));
    all
}

fn text(name: &str, found: &Verified) -> String {
    /// Channels that are told.
    const MOST: usize = 12;
    let n_beyond = found.channels.iter().filter(|c| !c.is_within).count();
    let allows = match &found.growth {
        None => "what the tolerances allow",
        Some(_) => "what the tolerances allow where differences grow so",
    };
    let verdict = match n_beyond {
        0 => format!("all within {allows}"),
        n => format!("{n} beyond {allows}"),
    };
    let way = |way: &Way| {
        let [rtol, atol] = way.tolerances.map(number);
        vec![
            way.n_coordinates.to_string(),
            way.n_constraints.to_string(),
            way.method.to_owned(),
            rtol,
            atol,
            way.n_steps.to_string(),
        ]
    };
    let ways = found.ways.iter().map(way).collect();
    let row = |channel: &&Compared| {
        vec![
            channel.name.clone(),
            shown(channel.largest, &channel.unit),
            shown(channel.allowed, &channel.unit),
            format!("{} s", number(channel.t)),
        ]
    };
    let all = by_share(found);
    let rows = all.iter().take(MOST).map(row).collect();
    let more = match all.len().saturating_sub(MOST) {
        0 => String::new(),
        1 => "\n  and 1 channel that is nearer".to_owned(),
        n => format!("\n  and {n} channels that are nearer"),
    };
    format!(
        "{name}: {} at {}, {verdict}{}\n\n{}\n\n{}{more}",
        counted(found.channels.len(), "channel", "channels"),
        counted(found.times.len(), "instant", "instants"),
        limits(found),
        lines(&["coordinates", "constraints", "method", "rtol", "atol", "steps"], ways),
        lines(&["channel", "largest difference", "allowed", "at"], rows),
    )
}

/// How far the comparison goes, and why no farther, a line each.
fn limits(found: &Verified) -> String {
    let mut all = Vec::new();
    if let Some(last) = found.times.last().filter(|last| **last != found.t_end) {
        all.push(format!(
            "compared up to t = {} s of {} s: a run took longer than `--patience` allows",
            number(*last),
            number(found.t_end)
        ));
    }
    if let Some(growth) = &found.growth {
        let factor = growth.factors.last().copied().unwrap_or(1.0);
        all.push(match growth.horizon {
            Some(horizon) => format!(
                "differences grow by {} per second: from t = {} s on those as small as the tolerances hide the motion, and \
                 nothing is judged",
                number(growth.rate.exp()),
                number(horizon)
            ),
            None => format!("a small difference of the start grows {}-fold", number(factor)),
        });
    }
    if all.is_empty() { String::new() } else { format!("\n  {}", all.join("\n  ")) }
}

fn told_json(found: &Verified) -> Value {
    let way = |way: &Way| {
        json!({
            "coordinates": way.n_coordinates,
            "constraints": way.n_constraints,
            "method": way.method,
            "rtol": way.tolerances[0],
            "atol": way.tolerances[1],
            "steps": way.n_steps,
        })
    };
    let channel = |channel: &Compared| {
        json!({
            "name": channel.name,
            "unit": channel.unit,
            "largest": channel.largest,
            "allowed": channel.allowed,
            "within": channel.is_within,
            "t": channel.t,
        })
    };
    json!({
        "within": found.is_within(),
        "whole": found.is_whole(),
        "reached": found.times.last(),
        "growth": found.growth.as_ref().map(|growth| json!({
            "rate": growth.rate,
            "horizon": growth.horizon,
            "factors": growth.factors,
        })),
        "instants": found.times.len(),
        "ways": found.ways.iter().map(way).collect::<Vec<_>>(),
        "channels": found.channels.iter().map(channel).collect::<Vec<_>>(),
    })
}
