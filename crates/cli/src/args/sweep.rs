//! `bksim sweep`: what can be written.

use std::path::PathBuf;

use clap::Args;

use super::analysis::ComplianceArgs;
use super::{DrawingArgs, Tuning, assignment};

/// One model at many values of its parameters.
#[derive(Args, Debug)]
pub struct Sweep {
    /// The model file, or a drawing (DXF, DWG).
    pub model: PathBuf,
    /// Vary a parameter or a stated initial value: `l1=0.8:1.2:41` for 41 values, `l1=0.8,0.9` for
    /// these, `k=1:1000:4:log` at even ratios, `l1=0.8:1.2` for samples; or give it one value, as
    /// in `solve`. Several make a grid of all their values.
    #[arg(long = "set", value_name = "NAME=VALUES", value_parser = assignment)]
    pub set: Vec<(String, String)>,
    /// Take this load case of the model's `[cases]`.
    #[arg(long, value_name = "NAME")]
    pub case: Option<String>,
    /// How a drawing is read.
    #[command(flatten)]
    pub drawing: DrawingArgs,
    /// Take one value of every axis after the other, in place of a grid.
    #[arg(long, conflicts_with_all = ["random", "lhs", "sobol"])]
    pub pairs: bool,
    /// Vary what the columns of this table name, one case a row: `l1 [mm], m2` in its first line.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["random", "lhs", "sobol"])]
    pub cases: Option<PathBuf>,
    /// Keep this of each run: `max(reactions.B.fx)`, `final(rod.B.x)`, `theta@0.5`; also `min`, `mean`,
    /// `rms`, `peak_to_peak`, `quantile(x, 0.95)`, `first(x > 1 m)`, and expressions of them. The final,
    /// smallest and largest values of all coordinates unless given.
    #[arg(long, value_name = "OUTPUT")]
    pub keep: Vec<String>,
    /// The table; NAME.parquet in the working directory unless given.
    #[arg(short, long, value_name = "FILE", alias = "output")]
    pub out: Option<PathBuf>,
    /// Log the runs of these cases, as `solve` does: `3,7,10-12`, `all`, `failed`, `largest COLUMN`, `smallest
    /// COLUMN`, or comparisons, "max(reactions.B.fx) > 2 kN and l1 < 0.9 m". The logs stand next to the table:
    /// TABLE-3.mcap.
    #[arg(long, value_name = "WHICH")]
    pub log_cases: Option<String>,
    /// The folder of these logs, in place of the table's.
    #[arg(long, value_name = "FOLDER", requires = "log_cases")]
    pub logs: Option<PathBuf>,
    /// Independent samples in place of a grid.
    #[arg(long, value_name = "N", conflicts_with_all = ["lhs", "sobol"])]
    pub random: Option<u64>,
    /// Samples of a Latin hypercube: one in each of N parts of every axis.
    #[arg(long, value_name = "N", conflicts_with = "sobol")]
    pub lhs: Option<u64>,
    /// Points of Sobol's sequence, with Owen's scrambling; best a power of two.
    #[arg(long, value_name = "N")]
    pub sobol: Option<u64>,
    /// Other samples for each seed.
    #[arg(long, value_name = "SEED", default_value_t = 0)]
    pub seed: u64,
    /// Threads; one per core unless given, at most 16 per core and one per case. The table does not depend on it.
    #[arg(short, long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    pub jobs: usize,
    /// Go on with a sweep that was interrupted.
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
    /// Overwrite an existing table, and begin again where a sweep was interrupted.
    #[arg(long)]
    pub force: bool,
    /// Joints that yield in every solution.
    #[command(flatten)]
    pub compliance: ComplianceArgs,
    /// Settings of every solution.
    #[command(flatten)]
    pub tuning: Tuning,
}
