//! Waits of a person: derivations, and commands as whole processes, each with the time that it may take.
//!
//! Times are CPU times: of a derivation that of this process, the least of several; of a command that of its process,
//! the mean of as many runs as last a while, since the system counts it in hundredths of a second.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use bksim_mbs::assemble::assemble;
use bksim_model::file::{Limits, expand};
use serde_json::json;

use crate::context::Context;
use crate::error::BenchError;
use crate::mechanisms::neighbouring_program;
use crate::models;
use crate::peers::Workbench;
use crate::report::{Check, Report, Table, seconds};
use crate::timing::cpu_time;

/// The way to an answer.
enum Way {
    /// The equations of a model.
    Derivation,
    /// A command with these arguments before the model.
    Command(&'static [&'static str]),
}

/// Something to wait for, and how long it may take, s.
struct Wait {
    name: &'static str,
    model: &'static str,
    way: Way,
    goal: f64,
}

const WAITS: [Wait; 11] = [
    Wait {
        name: "derive six bodies with three damped springs",
        model: include_str!("../models/six-bodies.toml"),
        way: Way::Derivation,
        goal: 0.03,
    },
    Wait {
        name: "derive the Stewart platform",
        model: include_str!("../../../examples/stewart-platform/model.toml"),
        way: Way::Derivation,
        goal: 0.06,
    },
    Wait {
        name: "derive the delta robot",
        model: include_str!("../../../examples/delta-robot/model.toml"),
        way: Way::Derivation,
        goal: 0.025,
    },
    Wait {
        name: "derive the double wishbone",
        model: include_str!("../../../examples/double-wishbone/model.toml"),
        way: Way::Derivation,
        goal: 0.02,
    },
    Wait {
        name: "solve the slider-crank",
        model: include_str!("../../../examples/slider-crank/model.toml"),
        way: Way::Command(&["solve"]),
        goal: 0.006,
    },
    Wait {
        name: "solve the Stewart platform",
        model: include_str!("../../../examples/stewart-platform/model.toml"),
        way: Way::Command(&["solve"]),
        goal: 0.1,
    },
    Wait {
        name: "verify the governor",
        model: include_str!("../../../examples/governor/model.toml"),
        way: Way::Command(&["verify"]),
        goal: 1.0,
    },
    Wait {
        name: "modes of a cantilever of 40 lumps",
        model: include_str!("../models/cantilever.toml"),
        way: Way::Command(&["modes"]),
        goal: 0.3,
    },
    Wait {
        name: "linear equations of a six-bar in letters",
        model: include_str!("../../../tests/fixtures/six-bar.toml"),
        way: Way::Command(&["linearize", "--letters"]),
        goal: 1.0,
    },
    Wait {
        name: "freedoms of the Stewart platform",
        model: include_str!("../../../examples/stewart-platform/model.toml"),
        way: Way::Command(&["doctor"]),
        goal: 0.3,
    },
    Wait {
        name: "positions of Jansen's leg",
        model: include_str!("../../../examples/jansen/model.toml"),
        way: Way::Command(&["kinematics"]),
        goal: 0.3,
    },
];

/// Measures all waits.
pub(crate) fn measure(context: &Context, program: Option<&Path>) -> Result<Report, BenchError> {
    let mut report = Report::new("waits", "What a person waits for, CPU time");
    let bench = Workbench::new()?;
    let program = program.map_or_else(neighbouring_program, Path::to_owned);
    let mut table = Table::new(["wait", "takes", "goal", ""]);
    for wait in &WAITS {
        let took = match wait.way {
            // Minutes of the development profile.
            Way::Command(_) if context.effort.is_quick => continue,
            Way::Derivation => derivation(wait, context)?,
            Way::Command(arguments) => {
                let model = bench.write("model.toml", wait.model)?;
                command(&program, arguments, &model, context)
            }
        };
        let check = Check::at_most(format!("{}, ms", wait.name), 1e3 * took, 1e3 * wait.goal);
        let mark = if check.is_met() == Some(false) { "over" } else { "" };
        table.push([wait.name.to_owned(), seconds(took), seconds(wait.goal), mark.to_owned()]);
        report.numbers.insert(wait.name.to_owned(), json!({ "cpu_s": took, "goal_s": wait.goal }));
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
fn derivation(wait: &Wait, context: &Context) -> Result<f64, BenchError> {
    let mut least = f64::INFINITY;
    for _ in 0..context.effort.max_runs.min(5) {
        let model = models::model(&whole(wait.model), wait.name)?;
        let began = cpu_time();
        std::hint::black_box(assemble(&model));
        least = least.min(cpu_time() - began);
    }
    Ok(least)
}

/// The mean time of a command's process, s; NaN where it fails.
fn command(program: &Path, arguments: &[&str], model: &PathBuf, context: &Context) -> f64 {
    let began = children_time();
    let mut n = 0.0;
    loop {
        let mut command = Command::new(program);
        command.args(arguments).arg(model);
        if arguments == ["solve"] {
            command.args(["--force", "-o"]).arg(model.with_extension("mcap"));
        }
        let status = command.stdout(Stdio::null()).stderr(Stdio::null()).status();
        // A run that is judged not to agree has answered, too.
        if !status.is_ok_and(|status| matches!(status.code(), Some(0 | 3))) {
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
