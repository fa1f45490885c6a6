//! `bksim verify`: a run beside the same motion by an independent formulation.

use bksim::analysis::{Compared, Verified, Way, verify};
use serde_json::{Value, json};

use super::answer::{Answer, Asked, asked, failed, lines, shown};
use crate::args::analysis::Verify as Args;
use crate::exit::{Failure, Status};
use crate::output::number;

pub(crate) fn run(args: &Args, as_json: bool, nesting: usize) -> Result<Status, Failure> {
    let (source, mut model, warnings, file) = asked(&args.model, &args.table, nesting)?.parts();
    if let Some(t_end) = args.t_end {
        model.solve.t_end = t_end;
    }
    let name = model.name.clone();
    let found = verify(model).map_err(failed(&source))?;
    Asked::answer(&source, &warnings, file, told(&name, &found), as_json)?;
    Ok(if found.is_within() { Status::Done } else { Status::Rejected })
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
    let n_beyond = found.channels.iter().filter(|c| c.largest > c.allowed).count();
    let verdict = match n_beyond {
        0 => "all within what the tolerances allow".to_owned(),
        n => format!("{n} beyond what the tolerances allow"),
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
        n => format!("\n  and {n} channels that are nearer"),
    };
    format!(
        "{name}: {} channels at {} instants, {verdict}\n\n{}\n\n{}{more}",
        found.channels.len(),
        found.times.len(),
        lines(&["coordinates", "constraints", "method", "rtol", "atol", "steps"], ways),
        lines(&["channel", "largest difference", "allowed", "at"], rows),
    )
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
            "t": channel.t,
        })
    };
    json!({
        "within": found.is_within(),
        "instants": found.times.len(),
        "ways": found.ways.iter().map(way).collect::<Vec<_>>(),
        "channels": found.channels.iter().map(channel).collect::<Vec<_>>(),
    })
}
