//! Waits of a person: derivations, and commands as whole processes, each with the time that it may take.
//!
//! Times are CPU times: of a derivation that of this process, the least of several; of a command that of its process,
//! the mean of as many runs as last a while, since the system counts it in hundredths of a second.

use std::path::Path;
use std::process::{Command, Stdio};

use bksim_mbs::assemble::assemble;
use bksim_model::file::{Limits, expand};
use serde_json::json;

use crate::error::BenchError;
use crate::models;
use crate::peers::{Context, Workbench};
use crate::report::{Check, Report, Table, seconds};
use crate::timing::cpu_time;

/// Something to wait for: what, the model, the command with its arguments, and how long it may take, s.
type Wait = (&'static str, &'static str, &'static [&'static str], f64);

/// In place of a command: the equations alone.
const DERIVATION: &[&str] = &[];

const STEWART: &str = include_str!("../../../examples/stewart-platform/model.toml");
const JANSEN: &str = include_str!("../../../examples/jansen/model.toml");
const BICYCLE: &str = include_str!("../../../tests/fixtures/touch/bicycle.toml");
const WAITS: [Wait; 17] = [
    (
        "derive six bodies with three damped springs",
        include_str!("../models/six-bodies.toml"),
        DERIVATION,
        0.03,
    ),
    ("derive the Stewart platform", STEWART, DERIVATION, 0.06),
    (
        "derive a Stewart platform of 13 bodies",
        include_str!("../../../tests/fixtures/stewart.toml"),
        DERIVATION,
        0.1,
    ),
    ("derive the benchmark bicycle", BICYCLE, DERIVATION, 0.02),
    (
        "derive the delta robot",
        include_str!("../../../examples/delta-robot/model.toml"),
        DERIVATION,
        0.025,
    ),
    (
        "derive the double wishbone",
        include_str!("../../../examples/double-wishbone/model.toml"),
        DERIVATION,
        0.02,
    ),
    (
        "solve the slider-crank",
        include_str!("../../../examples/slider-crank/model.toml"),
        &["solve", "--force", "-o", "log.mcap"],
        0.006,
    ),
    ("solve the Stewart platform", STEWART, &["solve", "--force", "-o", "log.mcap"], 0.1),
    (
        "verify the governor",
        include_str!("../../../examples/governor/model.toml"),
        &["verify"],
        1.0,
    ),
    (
        "modes of a cantilever of 40 lumps",
        include_str!("../models/cantilever.toml"),
        &["modes"],
        0.3,
    ),
    (
        "linear equations of a six-bar in letters",
        include_str!("../../../tests/fixtures/six-bar.toml"),
        &["linearize", "--letters"],
        1.0,
    ),
    ("linear equations of the benchmark bicycle", BICYCLE, &["linearize", "--at", "start"], 0.3),
    ("equations of the Stewart platform", STEWART, &["equations"], 0.5),
    ("freedoms of the Stewart platform", STEWART, &["doctor"], 0.3),
    ("positions of Jansen's leg", JANSEN, &["kinematics", "--drive", "O.angle=0:360 deg:361"], 0.3),
    (
        "Jansen's leg, 361 positions with all rates as a table",
        JANSEN,
        &["kinematics", "--drive", "O.angle=0:360 deg:361", "--force", "-o", "table.csv"],
        0.02,
    ),
    (
        "a six-bar, all assemblies with their proof",
        include_str!("../../../examples/beam-engine/model.toml"),
        &["kinematics", "--assemblies"],
        0.05,
    ),
];

/// Measures all waits.
pub(crate) fn measure(context: &Context) -> Result<Report, BenchError> {
    let mut report = Report::new("waits", "What a person waits for, CPU time");
    let bench = Workbench::new()?;
    let mut table = Table::new(["wait", "takes", "goal", ""]);
    for (name, text, arguments, goal) in WAITS {
        // Commands take minutes in the development profile.
        let took = match (arguments, context.effort.is_quick) {
            (DERIVATION, _) => derivation(name, text, context)?,
            (_, true) => continue,
            (_, false) => command(arguments, &bench.write("model.toml", text)?, context),
        };
        let check = Check::at_most(format!("{name}, ms"), 1e3 * took, 1e3 * goal);
        let mark = if check.is_met() == Some(false) { "over" } else { "" };
        table.push([name.to_owned(), seconds(took), seconds(goal), mark.to_owned()]);
        report.numbers.insert(name.to_owned(), json!({ "cpu_s": took, "goal_s": goal }));
        report.checks.push(check);
    }
    report.tables.push(table);
    Ok(report)
}

/// The text of a model with its elements that repeat.
fn whole(text: &str) -> String {
    let mut none = |file: &str| Err(format!("there is no {file}"));
    expand("model.toml", text, Limits::default(), &mut none)
        .map_or_else(|| text.to_owned(), |expansion| expansion.text)
}

/// The least time of several derivations, s.
fn derivation(name: &str, text: &str, context: &Context) -> Result<f64, BenchError> {
    let mut least = f64::INFINITY;
    for _ in 0..context.effort.max_runs.min(5) {
        let model = models::model(&whole(text), name)?;
        let began = cpu_time();
        std::hint::black_box(assemble(&model));
        least = least.min(cpu_time() - began);
    }
    Ok(least)
}

/// The mean time of a command's process in the folder of the model, s; NaN where it fails.
fn command(arguments: &[&str], model: &Path, context: &Context) -> f64 {
    let began = children_time();
    let mut n = 0.0;
    loop {
        let mut command = Command::new(&context.program);
        command.args(arguments).arg(model).stdout(Stdio::null()).stderr(Stdio::null());
        command.current_dir(model.parent().unwrap_or(model));
        // A run that is judged not to agree has answered, too.
        if !command.status().is_ok_and(|status| matches!(status.code(), Some(0 | 3))) {
            return f64::NAN;
        }
        n += 1.0;
        let took = children_time() - began;
        if took >= context.effort.enough_s || n >= 100.0 {
            return took / n;
        }
    }
}

/// User and system time of all processes that have ended, s; NaN where the system has no such file.
fn children_time() -> f64 {
    /// Ticks of that file in a second, on every Linux.
    const TICKS: f64 = 100.0;
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The name of the program, in parentheses, may hold spaces.
    let rest = text.rsplit_once(')').map_or("", |(_, rest)| rest);
    let ticks: Vec<f64> =
        rest.split_whitespace().skip(13).take(2).filter_map(|n| n.parse().ok()).collect();
    if ticks.len() == 2 { ticks.iter().sum::<f64>() / TICKS } else { f64::NAN }
}
