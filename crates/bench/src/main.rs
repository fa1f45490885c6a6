//! `bksim-bench`: our numbers against those of other programs, measured in one run.
//!
//! ```text
//! cargo run --release -p bksim-bench -- precision [PROBLEM…] [--pictures DIRECTORY]
//! cargo run --release -p bksim-bench -- random [--count COUNT] [--keep FOLDER]
//! cargo run --release -p bksim-bench -- mechanisms | balls | scale | stiffness | sweep | sensitivity | waits
//! ```
//!
//! Every suite prints a table, and below it each goal with the number found. Times are CPU times
//! and mean little by themselves; their ratio within one run counts. Peers (Exudyn, MuJoCo, Pinocchio,
//! RADAU5 and others) are optional: a missing one is named.

mod balls;
mod error;
mod machines;
mod mechanisms;
mod models;
mod peers;
mod precision;
mod race;
mod random;
mod report;
mod scale;
mod sensitivity;
mod stiffness;
mod sweep;
mod timing;
mod waits;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::error::BenchError;
use crate::peers::{Context, Peers};
use crate::report::Report;
use crate::timing::Effort;

/// Benchmarks of bksim against other programs.
#[derive(Parser, Debug)]
#[command(version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    options: Options,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Work against precision of the integrators on published mechanisms.
    Precision {
        /// Problems to solve (pendulum, caraxis, andrews, slidercrank); all of them by default.
        problems: Vec<String>,
        /// Writes a work–precision diagram of each problem into DIRECTORY.
        #[arg(long, value_name = "DIRECTORY")]
        pictures: Option<PathBuf>,
    },
    /// Mechanisms at random, planar and spatial, next to another formulation.
    Random(random::Numbers),
    /// The five-link mechanism, model file to log, against Exudyn, MuJoCo and Pinocchio.
    Mechanisms,
    /// Chains of spherical joints, an arm and a six-legged platform against Pinocchio, MuJoCo and Exudyn.
    Balls,
    /// Time and memory against size.
    Scale,
    /// The method that `auto` chooses against the better of its two.
    Stiffness,
    /// Cases of a sweep against single runs, and two threads against one.
    Sweep,
    /// A motion with its derivatives by parameters against the runs that differences take.
    Sensitivity,
    /// Waits of a person, by CPU time, each with its goal.
    Waits,
    /// One size of `scale`, in a process of its own.
    #[command(hide = true)]
    Measure(scale::Size),
}

/// Options of all benchmarks.
#[derive(clap::Args, Debug)]
struct Options {
    /// Writes all numbers to FILE.
    #[arg(long, value_name = "FILE", global = true)]
    json: Option<PathBuf>,
    /// Writes all tables to FILE, as Markdown.
    #[arg(long, value_name = "FILE", global = true)]
    markdown: Option<PathBuf>,
    /// Runs our own part alone.
    #[arg(long, global = true)]
    without_peers: bool,
    /// Small sizes and few runs, to check that everything works; the numbers mean nothing.
    #[arg(long, global = true)]
    quick: bool,
    /// The command to time; by default `bksim` in the folder of this program.
    #[arg(long, value_name = "PROGRAM", global = true)]
    bksim: Option<PathBuf>,
    /// Python with the packages of requirements.txt.
    #[arg(long, value_name = "PROGRAM", default_value = "python3", global = true)]
    python: String,
    /// C compiler.
    #[arg(long, value_name = "PROGRAM", default_value = "gcc", global = true)]
    cc: String,
}

impl Options {
    fn context(&self) -> Context {
        let peers =
            if self.without_peers { Peers::none() } else { Peers::new(&self.python, &self.cc) };
        let effort = if self.quick { Effort::QUICK } else { Effort::FULL };
        let neighbour = || {
            let this = std::env::current_exe().unwrap_or_default();
            this.with_file_name(format!("bksim{}", std::env::consts::EXE_SUFFIX))
        };
        Context { peers, program: self.bksim.clone().unwrap_or_else(neighbour), effort }
    }
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    match run(&cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// A suite as a function of its surroundings.
type Suite = fn(&Context) -> Result<Report, BenchError>;

fn run(cli: &Cli) -> Result<(), BenchError> {
    let options = &cli.options;
    let suites: &[(&str, Suite)] = match &cli.command {
        Command::Precision { problems, pictures } => {
            let problems = precision::chosen(problems)?;
            let run = |problem: &precision::Definition, context: &Context| {
                precision::run(*problem, context, pictures.as_deref())
            };
            return run_all(&problems, run, options);
        }
        Command::Random(numbers) => {
            let run = |_: &&str, context: &Context| random::measure(context, numbers);
            return run_all(&["random"], run, options);
        }
        Command::Measure(size) => return scale::measure(*size),
        Command::Mechanisms => &[("mechanisms", mechanisms::run)],
        Command::Balls => &[("balls", balls::measure), ("machines", machines::measure)],
        Command::Scale => &[("scale", |context| Ok(scale::run(context)))],
        Command::Stiffness => &[("stiffness", stiffness::measure)],
        Command::Sweep => &[("sweep", sweep::measure)],
        Command::Sensitivity => &[("sensitivity", sensitivity::run)],
        Command::Waits => &[("waits", waits::measure)],
    };
    run_all(suites, |(_, suite), context| suite(context), options)
}

/// Runs suites one after the other, prints each report and writes all of them.
#[expect(clippy::print_stdout, reason = "the tables are the result")]
fn run_all<S: std::fmt::Debug>(
    suites: &[S],
    run: impl Fn(&S, &Context) -> Result<Report, BenchError>,
    options: &Options,
) -> Result<(), BenchError> {
    let context = options.context();
    let mut reports = Vec::new();
    for suite in suites {
        let report = run(suite, &context)?;
        print!("{report}");
        reports.push(report);
    }
    let write = |path: &PathBuf, text: String| {
        std::fs::write(path, text).map_err(|source| BenchError::io(path, source))
    };
    if let Some(path) = &options.json {
        write(path, Report::all_to_json(&reports))?;
    }
    if let Some(path) = &options.markdown {
        let texts: Vec<String> = reports.iter().map(Report::to_markdown).collect();
        write(path, texts.join("\n"))?;
    }
    Ok(())
}
