//! Mechanisms at random, each run as it is and in another formulation by `bksim verify`: who disagrees, and whether
//! with a word.

mod generator;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::error::BenchError;
use crate::peers::{Context, Workbench};
use crate::report::{Check, Report, Table, seconds};

/// The mechanisms that are tried.
#[derive(clap::Args, Debug)]
pub(crate) struct Numbers {
    /// Number of the first.
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    first: u64,
    /// Mechanisms in the plane, and as many in space.
    #[arg(long, value_name = "COUNT", default_value_t = 500)]
    count: u64,
    /// Writes the models of runs that disagree, fail or last long to FOLDER.
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
}

/// Time that a mechanism may take, both runs together, before it is ended.
const PATIENCE: Duration = Duration::from_secs(30);
/// Time that people wait without wondering.
const USUAL: Duration = Duration::from_secs(2);
/// Warnings that say nothing of numbers, as those of models do not: conditions that repeat each other, starts that were moved.
const OF_SHAPE: [&str; 3] = ["S010", "S014", "S015"];

/// Outcome of a mechanism at random.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum Outcome {
    Agrees,
    /// Agreement as far as differences mean anything, or as both came.
    AgreesInPart,
    Refused,
    Stopped,
    Disagrees,
    /// Without a warning.
    DisagreesSilently,
    TooLong,
    Panicked,
}

const OUTCOMES: [(Outcome, &str); 8] = [
    (Outcome::Agrees, "agree"),
    (Outcome::AgreesInPart, "agree in part"),
    (Outcome::Refused, "refused"),
    (Outcome::Stopped, "stopped"),
    (Outcome::Disagrees, "disagree"),
    (Outcome::DisagreesSilently, "silently"),
    (Outcome::TooLong, "too long"),
    (Outcome::Panicked, "panic"),
];

struct Tried {
    outcome: Outcome,
    codes: Vec<String>,
    /// The largest difference as a part of what is allowed, with its channel.
    worst: (f64, String),
    time: Duration,
}

/// Tries all of them.
pub(crate) fn measure(context: &Context, numbers: &Numbers) -> Result<Report, BenchError> {
    let mut report = Report::new("random", "mechanisms at random beside another formulation");
    let bench = Workbench::new()?;
    let n = if context.effort.is_quick { 5 } else { numbers.count };
    let head = OUTCOMES.map(|(_, word)| word);
    let mut table = Table::new([""].into_iter().chain(head).chain(["median", "longest"]));
    let mut by_code: BTreeMap<String, usize> = BTreeMap::new();
    let (mut n_silent, mut n_ended) = (0, 0);
    for (is_spatial, word) in [(false, "planar"), (true, "spatial")] {
        let mut counts: BTreeMap<Outcome, usize> = BTreeMap::new();
        let mut times = Vec::new();
        for number in numbers.first..numbers.first + n {
            let text = generator::model(number, is_spatial);
            let tried = try_one(&context.program, &bench.write("random.toml", &text)?)?;
            *counts.entry(tried.outcome).or_default() += 1;
            tried.codes.iter().for_each(|code| *by_code.entry(code.clone()).or_default() += 1);
            times.push(tried.time);
            let is_usual = matches!(tried.outcome, Outcome::Agrees | Outcome::AgreesInPart);
            if is_usual && tried.time < USUAL {
                continue;
            }
            let (share, channel) = &tried.worst;
            let codes = tried.codes.join(" ");
            report.notes.push(format!(
                "{word} {number}: {:?}, {}, {codes} {share:.1e} of what is allowed in `{channel}`",
                tried.outcome,
                seconds(tried.time.as_secs_f64())
            ));
            if let Some(folder) = &numbers.keep {
                let path = folder.join(format!("{word}-{number}.toml"));
                std::fs::create_dir_all(folder).map_err(|source| BenchError::io(folder, source))?;
                std::fs::write(&path, text).map_err(|source| BenchError::io(&path, source))?;
            }
        }
        let count = |outcome: Outcome| counts.get(&outcome).copied().unwrap_or_default();
        n_silent += count(Outcome::DisagreesSilently);
        n_ended += count(Outcome::TooLong) + count(Outcome::Panicked);
        times.sort_unstable();
        let own = OUTCOMES.map(|(outcome, _)| count(outcome).to_string());
        let ends = [times.get(times.len() / 2), times.last()];
        let ends = ends.map(|time| seconds(time.copied().unwrap_or_default().as_secs_f64()));
        table.push([word.to_owned()].into_iter().chain(own).chain(ends));
    }
    report.tables.push(table);
    report.numbers.insert("codes".to_owned(), json!(by_code));
    let listed: Vec<String> = by_code.iter().map(|(code, n)| format!("{code} {n}×")).collect();
    report.notes.push(format!("codes: {}", listed.join(", ")));
    report.checks.push(Check::at_most("disagreements without a word", n_silent as f64, 0.0));
    report.checks.push(Check::at_most("panics and runs without end", n_ended as f64, 0.0));
    Ok(report)
}

/// One mechanism by `bksim verify`.
fn try_one(program: &Path, model: &Path) -> Result<Tried, BenchError> {
    let began = Instant::now();
    let output = model.with_extension("json");
    let file = std::fs::File::create(&output).map_err(|source| BenchError::io(&output, source))?;
    let mut command = Command::new(program);
    command.args(["verify", "--json"]).arg(model).stdout(file).stderr(Stdio::null());
    let mut child = command.spawn().map_err(|source| BenchError::io(program, source))?;
    let status = wait(&mut child);
    let text = std::fs::read_to_string(&output).unwrap_or_default();
    let answer: Value = serde_json::from_str(&text).unwrap_or(Value::Null);
    let list = |key: &str| answer[key].as_array().cloned().unwrap_or_default();
    let code = |found: &Value| found["code"].as_str().unwrap_or_default().to_owned();
    let codes: Vec<String> = list("diagnostics").iter().map(code).collect();
    let share = |channel: &Value| {
        let [largest, allowed] =
            ["largest", "allowed"].map(|key| channel[key].as_f64().unwrap_or(f64::INFINITY));
        let name = channel["name"].as_str().unwrap_or_default().to_owned();
        (if largest == 0.0 { 0.0 } else { largest / allowed }, name)
    };
    let worst = list("channels").iter().map(share).max_by(|a, b| a.0.total_cmp(&b.0));
    let is_of_numbers =
        |code: &String| !code.starts_with('M') && !OF_SHAPE.contains(&code.as_str());
    let is_said = codes.iter().any(is_of_numbers);
    let outcome = match status {
        None => Outcome::TooLong,
        Some(None | Some(101)) => Outcome::Panicked,
        Some(Some(3)) => Outcome::Stopped,
        Some(Some(_)) if answer["within"] == json!(false) && is_said => Outcome::Disagrees,
        Some(Some(_)) if answer["within"] == json!(false) => Outcome::DisagreesSilently,
        Some(Some(0)) if answer["whole"] == json!(true) => Outcome::Agrees,
        Some(Some(0)) => Outcome::AgreesInPart,
        Some(Some(_)) => Outcome::Refused,
    };
    Ok(Tried { outcome, codes, worst: worst.unwrap_or_default(), time: began.elapsed() })
}

/// The exit status, `Some(None)` of a process that was ended by a signal; `None` where it took too long.
#[expect(clippy::option_option, reason = "whether it ended, then how")]
fn wait(child: &mut Child) -> Option<Option<i32>> {
    let began = Instant::now();
    loop {
        if let Ok(Some(status)) = child.try_wait() {
            return Some(status.code());
        }
        if began.elapsed() > PATIENCE {
            // It may have ended meanwhile.
            let _ = child.kill();
            let _ = child.wait();
            return None;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}
