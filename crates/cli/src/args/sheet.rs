//! The arguments of `bksim sheet`.

use std::path::PathBuf;

use clap::Args;

use super::run::RunArgs;

/// The largest force of every pin over the motion and over all load cases, with its direction, instant and pose.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Sheet {
    /// The run, and the load case if it is to be one alone.
    #[command(flatten)]
    pub run: RunArgs,
    /// The sheet; its ending chooses the format: a page to print (.html, .pdf), tables (.xlsx, .csv), loads of CalculiX
    /// (.inp), or .json. Text on standard output if none.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// The body whose loads an .inp file has.
    #[arg(long, value_name = "BODY")]
    pub body: Option<String>,
    /// An instant of these loads, s, besides those of the largest forces; may be repeated.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub at: Vec<f64>,
    /// Overwrite an existing file.
    #[arg(long)]
    pub force: bool,
}

const EXAMPLES: &str = "\
Examples:
  bksim sheet press.toml
  bksim sheet press.toml -o pins.pdf --units mm,deg,kN
  bksim sheet press.toml -o pins.xlsx
  bksim sheet press.toml --case full -o rod.inp --body rod --units mm,N";
