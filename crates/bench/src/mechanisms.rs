//! The five-link mechanism of Lê and Đinh (2008) over 50 s: the whole process of `bksim solve`,
//! from the model file to the log, against programs that are used for mechanisms.
//!
//! Error is the largest one of the four angles over 101 instants, rad, against a reference of 13
//! digits. Each program runs at several step sizes or tolerances; the time at an error of 10⁻⁶ is
//! interpolated. The others are timed without start-up and model building.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use bksim::Mechanism;
use serde_json::{Value, json};

use crate::error::BenchError;
use crate::models;
use crate::peers::{Context, Workbench};
use crate::race::{Peer, Run, seconds_at};
use crate::report::{Check, Report, Table, ratio, seconds};

const MODEL: &str = include_str!("../../../examples/five-link/model.toml");
const REFERENCE: &str = include_str!("../../../tests/data/five-link.json");
/// The angles of links 1, 2, 4 and 5, and their indices in the reference.
const ANGLES: [(&str, usize); 4] = [("ti1", 0), ("ti2", 3), ("ti4", 7), ("ti5", 8)];
/// Error at which times are compared, rad.
const LEVEL: f64 = 1e-6;

/// The programs to compare with, and the goal of the time of each over ours.
const PEERS: [(Peer, f64); 3] = [
    (
        Peer {
            name: "Exudyn, generalised alpha",
            script: "mechanism_exudyn",
            sizes: &[1e-3, 2e-4, 1e-4],
        },
        100.0,
    ),
    (
        Peer { name: "MuJoCo, RK4", script: "mechanism_mujoco", sizes: &[1e-3, 5e-4, 2e-4, 1e-4] },
        100.0,
    ),
    (
        Peer {
            name: "Pinocchio, DOP853",
            script: "mechanism_pinocchio",
            sizes: &[1e-6, 1e-7, 1e-8, 1e-9, 1e-10],
        },
        5.0,
    ),
];

/// Angles at one instant of the reference.
struct Row {
    t: f64,
    angles: Vec<f64>,
}

/// Measures all programs.
pub(crate) fn run(context: &Context) -> Result<Report, BenchError> {
    let mut report = Report::new("mechanisms", "Five-link mechanism over 50 s");
    let rows = reference()?;
    let ours = ours(&rows, context, &mut report)?;
    let mut all = vec![("bksim, model file to log", ours, None)];
    for (peer, goal) in &PEERS {
        match theirs(peer, &rows, context, &mut report) {
            Ok(runs) => all.push((peer.name, runs, Some(*goal))),
            Err(absent) => report.notes.push(format!("{}: {absent}", peer.name)),
        }
    }

    // All runs, and the goals at one error.
    let mut table = Table::new(["program", "step or tolerance", "time", "error, rad"]);
    let own = seconds_at(&all[0].1, LEVEL);
    for (name, runs, goal) in &all {
        for run in runs {
            let cells =
                [format!("{:.0e}", run.size), seconds(run.seconds), format!("{:.1e}", run.error)];
            table.push([(*name).to_owned()].into_iter().chain(cells));
        }
        let one = |run: &Run| json!({"size": run.size, "seconds": run.seconds, "error": run.error});
        report.numbers.insert((*name).to_owned(), runs.iter().map(one).collect());
        if let Some(goal) = goal {
            let times = seconds_at(runs, LEVEL) / own;
            let what = format!("{name}: times our time at an error of 1e-6");
            report.checks.push(Check::at_least(what, times, *goal));
        }
    }
    report.tables.push(table);

    // Times at that error.
    let mut at_level = Table::new(["at an error of 1e-6", "time", "ratio to ours"]);
    for (name, runs, _) in &all {
        let time = seconds_at(runs, LEVEL);
        at_level.push([(*name).to_owned(), seconds(time), ratio(time / own)]);
    }
    report.tables.push(at_level);
    Ok(report)
}

/// Reads the reference.
fn reference() -> Result<Vec<Row>, BenchError> {
    const FAULT: BenchError = BenchError::Data("the five-link reference is not as expected");
    let data: Value = serde_json::from_str(REFERENCE).map_err(|_| FAULT)?;
    let row = |row: &Value| {
        let angles = ANGLES.iter().map(|&(_, idx)| row["q"][idx].as_f64());
        Some(Row { t: row["t"].as_f64()?, angles: angles.collect::<Option<_>>()? })
    };
    let rows: Option<Vec<Row>> = data["rows"].as_array().ok_or(FAULT)?.iter().map(row).collect();
    rows.ok_or(FAULT)
}

/// Our runs: errors from this process, times of whole processes with the same options.
fn ours(rows: &[Row], context: &Context, report: &mut Report) -> Result<Vec<Run>, BenchError> {
    let bench = Workbench::new()?;
    let model = bench.write("five-link.toml", MODEL)?;
    let program = &context.program;
    if !program.is_file() {
        let path = program.display();
        report.notes.push(format!("`{path}` is missing: cargo build --release -p bksim-cli"));
    }
    let tolerances: &[f64] =
        if context.effort.is_quick { &[1e-6] } else { &[1e-6, 1e-7, 1e-8, 1e-9, 1e-10] };
    let one = |&tolerance: &f64| {
        let mut seconds = f64::NAN;
        for _ in 0..context.effort.max_runs.min(10) {
            let took = process(program, &model, tolerance, &bench.file("log.mcap"));
            seconds = seconds.min(took.unwrap_or(f64::NAN));
        }
        Ok(Run { size: tolerance, seconds, error: error(rows, tolerance)? })
    };
    tolerances.iter().map(one).collect()
}

/// Wall-clock time of one whole process, s.
fn process(program: &Path, model: &Path, tolerance: f64, log: &Path) -> Option<f64> {
    let tolerance = format!("{tolerance:e}");
    let mut command = Command::new(program);
    command
        .args(["solve", "--force", "--every", "0.5", "--rtol", &tolerance, "--atol", &tolerance]);
    command.arg(model).arg("-o").arg(log).stdout(Stdio::null()).stderr(Stdio::null());
    let began = Instant::now();
    let status = command.status().ok()?;
    status.success().then(|| began.elapsed().as_secs_f64())
}

/// The largest error of our angles.
fn error(rows: &[Row], tolerance: f64) -> Result<f64, BenchError> {
    let refused = |message: String| BenchError::Model { name: "five-link".to_owned(), message };
    let mut model = models::model(MODEL, "five-link")?;
    (model.solve.rtol, model.solve.atol) = (tolerance, tolerance);
    model.solve.every = Some(rows[1].t);
    let mechanism = Mechanism::derive(model, Vec::new()).map_err(|e| refused(e.to_string()))?;
    let names = &mechanism.compiled.coordinates;
    let indices: Option<Vec<usize>> =
        ANGLES.iter().map(|(name, _)| names.iter().position(|c| c.name == *name)).collect();
    let indices = indices.ok_or_else(|| refused("an angle is missing".to_owned()))?;
    let motion = mechanism.solve().map_err(|e| refused(e.to_string()))?;
    let mut worst = 0.0f64;
    for (sample, row) in motion.samples.iter().zip(rows) {
        for (&idx, expected) in indices.iter().zip(&row.angles) {
            worst = worst.max(wrapped(sample.q[idx] - expected).abs());
        }
    }
    Ok(if motion.samples.len() == rows.len() { worst } else { f64::NAN })
}

/// An angle wrapped to −π … π.
fn wrapped(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle - turn * (angle / turn).round()
}

/// The runs of a peer at all its sizes.
fn theirs(
    peer: &Peer,
    rows: &[Row],
    context: &Context,
    report: &mut Report,
) -> Result<Vec<Run>, crate::peers::Absent> {
    let sizes = if context.effort.is_quick { &peer.sizes[..1] } else { peer.sizes };
    let row = |row: &Row| json!({"t": row.t, "angles": row.angles});
    let rows: Vec<Value> = rows.iter().map(row).collect();
    let output = context.peers.python(peer.script, &json!({"rows": rows, "sizes": sizes}))?;
    let version = output["version"].as_str().unwrap_or("unknown");
    report.notes.push(format!("{} {version}", peer.name));
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let one = |run: &Value| Run {
        size: number(&run["h"]),
        seconds: number(&run["seconds"]),
        error: number(&run["error"]),
    };
    Ok(output["runs"].as_array().ok_or("it printed no runs")?.iter().map(one).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn our_angles_are_those_of_the_reference() -> Result<(), BenchError> {
        let rows = reference()?;
        assert_eq!(rows.len(), 101);
        let found = error(&rows, 1e-8)?;
        assert!(found < 1e-3, "{found:e}");
        Ok(())
    }
}
