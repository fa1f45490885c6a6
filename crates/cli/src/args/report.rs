//! The arguments of `bksim report`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::run::RunArgs;

/// The numbers of a run: limits, strokes, time ratios, largest velocities, efforts, reactions, energies.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Report {
    #[command(flatten)]
    pub(crate) run: RunArgs,
    /// How the report is written; text unless the name of the file says otherwise.
    #[arg(long, value_enum)]
    pub(crate) format: Option<ReportFormat>,
    /// The report; its ending chooses the format (.txt, .md, .json), or, as .csv, the sheet of the largest pin forces. Standard output
    /// if none.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Overwrite an existing file.
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub(crate) enum ReportFormat {
    /// Text in columns.
    Text,
    /// Tables of Markdown.
    Markdown,
}

const EXAMPLES: &str = "\
Examples:
  bksim report quick_return.mcap
  bksim report quick_return.toml --units mm,deg,rpm
  bksim report run.mcap -o report.md
  bksim report quick_return.toml --units mm,deg,kN -o pins.csv";
