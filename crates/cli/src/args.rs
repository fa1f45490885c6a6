//! The command line: what can be written, with its help.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

/// A drawn mechanism becomes equations a person can read, and motion they can trust.
#[derive(Parser, Debug)]
#[command(name = "bksim", version, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Print one JSON object on stdout instead of text.
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// How deeply tables, arrays and parentheses of a model may nest.
    #[arg(long, global = true, default_value_t = 64, value_name = "N")]
    pub(crate) max_nesting: usize,
}

#[derive(Subcommand, Debug)]
pub(crate) enum Command {
    /// Write a small commented model that solves.
    New(New),
    /// Read a model, report every fault, and count its degrees of freedom.
    Check(ModelArgs),
    /// Print T, V, the Lagrange equations with multipliers and the constraints.
    Equations(Equations),
    /// Find the consistent start.
    Assemble(ModelArgs),
    /// Solve a model and log its motion.
    Solve(Solve),
    /// Write channels of a log as CSV or Parquet.
    Export(Export),
    /// Explain a diagnostic code, or list them all.
    Explain(Explain),
}

#[derive(Args, Debug)]
pub(crate) struct New {
    /// Name of the model; the file is NAME.toml.
    pub(crate) name: String,
    /// Overwrite an existing file.
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Args, Debug)]
pub(crate) struct ModelArgs {
    /// The model file.
    pub(crate) model: PathBuf,
    /// Give a parameter another value: a number, a quantity such as "25 mm", or an expression.
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = assignment)]
    pub(crate) set: Vec<(String, String)>,
}

#[derive(Args, Debug)]
pub(crate) struct Equations {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// How formulas are written.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(crate) format: Format,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub(crate) enum Format {
    /// Infix text.
    Text,
    /// LaTeX, one aligned block per group.
    Latex,
    /// The same as --json.
    Json,
}

#[derive(Args, Debug)]
pub(crate) struct Solve {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The log; NAME.mcap in the working directory unless given.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite an existing log.
    #[arg(long)]
    pub(crate) force: bool,
    /// End time, s, in place of the model's.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) t_end: Option<f64>,
    /// Relative tolerance, in place of the model's.
    #[arg(long, value_name = "TOL", allow_negative_numbers = true)]
    pub(crate) rtol: Option<f64>,
    /// Absolute tolerance, in place of the model's.
    #[arg(long, value_name = "TOL", allow_negative_numbers = true)]
    pub(crate) atol: Option<f64>,
    /// Fixed steps of this size, s, without error control.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,
    /// Output interval, s, in place of the model's.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) every: Option<f64>,
    /// The form of the equations that is integrated.
    #[arg(long, value_enum, value_name = "FORM")]
    pub(crate) formulation: Option<Formulation>,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub(crate) enum Formulation {
    /// Stabilised index 2 (Gear, Gupta and Leimkuhler).
    Ggl,
    /// Velocity constraints only.
    Index2,
    /// Position constraints only.
    Index3,
}

#[derive(Args, Debug)]
pub(crate) struct Export {
    /// The log.
    pub(crate) log: PathBuf,
    /// Channels: `state.A_angle`, a whole topic `energy`, or a pattern `reactions.*`. All if none.
    pub(crate) channels: Vec<String>,
    /// The table; its ending chooses the format (.csv, .parquet). Standard output, as CSV, if none.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite an existing file.
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Args, Debug)]
pub(crate) struct Explain {
    /// The code, such as M012; without one, all codes are listed.
    pub(crate) code: Option<String>,
}

fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
            Ok((name.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err("expected NAME=VALUE, such as l1=0.8 or l1=\"25 mm\"".to_owned()),
    }
}
