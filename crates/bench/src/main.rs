//! `bksim-bench`: our numbers against those of other programs, measured in one run.
//!
//! ```text
//! cargo run --release -p bksim-bench -- algebra [SUITE…] [--json FILE]
//! cargo run --release -p bksim-bench -- precision [PROBLEM…] [--pictures DIRECTORY]
//! cargo run --release -p bksim-bench -- mechanisms
//! cargo run --release -p bksim-bench -- scale
//! cargo run --release -p bksim-bench -- drift [SUITE…]
//! cargo run --release -p bksim-bench -- stiffness
//! cargo run --release -p bksim-bench -- sweep
//! cargo run --release -p bksim-bench -- sensitivity
//! cargo run --release -p bksim-bench -- python
//! cargo run --release -p bksim-bench -- starts
//! cargo run --release -p bksim-bench -- spatial
//! cargo run --release -p bksim-bench -- questions
//! cargo run --release -p bksim-bench -- waits
//! cargo run --release -p bksim-bench -- balls
//! cargo run --release -p bksim-bench -- elements
//! cargo run --release -p bksim-bench -- random [--count COUNT] [--keep FOLDER]
//! ```
//!
//! Every suite prints a table, and below it each goal with the number found. Times are CPU times
//! and mean little by themselves; their ratio within one run counts. Peers (SymPy, CasADi,
//! Symbolica, a C compiler) are optional: a missing one is named.

mod algebra;
mod balls;
mod context;
mod diagram;
mod drift;
mod elements;
mod error;
mod machines;
mod mechanisms;
mod models;
mod peers;
mod precision;
mod python;
mod questions;
mod race;
mod random;
mod report;
mod scale;
mod sensitivity;
mod spatial;
mod starts;
mod stiffness;
mod sweep;
mod timing;
mod waits;
mod windows;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::context::Context;
use crate::error::BenchError;
use crate::peers::Peers;
use crate::report::Report;
use crate::timing::Effort;

/// Benchmarks of bksim against other programs.
#[derive(Parser, Debug)]
#[command(version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// The algebra: folding, operation counts, derivation, gradients, evaluation, generated code.
    Algebra(AlgebraArgs),
    /// Work against precision of the integrators on published mechanisms.
    Precision(PrecisionArgs),
    /// The five-link mechanism, model file to log, against Exudyn, MuJoCo and Pinocchio.
    Mechanisms(MechanismsArgs),
    /// Time and memory against size.
    Scale(Options),
    /// The method that `auto` chooses against the better of its two.
    Stiffness(Options),
    /// Cases of a sweep against single runs, and two threads against one.
    Sweep(Options),
    /// A motion with its derivatives by parameters against the runs that differences take.
    Sensitivity(Options),
    /// A solve from Python against the same solve from Rust; needs `pip install ./crates/py`.
    Python(Options),
    /// Starts of linkages whose assemblies are all known.
    Starts(Options),
    /// M, h, g of arms, chains and trees in space against Pinocchio, and the time of an evaluation.
    Spatial(Options),
    /// Tables and assemblies of linkages, model file to answer.
    Questions(MechanismsArgs),
    /// Waits of a person, by CPU time, each with its goal.
    Waits(MechanismsArgs),
    /// Chains of spherical joints, an arm and a six-legged platform against Pinocchio, MuJoCo and Exudyn.
    Balls(Options),
    /// Time per step and events per second of examples with machine elements.
    Elements(Options),
    /// Mechanisms at random, planar and spatial, beside another formulation.
    Random(RandomArgs),
    /// Energy and constraints over long runs, and through singular poses.
    Drift(DriftArgs),
    /// One size of `scale`, in a process of its own.
    #[command(hide = true)]
    Measure(scale::Size),
}

#[derive(clap::Args, Debug)]
struct AlgebraArgs {
    /// Suites to run; all of them by default.
    #[arg(value_enum)]
    suites: Vec<algebra::AlgebraSuite>,
    #[command(flatten)]
    options: Options,
}

#[derive(clap::Args, Debug)]
struct PrecisionArgs {
    /// Problems to solve (pendulum, caraxis, andrews, slidercrank); all of them by default.
    problems: Vec<String>,
    /// Writes a work–precision diagram of each problem into DIRECTORY.
    #[arg(long, value_name = "DIRECTORY")]
    pictures: Option<PathBuf>,
    #[command(flatten)]
    options: Options,
}

#[derive(clap::Args, Debug)]
struct MechanismsArgs {
    /// The program to time; by default `bksim` in the folder of this one.
    #[arg(long, value_name = "PROGRAM")]
    bksim: Option<PathBuf>,
    #[command(flatten)]
    options: Options,
}

#[derive(clap::Args, Debug)]
struct RandomArgs {
    #[command(flatten)]
    numbers: random::Numbers,
    #[command(flatten)]
    program: MechanismsArgs,
}

#[derive(clap::Args, Debug)]
struct DriftArgs {
    /// Suites to run; all of them by default.
    #[arg(value_enum)]
    suites: Vec<drift::DriftSuite>,
    #[command(flatten)]
    options: Options,
}

/// Options of all benchmarks.
#[derive(clap::Args, Debug)]
struct Options {
    /// Writes all numbers to FILE.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Writes all tables to FILE, as Markdown.
    #[arg(long, value_name = "FILE")]
    markdown: Option<PathBuf>,
    /// Runs our own part alone.
    #[arg(long)]
    without_peers: bool,
    /// Small sizes and few runs, to check that everything works; the numbers mean nothing.
    #[arg(long)]
    quick: bool,
    /// Python with the packages of requirements.txt.
    #[arg(long, value_name = "PROGRAM", default_value = "python3")]
    python: String,
    /// C compiler.
    #[arg(long, value_name = "PROGRAM", default_value = "gcc")]
    cc: String,
}

impl Options {
    fn context(&self) -> Context {
        let peers =
            if self.without_peers { Peers::none() } else { Peers::new(&self.python, &self.cc) };
        let effort = if self.quick { Effort::QUICK } else { Effort::FULL };
        Context { peers, effort }
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

fn run(cli: &Cli) -> Result<(), BenchError> {
    match &cli.command {
        Command::Algebra(args) => {
            let suites = algebra::chosen(&args.suites);
            let run = |&suite: &algebra::AlgebraSuite, context: &Context| suite.run(context);
            run_all(suites, run, &args.options)
        }
        Command::Precision(args) => {
            let problems = precision::chosen(&args.problems)?;
            let pictures = args.pictures.as_deref();
            let run = |problem: &precision::Definition, context: &Context| {
                precision::run(*problem, context, pictures)
            };
            run_all(&problems, run, &args.options)
        }
        Command::Mechanisms(args) => {
            let program = args.bksim.as_deref();
            run_all(&["mechanisms"], |_, context| mechanisms::run(context, program), &args.options)
        }
        Command::Scale(options) => {
            run_all(&["scale"], |_, context| Ok(scale::run(context)), options)
        }
        Command::Stiffness(options) => {
            run_all(&["stiffness"], |_, context| stiffness::measure(context), options)
        }
        Command::Sweep(options) => {
            run_all(&["sweep"], |_, context| sweep::measure(context), options)
        }
        Command::Sensitivity(options) => {
            run_all(&["sensitivity"], |_, context| sensitivity::run(context), options)
        }
        Command::Python(options) => {
            run_all(&["python"], |_, context| python::measure(context), options)
        }
        Command::Starts(options) => {
            run_all(&["starts"], |_, context| Ok(starts::measure(context)), options)
        }
        Command::Spatial(options) => {
            run_all(&["spatial"], |_, context| spatial::measure(context), options)
        }
        Command::Questions(args) => {
            let program = args.bksim.as_deref();
            run_all(
                &["questions"],
                |_, context| questions::measure(context, program),
                &args.options,
            )
        }
        Command::Waits(args) => {
            let program = args.bksim.as_deref();
            run_all(&["waits"], |_, context| waits::measure(context, program), &args.options)
        }
        Command::Balls(options) => {
            let suites: [(&str, Measure); 2] =
                [("balls", balls::measure), ("machines", machines::measure)];
            run_all(&suites, |(_, suite), context| suite(context), options)
        }
        Command::Elements(options) => {
            run_all(&["elements"], |_, context| elements::measure(context), options)
        }
        Command::Random(RandomArgs { numbers, program }) => {
            let path = program.bksim.as_deref();
            let run = |_: &&str, context: &Context| random::measure(context, numbers, path);
            run_all(&["random"], run, &program.options)
        }
        Command::Drift(args) => {
            let all = <drift::DriftSuite as clap::ValueEnum>::value_variants();
            let suites = if args.suites.is_empty() { all } else { &args.suites };
            run_all(suites, |suite, context| Ok(suite.run(context)), &args.options)
        }
        Command::Measure(size) => scale::measure(*size),
    }
}

/// A suite as a function of its surroundings.
type Measure = fn(&Context) -> Result<Report, BenchError>;

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
        eprintln!("running {suite:?} ...");
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
