//! `bksim-bench`: our numbers beside those of other programs, measured in one run.
//!
//! ```text
//! cargo run --release -p bksim-bench -- algebra [SUITE…] [--json FILE]
//! ```
//!
//! Every suite prints a table, and below it each goal with what was found. Times are CPU times and
//! mean little by themselves; what counts is their ratio within one run. Peers (SymPy, CasADi,
//! Symbolica, a C compiler) are optional: a missing one is named.

mod algebra;
mod error;
mod models;
mod peers;
mod report;
mod timing;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::error::BenchError;
use crate::peers::Peers;
use crate::report::Report;

/// Benchmarks of bksim against other programs.
#[derive(Parser, Debug)]
#[command(version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// The algebra: folding, operation counts, derivation, gradients, evaluation.
    Algebra(AlgebraArgs),
}

#[derive(clap::Args, Debug)]
struct AlgebraArgs {
    /// Suites to run; all of them by default.
    #[arg(value_enum)]
    suites: Vec<algebra::Suite>,
    #[command(flatten)]
    options: Options,
}

/// What all benchmarks have in common.
#[derive(clap::Args, Debug)]
struct Options {
    /// Writes all numbers to FILE.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Runs our own part alone.
    #[arg(long)]
    without_peers: bool,
    /// Small sizes and few runs, to see that everything works; the numbers mean nothing.
    #[arg(long)]
    quick: bool,
    /// Python with the packages of requirements.txt.
    #[arg(long, value_name = "PROGRAM", default_value = "python3")]
    python: String,
    /// C compiler.
    #[arg(long, value_name = "PROGRAM", default_value = "gcc")]
    cc: String,
}

/// What a suite is given.
#[derive(Debug)]
struct Context {
    peers: Peers,
    effort: timing::Effort,
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

#[expect(clippy::print_stdout, reason = "the tables are the result")]
fn run(cli: &Cli) -> Result<(), BenchError> {
    let Command::Algebra(args) = &cli.command;
    let options = &args.options;
    let context = Context {
        peers: if options.without_peers {
            Peers::none()
        } else {
            Peers::new(&options.python, &options.cc)
        },
        effort: if options.quick { timing::Effort::QUICK } else { timing::Effort::FULL },
    };
    let mut reports = Vec::new();
    for suite in algebra::chosen(&args.suites) {
        eprintln!("running {suite:?} ...");
        let report = suite.run(&context)?;
        print!("{report}");
        reports.push(report);
    }
    if let Some(path) = &options.json {
        let text = Report::all_to_json(&reports);
        std::fs::write(path, text).map_err(|source| BenchError::io(path, source))?;
    }
    Ok(())
}
