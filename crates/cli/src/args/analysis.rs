//! Questions besides motion in time: what can be written.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{ModelArgs, assignment};

/// Where the table of an answer goes.
#[derive(Args, Debug)]
pub(crate) struct TableArgs {
    /// Write the answer as a table (CSV) to this file.
    #[arg(short = 'o', long = "table", value_name = "FILE")]
    pub(crate) file: Option<PathBuf>,
    /// Overwrite an existing table.
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Args, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "one for each flag of the command line")]
pub(crate) struct Kinematics {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// Prescribe a measure over a range, `crank.angle=0:360 deg:361`; several move together, each value
    /// of one with that of the others. `t=0:2 s:201` moves the drives of the model.
    #[arg(long, value_name = "NAME=VALUES", value_parser = assignment)]
    pub(crate) drive: Vec<(String, String)>,
    /// Rate of a drive at every value, `25` (rad/s or m/s) or `10 deg/s`; 1 unless given. One for each drive.
    #[arg(long, value_name = "RATE", allow_negative_numbers = true)]
    pub(crate) rate: Vec<String>,
    /// Acceleration of a drive at every value; 0 unless given. One for each drive.
    #[arg(long, value_name = "ACCELERATION", allow_negative_numbers = true)]
    pub(crate) acceleration: Vec<String>,
    /// Go on through dead points of the drive, which then turns back.
    #[arg(long)]
    pub(crate) through: bool,
    /// Tell the ranges, dead points and transmission angles of the whole motion; with `--drive NAME`, also
    /// time ratios and fastest motions of the outputs.
    #[arg(long, conflicts_with_all = ["assemblies", "through"])]
    pub(crate) limits: bool,
    /// With `--limits`: a measure whose time ratio and fastest motions are told; may be repeated.
    #[arg(long = "of", value_name = "NAME", requires = "limits")]
    pub(crate) of: Vec<String>,
    /// With `--limits`: those of all assemblies, not of the start's alone.
    #[arg(long, requires = "limits")]
    pub(crate) all: bool,
    /// Tell the ways in which the start closes.
    #[arg(long, conflicts_with = "drive")]
    pub(crate) assemblies: bool,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}

#[derive(Args, Debug)]
pub(crate) struct Cam {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// A curve of type `cam` or `cam-law`; the only one of the model if it is not named.
    pub(crate) curve: Option<String>,
    /// Tell the path of the centre of a cutter of this radius, `5 mm`.
    #[arg(long, value_name = "RADIUS")]
    pub(crate) cutter: Option<String>,
    /// Rows of the table over a turn.
    #[arg(long, value_name = "N", default_value_t = 361)]
    pub(crate) rows: u16,
    /// Write the table over a turn (.csv), or draw the profile at full size (.dxf in mm, .svg).
    #[arg(short = 'o', long = "output", value_name = "FILE")]
    pub(crate) file: Option<PathBuf>,
    /// Overwrite an existing file.
    #[arg(long)]
    pub(crate) force: bool,
}

#[derive(Args, Debug)]
pub(crate) struct Static {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The measure that the stiffness is by, `crank.angle`; one for each free motion.
    #[arg(long, value_name = "NAME")]
    pub(crate) by: Vec<String>,
    /// Follow the equilibria over a range of a parameter, `k=1:5 N/m:41`, through limit points and branch points.
    #[arg(long, value_name = "NAME=VALUES", value_parser = assignment)]
    pub(crate) over: Option<(String, String)>,
    /// Find the value of a parameter with which the start is in balance; one for each free motion.
    #[arg(long, value_name = "NAME", conflicts_with = "over")]
    pub(crate) solve: Vec<String>,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}

/// The state that equations are linearised about.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub(crate) enum About {
    /// The equilibrium nearest to the start, a stable one if there is any.
    Static,
    /// The start as it is.
    Start,
}

#[derive(Args, Debug)]
pub(crate) struct Linearize {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The state that the equations are linear about.
    #[arg(long, value_enum, default_value_t = About::Static)]
    pub(crate) at: About,
    /// An input: a parameter of loads, or a measure that an effort works on, `crank.angle` for a torque on
    /// the crank; may be repeated.
    #[arg(long, value_name = "NAME")]
    pub(crate) input: Vec<String>,
    /// An output: a measure, `rocker.angle` or `rocker.rate`; may be repeated.
    #[arg(long, value_name = "NAME")]
    pub(crate) output: Vec<String>,
    /// A measure whose deviation and rate are states, in place of a coordinate; one for each free motion.
    #[arg(long, value_name = "NAME")]
    pub(crate) state: Vec<String>,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}

#[derive(Args, Debug)]
pub(crate) struct Modes {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The state that motions are small about.
    #[arg(long, value_enum, default_value_t = About::Static)]
    pub(crate) at: About,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}

/// The arguments of `bksim bode`.
#[derive(Args, Debug)]
pub struct Bode {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The state that the equations are linear about.
    #[arg(long, value_enum, default_value_t = About::Static)]
    pub(crate) at: About,
    /// An input, as of `bksim linearize`; may be repeated.
    #[arg(long, value_name = "NAME")]
    pub(crate) input: Vec<String>,
    /// An output, as of `bksim linearize`; may be repeated.
    #[arg(long, value_name = "NAME")]
    pub(crate) output: Vec<String>,
    /// Frequencies in even steps of their logarithm, `0.1:100 rad/s:201`; a decade beyond the poles unless given.
    #[arg(long, value_name = "VALUES")]
    pub(crate) omega: Option<String>,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}

impl Bode {
    /// The file to draw in, by its ending.
    pub(crate) fn picture(&self) -> Option<&std::path::Path> {
        let path = self.table.file.as_deref()?;
        let ending = path.extension()?.to_str()?;
        ["svg", "png", "pdf"].contains(&ending).then_some(path)
    }
}

#[derive(Args, Debug)]
pub(crate) struct Verify {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// End of the runs, s; that of the model unless given.
    #[arg(long, value_name = "SECONDS")]
    pub(crate) t_end: Option<f64>,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}

#[derive(Args, Debug)]
pub(crate) struct Doctor {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// Tell the singular poses along the whole motion with this measure as its drive, `crank.angle`.
    #[arg(long, value_name = "NAME")]
    pub(crate) drive: Option<String>,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}

#[derive(Args, Debug)]
pub(crate) struct Inverse {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The motion of a joint: a formula of t and parameters in SI, `A.angle=0.4+6*t`, or a table of times
    /// and values, `A.angle=@motion.csv`; the drives of the model move, too.
    #[arg(long, value_name = "NAME=MOTION", value_parser = assignment)]
    pub(crate) motion: Vec<(String, String)>,
    /// Smoothing of tables: Σ (s − x)² + N ∫ s″² dt is smallest; 0 goes through all values.
    #[arg(long, value_name = "N", default_value_t = 0.0)]
    pub(crate) smoothing: f64,
    /// Times, `0:0.8 s:37`; those of the model's solution, 101 of them, unless given.
    #[arg(long, value_name = "TIMES")]
    pub(crate) times: Option<String>,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}
