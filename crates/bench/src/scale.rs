//! Growth with size: a chain of N links in absolute coordinates and an N-four-bar, N = 10 … 10 000, and what it takes
//! until they move, up to 40 000 links.
//!
//! Every size runs in a process of its own, which prints its times and its peak memory. The
//! exponent p between two sizes is that of time ~ Nᵖ.

use std::process::Command;
use std::time::{Duration, Instant};

use bksim::Mechanism;
use bksim::dae::Control;
use bksim::model::Model;
use clap::ValueEnum;
use serde_json::{Value, json};

use crate::error::BenchError;
use crate::models::{self, link_chain, n_four_bar};
use crate::peers::Context;
use crate::report::{Check, Report, Table, ratio, seconds};
use crate::timing::cpu_time;

/// A family of mechanisms.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum, Debug)]
pub(crate) enum Family {
    /// Links one after the other.
    Chain,
    /// Square windows in a row.
    FourBar,
}

/// One size of one family: the arguments of the hidden subcommand.
#[derive(clap::Args, Clone, Copy, Debug)]
pub(crate) struct Size {
    #[arg(value_enum)]
    family: Family,
    n: usize,
    #[arg(long, default_value_t = 0.2)]
    t_end: f64,
    #[arg(long, default_value_t = 1e-6)]
    rtol: f64,
}

impl Size {
    fn text(self) -> String {
        match self.family {
            Family::Chain => link_chain(self.n),
            Family::FourBar => n_four_bar(self.n),
        }
    }

    fn name(self) -> String {
        format!("{:?} of {}", self.family, self.n)
    }

    fn model(self, text: &str) -> Result<Model, BenchError> {
        let mut model = models::model(text, &self.name())?;
        let solve = &mut model.solve;
        (solve.rtol, solve.atol, solve.t_end) = (self.rtol, self.rtol, self.t_end);
        solve.every = Some(self.t_end);
        Ok(model)
    }
}

fn refused(size: Size, message: String) -> BenchError {
    BenchError::Model { name: size.name(), message }
}

/// Runs one size in this process and prints its numbers as JSON.
#[expect(clippy::print_stdout, reason = "the output is read by the parent process")]
pub(crate) fn measure(size: Size) -> Result<(), BenchError> {
    let stop = |error: bksim::Rejected| refused(size, error.to_string());
    let text = size.text();
    let mut times = vec![cpu_time()];
    let model = size.model(&text)?;
    times.push(cpu_time());
    let mechanism = Mechanism::derive(model, Vec::new()).map_err(stop)?;
    let simulation = mechanism.simulation().map_err(stop)?;
    times.push(cpu_time());
    let start = simulation.start().map_err(stop)?;
    times.push(cpu_time());
    let mut observe = |_: &bksim::sim::run::Sample| Control::Continue;
    let summary = simulation
        .run(&start, &mut observe, &|| false)
        .map_err(|failure| refused(size, simulation.diagnose(&failure).message))?;
    times.push(cpu_time());
    let spans: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    println!(
        "{}",
        json!({
            "n": size.n, "read_s": spans[0], "derive_s": spans[1], "start_s": spans[2], "run_s": spans[3],
            "n_step": summary.stats.n_step, "peak_kib": peak_memory(),
            "energy": summary.energy.worst_error / summary.energy.scale,
        })
    );
    Ok(())
}

/// Peak memory of this process, KiB; `None` if the system does not know it.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().trim_end_matches("kB").trim().parse().ok()
}

/// Measures both families.
pub(crate) fn run(context: &Context) -> Report {
    let mut report = Report::new("scale", "Growth with size");
    for family in Family::value_variants() {
        grow(*family, context, &mut report);
    }
    for family in Family::value_variants() {
        get_ready(*family, context, &mut report);
    }
    report
}

/// Measures one family at all sizes, until one takes too long.
fn grow(family: Family, context: &Context, report: &mut Report) {
    let sizes: &[usize] =
        if context.effort.is_quick { &[10, 20] } else { &[10, 100, 1000, 10_000] };
    let mut table = Table::new([
        format!("{family:?}").as_str(),
        "derive",
        "start",
        "run",
        "steps",
        "per step",
        "exponent",
        "memory",
        "exponent",
    ]);
    // Size, time and memory of the previous size; the worst exponents.
    let mut before: Option<(f64, f64, f64)> = None;
    let (mut worst_time, mut worst_memory, mut largest) = (f64::NAN, f64::NAN, 0);
    for &n in sizes {
        // A size that fails or takes too long is the last one.
        let size = Size { family, n, t_end: 0.2, rtol: 1e-6 };
        let found = match child(size, context) {
            Ok(found) => found,
            Err(reason) => {
                report.notes.push(format!("{family:?} of {n}: {reason}"));
                break;
            }
        };

        // The exponents from the previous size to this one.
        largest = n;
        let number = |name: &str| found[name].as_f64().unwrap_or(f64::NAN);
        let step = number("run_s") / number("n_step");
        let memory = 1024.0 * number("peak_kib");
        let exponents = before.map(|(size, time, held)| {
            let growth = (n as f64 / size).ln();
            [(step / time).ln() / growth, (memory / held).ln() / growth]
        });
        let [by_time, by_memory] = exponents.unwrap_or([f64::NAN; 2]);
        (worst_time, worst_memory) = (worst_time.max(by_time), worst_memory.max(by_memory));
        before = Some((n as f64, step, memory));

        // Its row of the table and its numbers.
        let mut row = vec![n.to_string()];
        row.extend(["derive_s", "start_s", "run_s"].map(|name| seconds(number(name))));
        row.extend([found["n_step"].to_string(), seconds(step), ratio(by_time)]);
        row.extend([format!("{:.1} MiB", memory / 1_048_576.0), ratio(by_memory)]);
        table.push(row);
        report.numbers.insert(format!("{family:?} {n}"), found);
    }
    report.tables.push(table);

    // The goals of the family.
    let last = sizes[sizes.len() - 1];
    report.checks.extend([
        Check::at_most(format!("{family:?}: exponent of the time per step"), worst_time, 1.1),
        Check::at_most(format!("{family:?}: exponent of the memory"), worst_memory, 1.05),
        Check::at_least(format!("{family:?}: largest size that ran"), largest as f64, last as f64),
    ]);
}

/// Measures what one family takes from its text to the first steps of its motion at all sizes, until one takes too long.
fn get_ready(family: Family, context: &Context, report: &mut Report) {
    let sizes: &[usize] = match (context.effort.is_quick, family) {
        (true, _) => &[10, 20],
        (false, Family::Chain) => &[1000, 3000, 10_000, 40_000],
        (false, Family::FourBar) => &[1000, 3000, 10_000],
    };
    let title = format!("{family:?}, ready");
    let head = ["read", "derive", "start", "together", "exponent", "memory"];
    let mut table = Table::new([title.as_str()].into_iter().chain(head));
    let mut before: Option<(usize, f64)> = None;
    let (mut worst, mut per_link) = (f64::NAN, f64::NAN);
    for &n in sizes {
        let found = match child(Size { family, n, t_end: 1e-4, rtol: 1e-6 }, context) {
            Ok(found) => found,
            Err(reason) => {
                report.notes.push(format!("{family:?} of {n}: {reason}"));
                break;
            }
        };
        let number = |name: &str| found[name].as_f64().unwrap_or(f64::NAN);
        let times = ["read_s", "derive_s", "start_s"].map(number);
        let together: f64 = times.iter().sum();
        let exponent = before.map_or(f64::NAN, |(size, time)| {
            (together / time).ln() / (n as f64 / size as f64).ln()
        });
        worst = worst.max(exponent);
        before = Some((n, together));
        let n_bodies = match family {
            Family::Chain => n,
            Family::FourBar => 2 * n + 1,
        };
        per_link = 1.024 * number("peak_kib") / n_bodies as f64;
        let mut row = vec![n.to_string()];
        row.extend(times.map(seconds));
        row.extend([seconds(together), ratio(exponent), format!("{per_link:.1} kB/body")]);
        table.push(row);
        report.numbers.insert(format!("{family:?} {n}, ready"), found);
    }
    report.tables.push(table);
    report.checks.extend([
        Check::at_most(format!("{family:?}: exponent of the time until it moves"), worst, 1.05),
        Check::at_most(format!("{family:?}: memory of a body, kB, at the largest"), per_link, 30.0),
    ]);
}

/// Measures a size in a process of its own, which is killed when it takes too long.
fn child(size: Size, context: &Context) -> Result<Value, String> {
    let text = |error: std::io::Error| error.to_string();
    let this = std::env::current_exe().map_err(text)?;
    let family = size.family.to_possible_value().expect("no family is hidden");
    let mut child = Command::new(this)
        .args(["measure", family.get_name(), &size.n.to_string()])
        .args(["--t-end", &size.t_end.to_string(), "--rtol", &size.rtol.to_string()])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .map_err(text)?;
    let limit = Duration::from_secs_f64(4.0 * context.effort.longest_s);
    let began = Instant::now();
    // A few lines of output fit into the pipe, so the child never waits for its reader.
    while child.try_wait().map_err(text)?.is_none() {
        if began.elapsed() > limit {
            child.kill().map_err(text)?;
            child.wait().map_err(text)?;
            return Err(format!("stopped after {} s", limit.as_secs()));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = child.wait_with_output().map_err(text)?;
    if !output.status.success() {
        let errors = String::from_utf8_lossy(&output.stderr);
        return Err(errors.lines().last().unwrap_or("it printed no error").to_owned());
    }
    serde_json::from_slice(&output.stdout).map_err(|error| error.to_string())
}
