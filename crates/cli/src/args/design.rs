//! The arguments of `bksim optimize`, `fit`, `tolerance` and `synthesize`.

use std::path::PathBuf;

use clap::Args;

use super::{ModelArgs, Tuning, assignment};

/// A picture of the answer.
#[derive(Args, Debug)]
pub struct Drawn {
    /// Draw the answer: the front of two objectives, fitted curves with their bands, what parts contribute, or bands over
    /// a range. The ending chooses the format (.svg, .png, .pdf).
    #[arg(long, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// Overwrite existing files.
    #[arg(long)]
    pub force: bool,
}

/// The best values of parameters: an objective, ranges and conditions.
#[derive(Args, Debug)]
#[command(after_help = OPTIMIZE_EXAMPLES)]
pub struct Optimize {
    /// The model.
    #[command(flatten)]
    pub model: ModelArgs,
    /// Make this number of the mechanism least, in place of what `[optimize]` says.
    #[arg(long, value_name = "OUTPUT", conflicts_with = "maximize")]
    pub minimize: Option<String>,
    /// Make this number largest.
    #[arg(long, value_name = "OUTPUT")]
    pub maximize: Option<String>,
    /// Vary a parameter or a stated initial value, besides those of `[optimize]`: `l1=80 mm:120 mm`.
    #[arg(long, value_name = "NAME=FROM:TO", value_parser = assignment)]
    pub vary: Vec<(String, String)>,
    /// Keep to a condition, besides those of `[optimize]`: "max(A.angle) <= 40 deg".
    #[arg(long, value_name = "CONDITION")]
    pub subject_to: Vec<String>,
    /// `motion`, `static`, or positions over a range: "crank.angle=0:360 deg:361".
    #[arg(long, value_name = "WHAT")]
    pub over: Option<String>,
    /// Try so many points of the ranges and follow the best, besides the model's own values.
    #[arg(long, value_name = "N")]
    pub starts: Option<u64>,
    /// Go on from where the starts of an earlier answer are, a file of `--json`, such as one that was stopped.
    #[arg(long, value_name = "FILE", conflicts_with = "starts")]
    pub resume: Option<PathBuf>,
    /// Write the model with the values of the optimum; all else in it stays as it is.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Picture of the front, and whether files are replaced.
    #[command(flatten)]
    pub drawn: Drawn,
    /// Settings of every run.
    #[command(flatten)]
    pub tuning: Tuning,
}

const OPTIMIZE_EXAMPLES: &str = "\
Examples:
  bksim optimize press.toml -o better.toml
  bksim optimize lamp.toml --minimize 'rms(outputs.moment)' --vary 'k=100:3000 N/m'";

/// Unknowns of a model and of sensors from measured curves.
#[derive(Args, Debug)]
#[command(after_help = FIT_EXAMPLES)]
pub struct Fit {
    /// The model.
    #[command(flatten)]
    pub model: ModelArgs,
    /// A table of measurements (CSV), units in its first line: `t [s], theta [deg]`. Several are several runs.
    #[arg(long, value_name = "FILE", required = true)]
    pub data: Vec<PathBuf>,
    /// Find a parameter or initial value, besides those of `[fit]`; with a value to begin with if wanted: `k=55 N/m`.
    #[arg(long, value_name = "NAME[=START]")]
    pub vary: Vec<String>,
    /// Compare a column with a formula, besides those of `[fit]`: "theta=A.angle - offset".
    #[arg(long, value_name = "COLUMN=FORMULA", value_parser = assignment)]
    pub compare: Vec<(String, String)>,
    /// Write the model with the estimates; all else in it stays as it is.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Picture of the curves with their bands, and whether files are replaced.
    #[command(flatten)]
    pub drawn: Drawn,
    /// Settings of every run.
    #[command(flatten)]
    pub tuning: Tuning,
}

const FIT_EXAMPLES: &str = "\
Examples:
  bksim fit pendulum.toml --data swing.csv -o fitted.toml --plot swing.svg
  bksim fit drive.toml --data up.csv --data down.csv --vary c --json";

/// The effect of limits of lengths on poses: proved bounds, slopes, samples.
#[derive(Args, Debug)]
#[command(after_help = TOLERANCE_EXAMPLES)]
pub struct Tolerance {
    /// The model.
    #[command(flatten)]
    pub model: ModelArgs,
    /// A result, besides those of `[tolerance]`: `rocker.angle`, "slider.P.x - d".
    #[arg(long, value_name = "FORMULA")]
    pub of: Vec<String>,
    /// Limits of a parameter, besides those of `[tolerance]`: "l1=±0.1 mm".
    #[arg(long, value_name = "NAME=LIMIT", value_parser = assignment)]
    pub limit: Vec<(String, String)>,
    /// Play of a pin, half of the difference of both diameters, besides that of `[tolerance]`: "B=0.02 mm".
    #[arg(long, value_name = "JOINT=LENGTH", value_parser = assignment)]
    pub play: Vec<(String, String)>,
    /// Ask at a position, or at several of a range, in place of `[tolerance]`: "A.angle=0:360 deg:37".
    #[arg(long, value_name = "NAME=VALUES", value_parser = assignment)]
    pub at: Vec<(String, String)>,
    /// `uniform`, `normal` or `triangular`.
    #[arg(long, value_name = "WORD")]
    pub distribution: Option<String>,
    /// Samples of each pose.
    #[arg(long, value_name = "N")]
    pub samples: Option<u64>,
    /// Other samples for each seed.
    #[arg(long, value_name = "SEED")]
    pub seed: Option<u64>,
    /// Limit that a result is to keep, by the cheapest limits of the parts: "rocker.angle=±0.4 deg".
    #[arg(long, value_name = "FORMULA=LIMIT", value_parser = assignment)]
    pub keep: Vec<(String, String)>,
    /// Cost of a limit of a part, in its SI unit; others keep theirs. All cost alike unless given: `a=2`.
    #[arg(long, value_name = "NAME=NUMBER", value_parser = assignment)]
    pub weight: Vec<(String, String)>,
    /// How limits add up to what is kept: `worst`, unless given, or `squares`.
    #[arg(long, value_name = "WORD")]
    pub by: Option<String>,
    /// Write the model with the cheapest limits.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Picture of contributors or, of several poses, of bands, and whether files are replaced.
    #[command(flatten)]
    pub drawn: Drawn,
}

const TOLERANCE_EXAMPLES: &str = "\
Examples:
  bksim tolerance clamp.toml --plot contributors.svg
  bksim tolerance four_bar.toml --of D.angle --limit 'a=±0.1 mm' --at 'A.angle=40 deg'
  bksim tolerance four_bar.toml --keep 'rocker.angle=±0.4 deg' -o cheaper.toml";

/// Linkages for a task, each a model that solves.
#[derive(Args, Debug)]
#[command(after_help = SYNTHESIZE_EXAMPLES)]
pub struct Synthesize {
    /// The task, a file with a table `[synthesize]`.
    pub task: PathBuf,
    /// Write the model of every linkage into this folder: NAME-1.toml, NAME-2.toml, …
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Overwrite existing files.
    #[arg(long)]
    pub force: bool,
}

const SYNTHESIZE_EXAMPLES: &str = "\
Examples:
  bksim synthesize task.toml
  bksim synthesize wiper.toml -o candidates";
