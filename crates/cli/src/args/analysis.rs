//! Questions besides motion in time: what can be written.

use std::path::PathBuf;

use bksim::analysis::{About, GoalTake};
use clap::{Args, ValueEnum};

use super::mode::ModeArgs;
use super::render::Render;
use super::time::time;
use super::{ModelArgs, Tuning, assignment};

/// `NAME=VALUES`, or a name alone.
fn assignment_or_name(text: &str) -> Result<(String, String), String> {
    if text.contains('=') { assignment(text) } else { Ok((text.to_owned(), String::new())) }
}

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

/// Joints that yield.
#[derive(Args, Clone, Debug, Default)]
pub struct ComplianceArgs {
    /// Let a joint yield, `A=1e8 N/m` or `A=1e5 N m/rad` in all directions, `A.fy_joint=1e8 N/m` in one: joints that repeat
    /// each other share loads by it, all others are rigid; may be repeated.
    #[arg(long, value_name = "NAME=STIFFNESS", value_parser = assignment)]
    pub compliance: Vec<(String, String)>,
}

impl TableArgs {
    /// The file, if its ending is that of a figure.
    pub(crate) fn picture(&self) -> Option<&std::path::Path> {
        let path = self.file.as_deref()?;
        let ending = path.extension()?.to_str()?;
        ["svg", "png", "pdf"].contains(&ending).then_some(path)
    }
}

/// The arguments of `bksim kinematics`. With --assemblies, a FILE of -o that ends in .svg, .png or .pdf shows them.
#[derive(Args, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "one for each flag of the command line")]
pub struct Kinematics {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// Prescribe a measure over a range, `crank.angle=0:360 deg:361`; several move together, each value
    /// of one with that of the others. `t=0:2 s:201` moves the drives of the model. With `--limits`, the name alone.
    #[arg(long, value_name = "NAME=VALUES", value_parser = assignment_or_name)]
    pub(crate) drive: Vec<(String, String)>,
    /// Rate of a drive at every value, `25` (rad/s or m/s) or `10 deg/s`; 1 unless given. One for each drive.
    #[arg(long, value_name = "RATE", allow_hyphen_values = true)]
    pub(crate) rate: Vec<String>,
    /// Acceleration of a drive at every value; 0 unless given. One for each drive.
    #[arg(long, value_name = "ACCELERATION", allow_hyphen_values = true)]
    pub(crate) acceleration: Vec<String>,
    /// Give the third rates of all quantities, too.
    #[arg(long, requires = "drive", conflicts_with_all = ["limits", "assemblies"])]
    pub(crate) jerk: bool,
    /// Go on through dead points of the drive, which then turns back.
    #[arg(long)]
    pub(crate) through: bool,
    /// Where branches cross in the start, follow that of this number, from 1.
    #[arg(long, value_name = "N", requires = "drive", conflicts_with_all = ["limits", "assemblies"])]
    pub(crate) branch: Option<usize>,
    /// Print the ranges, dead points and transmission angles of the whole motion; with `--drive NAME`, also
    /// time ratios and fastest motions of the outputs.
    #[arg(long, conflicts_with_all = ["assemblies", "through"])]
    pub(crate) limits: bool,
    /// With `--limits`: a measure whose time ratio and fastest motions are printed; may be repeated.
    #[arg(long = "of", value_name = "NAME", requires = "limits")]
    pub(crate) of: Vec<String>,
    /// With `--limits`: those of all assemblies, not of the start's alone.
    #[arg(long, requires = "limits")]
    pub(crate) all: bool,
    /// Print the ways in which the start closes.
    #[arg(long, conflicts_with = "drive")]
    pub(crate) assemblies: bool,
    /// Find the value of a parameter with which the start closes at all the positions that it states; may be repeated.
    #[arg(long, value_name = "NAME", conflicts_with_all = ["drive", "limits", "assemblies"])]
    pub(crate) solve: Vec<String>,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}

impl Kinematics {
    /// The file to draw the assemblies in, by its ending.
    pub(crate) fn picture(&self) -> Option<&std::path::Path> {
        if self.assemblies { self.table.picture() } else { None }
    }
}

/// With nothing named, the points that no joint connects.
#[derive(Args, Debug)]
pub(crate) struct Curves {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// A point whose way is traced: `coupler.P`, a joint, or a body for its centre of mass; may be repeated.
    #[arg(long, visible_alias = "path", value_name = "POINT")]
    pub(crate) point: Vec<String>,
    /// A body whose centrodes are traced against the ground, or against another body, `coupler/crank`; may be
    /// repeated.
    #[arg(long, value_name = "BODY[/BODY]")]
    pub(crate) centrode: Vec<String>,
    /// A body whose swept region is computed; may be repeated.
    #[arg(long, value_name = "BODY")]
    pub(crate) swept: Vec<String>,
    /// Show where a point of a mechanism with two free motions or more can be brought; may be repeated.
    #[arg(long, value_name = "POINT", conflicts_with_all = ["point", "centrode", "swept", "all"])]
    pub(crate) workspace: Vec<String>,
    /// Trace all assemblies, not that of the start alone.
    #[arg(long)]
    pub(crate) all: bool,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}

/// The arguments of `bksim polygons`. A FILE of -o that ends in .svg, .png or .pdf is drawn.
#[derive(Args, Debug)]
pub struct Polygons {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The pose: a value of a measure for each free motion, `crank.angle=40 deg`, or an instant of the drives of the model,
    /// `t=0.1 s`, which have rates of their own; may be repeated.
    #[arg(long, value_name = "NAME=VALUE", value_parser = assignment)]
    pub(crate) drive: Vec<(String, String)>,
    /// Rate of a drive, `25` (rad/s or m/s) or `10 deg/s`; 1 unless given. One for each drive.
    #[arg(long, value_name = "RATE", allow_hyphen_values = true)]
    pub(crate) rate: Vec<String>,
    /// Acceleration of a drive; 0 unless given. One for each drive.
    #[arg(long, value_name = "ACCELERATION", allow_hyphen_values = true)]
    pub(crate) acceleration: Vec<String>,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}

#[derive(Args, Debug)]
pub(crate) struct Cam {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// A curve of type `cam` or `cam-law`; the only one of the model if it is not named.
    pub(crate) curve: Option<String>,
    /// Print the path of the centre of a cutter of this radius, `5 mm`.
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
    pub(crate) compliance: ComplianceArgs,
    /// Bound a reaction that is not unique, `A.fy=0:500 N`, or the effort of a drive, `motor.effort=20 N m`; may be
    /// repeated.
    #[arg(long, value_name = "NAME=VALUES", value_parser = assignment, conflicts_with_all = ["over", "solve"])]
    pub(crate) bound: Vec<(String, String)>,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}

/// The arguments of `bksim linearize`. A FILE of -o that ends in .npz or .mat has the matrices for NumPy or MATLAB.
#[derive(Args, Debug)]
pub(crate) struct Linearize {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The state that the equations are linear about: `static`, the equilibrium nearest to the start, whatever its stability;
    /// `stable`, the nearest stable one; `2`, the second one as `bksim static` lists them; `start` as it is, or the run at an
    /// instant, `t=1 s`.
    #[arg(long, value_name = "STATE", default_value = "static")]
    pub(crate) at: About,
    /// An input: a parameter of loads, or a measure that an effort works on, `crank.angle` for a torque on
    /// the crank; may be repeated.
    #[arg(long, value_name = "NAME")]
    pub(crate) input: Vec<String>,
    /// An output: a measure, `rocker.angle` or `rocker.rate`; may be repeated.
    #[arg(long, visible_alias = "of", value_name = "NAME")]
    pub(crate) output: Vec<String>,
    /// A measure whose deviation and rate are states, in place of a coordinate; one for each free motion.
    #[arg(long, value_name = "NAME")]
    pub(crate) state: Vec<String>,
    /// Print the matrices in letters, too, with a certificate; of small mechanisms at rest, by coordinates.
    #[arg(long, conflicts_with_all = ["state", "at"])]
    pub(crate) letters: bool,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}

/// The arguments of `bksim modes`. A FILE of -o that ends in .gif, .mp4, .apng, .svg or .png shows the mode --mode.
#[derive(Args, Debug)]
pub struct Modes {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The pose that motions are small about: `static`, the equilibrium nearest to the start, whatever its stability; `stable`, the
    /// nearest stable one; `2`, the second one as `bksim static` lists them, or `start`, as if at rest.
    #[arg(long, value_name = "STATE", default_value = "static")]
    pub(crate) at: About,
    /// The mode that a film or picture shows: 1 is the first one, which it is unless given.
    #[arg(long, value_name = "N")]
    pub(crate) mode: Option<usize>,
    /// Largest change of a body's angle, `10 deg`, or, where no body turns, of a position, `5 mm`.
    #[arg(long, value_name = "SIZE")]
    pub(crate) amplitude: Option<String>,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}

impl Modes {
    /// The film or picture that is asked for, if one is.
    pub fn picture(&self) -> Option<Render> {
        let path = self.table.file.as_deref()?;
        let ending = path.extension()?.to_str()?;
        if !["gif", "mp4", "apng", "svg", "png"].contains(&ending) {
            return None;
        }
        let mode = ModeArgs {
            mode: Some(self.mode.unwrap_or(1)),
            amplitude: self.amplitude.clone(),
            mode_at: self.at,
        };
        let force = self.table.force;
        Some(Render { force, mode, ..Render::of(&self.model, path) })
    }
}

/// The arguments of `bksim bode`.
#[derive(Args, Debug)]
pub struct Bode {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The state that the equations are linear about: `static`, the equilibrium nearest to the start, whatever its stability;
    /// `stable`, the nearest stable one; `2`, the second one as `bksim static` lists them; `start` as it is, or the run at an
    /// instant, `t=1 s`.
    #[arg(long, value_name = "STATE", default_value = "static")]
    pub(crate) at: About,
    /// An input, as of `bksim linearize`; may be repeated.
    #[arg(long, value_name = "NAME")]
    pub(crate) input: Vec<String>,
    /// An output, as of `bksim linearize`; may be repeated.
    #[arg(long, visible_alias = "of", value_name = "NAME")]
    pub(crate) output: Vec<String>,
    /// Frequencies in even steps of their logarithm, `0.1:100 rad/s:201`; a decade beyond the poles unless given.
    #[arg(long, value_name = "VALUES")]
    pub(crate) omega: Option<String>,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}

#[derive(Args, Debug)]
pub(crate) struct Verify {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// End of the runs, s; that of the model unless given.
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = time)]
    pub(crate) t_end: Option<f64>,
    /// The longest that each of the runs may take, in seconds of the clock; what they have reached then is compared.
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0)]
    pub(crate) patience: f64,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}

/// With no quantity named, the derivatives by all parameters and stated initial values that have one.
#[derive(Args, Debug)]
pub(crate) struct Gradient {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// A quantity of the run: `theta1`, `theta1_dot`, `energy.total`, `reactions.B.fx`, `signals.u`, `rod.B.x`, as
    /// columns of derivatives in a log are named.
    #[arg(long, value_name = "NAME")]
    pub(crate) of: String,
    /// The number that is made of it.
    #[arg(long, value_enum, value_name = "WHICH", default_value = "last")]
    pub(crate) value: Take,
    /// A parameter (`l1`) or stated initial value (`A.rate`) that the derivative is by; may be repeated.
    #[arg(long, value_name = "NAME")]
    pub(crate) by: Vec<String>,
    #[command(flatten)]
    pub(crate) tuning: Tuning,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}

/// One number of a quantity over time.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub(crate) enum Take {
    /// Value at the end.
    Last,
    /// Mean over time.
    Mean,
    /// The root of the mean of its square over time.
    Rms,
    /// Largest sample.
    Max,
    /// Smallest sample.
    Min,
}

impl From<Take> for GoalTake {
    fn from(word: Take) -> Self {
        match word {
            Take::Last => Self::Last,
            Take::Mean => Self::Mean,
            Take::Rms => Self::Rms,
            Take::Max => Self::Max,
            Take::Min => Self::Min,
        }
    }
}

/// The arguments of `bksim doctor`. A FILE of -o that ends in .svg shows every free motion as it moves and the conditions that
/// repeat others; .png and .pdf do so with both ends of the motions.
#[derive(Args, Debug)]
pub struct Doctor {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// Print the singular poses along the whole motion with this measure as its drive, `crank.angle`.
    #[arg(long, value_name = "NAME")]
    pub(crate) drive: Option<String>,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}

/// The arguments of `bksim inverse`. A FILE of -o that ends in .svg, .png or .pdf shows efforts over speeds.
#[derive(Args, Debug)]
pub struct Inverse {
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    /// The motion of a joint, body or point: a formula of t and parameters in SI or with units, `A.angle=0.4+6*t`,
    /// `S.position=100 mm*sin(2 rad/s*t)`, a table of times and values with units in its heading, `A.angle=@motion.csv`, or a
    /// log, `A.angle=@run.mcap`; the drives of the model move, too.
    #[arg(long, value_name = "NAME=MOTION", value_parser = assignment)]
    pub(crate) motion: Vec<(String, String)>,
    /// Smoothing of tables: Σ (s − x)² + N ∫ s″² dt is smallest; 0 goes through all values.
    #[arg(long, value_name = "N", default_value_t = 0.0)]
    pub(crate) smoothing: f64,
    /// Times, `0:0.8 s:37`; those of the model's solution, 101 of them, unless given.
    #[arg(long, value_name = "TIMES")]
    pub(crate) times: Option<String>,
    /// A joint or drive that has an effort, in place of the drives of the model and the joints of the motions; may be
    /// repeated.
    #[arg(long, value_name = "NAME")]
    pub(crate) actuator: Vec<String>,
    /// The largest effort of an actuator, `A=12 N m`; may be repeated.
    #[arg(long, value_name = "NAME=EFFORT", value_parser = assignment)]
    pub(crate) limit: Vec<(String, String)>,
    /// The curve of a motor, speeds and largest efforts: a table of the model, `A=motor`, or of a file, `A=@motor.csv`;
    /// may be repeated.
    #[arg(long, value_name = "NAME=TABLE", value_parser = assignment)]
    pub(crate) curve: Vec<(String, String)>,
    #[command(flatten)]
    pub(crate) compliance: ComplianceArgs,
    #[command(flatten)]
    pub(crate) table: TableArgs,
}
