//! The arguments of `bksim report`.

use bksim::model::file::ShownUnits;
use clap::{Args, ValueEnum};

use super::ModelArgs;

/// The numbers of a run: limits, strokes, time ratios, largest velocities, efforts, reactions, energies.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Report {
    /// A log, or a model or drawing, which is solved first.
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// How the report is written.
    #[arg(long, value_enum, default_value_t = ReportFormat::Text)]
    pub(crate) format: ReportFormat,
    /// Units of the report, such as "mm, deg, rpm, kN"; `si` for SI. Those of the model's [units] unless given.
    #[arg(long = "in", value_name = "UNITS", value_parser = ShownUnits::parse)]
    pub(crate) shown: Option<ShownUnits>,
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
  bksim report quick_return.toml --in mm,deg,rpm
  bksim report run.mcap --format markdown > report.md";
