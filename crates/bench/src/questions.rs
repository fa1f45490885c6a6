//! Questions about positions, timed as whole processes: from the model file to the written answer.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use serde_json::json;

use crate::context::Context;
use crate::error::BenchError;
use crate::mechanisms::neighbouring_program;
use crate::peers::Workbench;
use crate::report::{Check, Report, Table, seconds};

/// A question, and how long it may take, s.
struct Question {
    name: &'static str,
    model: &'static str,
    arguments: &'static [&'static str],
    goal: f64,
}

const QUESTIONS: [Question; 2] = [
    Question {
        name: "Jansen's leg, 361 positions with all rates as a table",
        model: include_str!("../../../examples/jansen/model.toml"),
        arguments: &["kinematics", "--drive", "O.angle=0:360 deg:361", "-o", "table.csv"],
        goal: 0.02,
    },
    Question {
        name: "a six-bar, all assemblies with their proof",
        model: include_str!("../../../examples/beam-engine/model.toml"),
        arguments: &["kinematics", "--assemblies"],
        goal: 0.05,
    },
];

/// Measures all questions.
pub(crate) fn measure(context: &Context, program: Option<&Path>) -> Result<Report, BenchError> {
    let mut report = Report::new("questions", "Questions as whole processes");
    let bench = Workbench::new()?;
    let program = program.map_or_else(neighbouring_program, Path::to_owned);
    let mut table = Table::new(["question", "fastest", "median"]);
    for question in &QUESTIONS {
        let model = bench.write("model.toml", question.model)?;
        let mut times: Vec<f64> = (0..context.effort.max_runs.min(20))
            .filter_map(|_| took(question, &program, &model))
            .collect();
        times.sort_by(f64::total_cmp);
        let fastest = times.first().copied().unwrap_or(f64::NAN);
        let median = times.get(times.len() / 2).copied().unwrap_or(f64::NAN);
        table.push([question.name.to_owned(), seconds(fastest), seconds(median)]);
        let both = json!({ "fastest_s": fastest, "median_s": median });
        report.numbers.insert(question.name.to_owned(), both);
        let what = format!("{}, ms", question.name);
        report.checks.push(Check::at_most(what, 1e3 * fastest, 1e3 * question.goal));
    }
    report.tables.push(table);
    Ok(report)
}

/// Wall-clock time of one process that answers, s.
fn took(question: &Question, program: &Path, model: &Path) -> Option<f64> {
    let mut command = Command::new(program);
    command.args(question.arguments).arg(model).arg("--force");
    command.current_dir(model.parent()?).stdout(Stdio::null()).stderr(Stdio::null());
    let began = Instant::now();
    let status = command.status().ok()?;
    status.success().then(|| began.elapsed().as_secs_f64())
}
