//! [`AnalysisError`]: why a question has no answer, in the author's terms.

use bksim_expr::TapeError;
use bksim_model::AssemblyChoice;
use bksim_model::diagnostic::{Diagnostic, Rejected, Span};
use bksim_model::message::{counted, listed, short};

use crate::codes;

/// Why a question has no answer.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AnalysisError {
    /// The model itself, or its start, is at fault.
    #[error("{}", .0.0.first().map_or("", |fault| fault.message.as_str()))]
    Rejected(#[from] Rejected),
    /// An expression that cannot be compiled.
    #[error(transparent)]
    Compile(#[from] TapeError),
    /// Values that cannot be read, or have another dimension.
    #[error("`{text}` gives no {}", if .unit.is_empty() { "plain numbers".to_owned() } else { format!("values in {unit}") })]
    BadRange {
        /// As written.
        text: String,
        /// The SI unit that was expected.
        unit: String,
    },
    /// Frequencies from zero or below have no even steps of their logarithm.
    #[error(
        "`{text}` is no range of frequencies: its ends must be above zero, for it has even steps of the logarithm"
    )]
    NoFrequencies {
        /// As written.
        text: String,
    },
    /// Nothing of this name can be measured.
    #[error("no joint, body or point has the measure `{name}`")]
    UnknownMeasure {
        /// As written.
        name: String,
    },
    /// No point, joint or body has this name.
    #[error("no point, joint or body is called `{name}`")]
    UnknownPoint {
        /// As written.
        name: String,
    },
    /// No body has this name.
    #[error("no body is called `{name}`")]
    UnknownBody {
        /// As written.
        name: String,
    },
    /// A question about mechanisms that move in a plane.
    #[error("{what} belong to planar mechanisms, and this one moves in space")]
    NotPlanar {
        /// The answer that there is none of.
        what: &'static str,
    },
    /// A rate where a position was expected.
    #[error("`{name}` is a rate, not a position or an angle")]
    NotAPosition {
        /// As written.
        name: String,
    },
    /// No parameter has this name.
    #[error("no parameter is called `{name}`")]
    UnknownParameter {
        /// As written.
        name: String,
    },
    /// No cam of this name, or not one alone.
    #[error("{}", .name.as_ref().map_or_else(|| format!("the model has {} cams and laws, not one", .known.len()),
        |name| format!("no cam or law is called `{name}`")))]
    UnknownCam {
        /// As written.
        name: Option<String>,
        /// Names of cams, then of laws.
        known: Vec<String>,
    },
    /// More motions are free than are prescribed, or fewer.
    #[error("{}, and {}", are(*n_free, "free"), are(*n_driven, "prescribed"))]
    NDrives {
        /// Degrees of freedom.
        n_free: usize,
        /// Prescribed motions.
        n_driven: usize,
    },
    /// A motion in time that leaves motions free.
    #[error("{}, and {}", are(*n_free, "free"), are(*n_prescribed, "prescribed"))]
    NMotions {
        /// Degrees of freedom.
        n_free: usize,
        /// Motions that drives and motions prescribe.
        n_prescribed: usize,
    },
    /// Quantities in whose place as many free motions are to be described.
    #[error("{}, and {} named", are(*n_free, "free"), counted(*n_named, "quantity is", "quantities are"))]
    NQuantities {
        /// Degrees of freedom.
        n_free: usize,
        /// Quantities that are named.
        n_named: usize,
    },
    /// Limits are those of a mechanism with one free motion.
    #[error("{n_free} motions are free, not one")]
    NotOneMotion {
        /// Degrees of freedom.
        n_free: usize,
    },
    /// Workspaces are those of mechanisms with more than one free motion.
    #[error("{}, too few for a workspace", are(*n_free, "free"))]
    OneMotion {
        /// Degrees of freedom.
        n_free: usize,
    },
    /// No mode has this number.
    #[error("there is no mode {number}, of {n}")]
    NoMode {
        /// From one.
        number: usize,
        /// Number of modes.
        n: usize,
    },
    /// Ranges with different numbers of values.
    #[error("all ranges must have the same number of values, not {first} and {other}")]
    Counts {
        /// Of the first range.
        first: usize,
        /// Of another.
        other: usize,
    },
    /// A pose that cannot be reached from the start without a jump.
    #[error(
        "`{name}` cannot be brought from {} to {} {unit}: it stops at {} {unit}",
        short(*from), short(*to), short(*at)
    )]
    NotReached {
        /// The measure.
        name: String,
        /// Value at the start.
        from: f64,
        /// Value asked for.
        to: f64,
        /// The value at which it stops.
        at: f64,
        /// Unit of these.
        unit: &'static str,
    },
    /// Two prescribed motions follow from each other.
    #[error("the pose is singular: `{name}` does not move the mechanism there")]
    Singular {
        /// The measure.
        name: String,
    },
    /// No equilibrium was found.
    #[error("no equilibrium was found")]
    NoEquilibrium,
    /// Equilibria over a parameter that are not isolated.
    #[error("the equilibria over `{parameter}` are families: {} can be anywhere", listed(&.moves.iter().map(String::as_str).collect::<Vec<_>>()))]
    NotIsolated {
        /// The parameter.
        parameter: String,
        /// Positions of joints that change along them.
        moves: Vec<String>,
    },
    /// A component of a reaction that equilibrium leaves open.
    #[error("`{name}` is not unique: equilibrium leaves it open")]
    NotUnique {
        /// The component.
        name: String,
    },
    /// A reaction that an effort changes directly, where the effort stands for no load of a kind.
    #[error("`{output}` depends on how the effort on `{input}` works")]
    EffortInReaction {
        /// The component.
        output: String,
        /// The measure that the effort works on.
        input: String,
    },
    /// A response needs an input and an output.
    #[error("a frequency response needs an input and an output")]
    NoChannels,
    /// As many unknowns as free motions can be balanced.
    #[error("{} cannot balance {}", counted(*n_unknown, "unknown", "unknowns"), counted(*n_free, "free motion", "free motions"))]
    Unknowns {
        /// Unknown parameters.
        n_unknown: usize,
        /// Degrees of freedom.
        n_free: usize,
    },
    /// No values of parameters balance the start.
    #[error("no value of {} balances the start", listed(&.names.iter().map(String::as_str).collect::<Vec<_>>()))]
    NotBalanced {
        /// The parameters.
        names: Vec<String>,
    },
    /// A motion that does not hold together.
    #[error("the motion cannot be followed at t = {t} s")]
    Lost {
        /// s.
        t: f64,
    },
    /// States of controllers that have no finite values, or change too fast to be followed.
    #[error("the states of controllers cannot be followed beyond t = {t} s")]
    StatesLost {
        /// s.
        t: f64,
    },
    /// A sampled signal without a finite value.
    #[error("the sampled signal `{name}` has no finite value at t = {t} s")]
    NoSignal {
        /// Its name.
        name: String,
        /// s.
        t: f64,
    },
    /// A load, signal or state in the place of an actuator.
    #[error("the model itself gives `{name}` its value: no effort is left to be found")]
    GivenEffort {
        /// As written.
        name: String,
    },
    /// No joint or component of a reaction has this name.
    #[error("no joint and no component of a reaction is called `{name}`")]
    UnknownReaction {
        /// As written.
        name: String,
    },
    /// A joint that yields by what is no stiffness.
    #[error("`{text}` is no stiffness of `{name}`")]
    NoStiffness {
        /// The joint, or its component.
        name: String,
        /// As written.
        text: String,
    },
    /// No actuator has this name.
    #[error("no actuator is called `{name}`")]
    NoActuator {
        /// As written.
        name: String,
        /// Those that there are.
        known: Vec<String>,
    },
    /// Points that are no curve of a motor.
    #[error(
        "the curve of the motor of `{name}` needs two points at least, with speeds that ascend from zero or above and \
             efforts from zero on"
    )]
    BadCurve {
        /// The actuator.
        name: String,
    },
    /// No table of one argument has this name.
    #[error("no table of one argument is called `{name}`")]
    UnknownTable {
        /// As written.
        name: String,
        /// Those that there are.
        known: Vec<String>,
    },
    /// A table as the curve of a motor whose speed and effort are other quantities.
    #[error(
        "the motor of `{name}` has {} over {}, and its table {} over {}",
        if *.turns { "N m" } else { "N" }, if *.turns { "rad/s" } else { "m/s" }, named(&.units[1]), named(&.units[0])
    )]
    CurveUnits {
        /// The actuator.
        name: String,
        /// SI units of argument and value of the table.
        units: [String; 2],
        /// True of an actuator that turns.
        turns: bool,
    },
    /// States that balance the start with every value of the unknowns.
    #[error("states of controllers balance the start with any value of {}", listed(&.names.iter().map(String::as_str).collect::<Vec<_>>()))]
    StatesBalance {
        /// The parameters.
        names: Vec<String>,
    },
    /// The start does not close in this way.
    #[error("the start has no assembly {}", match .choice {
        AssemblyChoice::Number(number) => number.to_string(),
        AssemblyChoice::Name(name) => format!("`{name}`"),
    })]
    NoAssembly {
        /// The one that is chosen.
        choice: AssemblyChoice,
        /// Where.
        span: Span,
        /// Numbers and names of those that there are.
        known: Vec<(usize, String)>,
    },
    /// A pose in which the forces are not balanced.
    #[error("{what} do not determine {}", counted(*n, "unknown", "unknowns"))]
    Undetermined {
        /// The equations.
        what: String,
        /// Number of unknowns.
        n: usize,
    },
}

impl AnalysisError {
    /// The faults as data: those of the model as they are, else one without a position in it.
    pub fn diagnostics(&self) -> Vec<Diagnostic> {
        let (code, help) = match self {
            Self::Rejected(rejected) => return rejected.0.clone(),
            Self::Compile(_) => (bksim_sim::codes::NOT_FINITE_AT_START, String::new()),
            Self::BadRange { unit, .. } if unit == "rad" => {
                (codes::BAD_RANGE, "write values such as `0:360 deg:361` or `0.5`".to_owned())
            }
            Self::BadRange { unit, .. } if unit.is_empty() => {
                (codes::BAD_RANGE, "write plain numbers such as `0:20:21` or `0.5`".to_owned())
            }
            Self::BadRange { unit, .. } => {
                (codes::BAD_RANGE, format!("write values such as `0:20 {unit}:21` or `0.5`"))
            }
            Self::NoFrequencies { .. } => {
                (codes::BAD_RANGE, "write a range such as `0.1:100 rad/s:201`".to_owned())
            }
            Self::Counts { .. } => {
                (codes::BAD_RANGE, "write ranges such as `0:360 deg:361`".to_owned())
            }
            Self::UnknownMeasure { .. } => (
                codes::UNKNOWN_NAME,
                "write `JOINT.angle`, `JOINT.position`, `BODY.angle`, `BODY.x` or `BODY.POINT.x`"
                    .to_owned(),
            ),
            Self::UnknownPoint { .. } => (
                codes::UNKNOWN_NAME,
                "write `BODY.POINT`, the name of a joint, or that of a body for its centre of mass"
                    .to_owned(),
            ),
            Self::UnknownBody { .. } => {
                (codes::UNKNOWN_NAME, "write the name of one of `[bodies]`, or `ground`".to_owned())
            }
            Self::NotPlanar { .. } => (
                codes::NOT_PLANAR,
                "ask for the curves of points, which are traced in space, too".to_owned(),
            ),
            Self::NotAPosition { .. } => (
                codes::UNKNOWN_NAME,
                "write `.angle`, `.position`, `.x` or `.y` at the end of the name".to_owned(),
            ),
            Self::UnknownParameter { .. } => {
                (codes::UNKNOWN_NAME, "write the name of one of `[parameters]`".to_owned())
            }
            Self::UnknownCam { known, .. } if known.is_empty() => (
                codes::UNKNOWN_CAM,
                "write a curve of type `cam-law`, and one of type `cam` that names it".to_owned(),
            ),
            Self::UnknownCam { known, .. } => {
                (codes::UNKNOWN_CAM, format!("name one of {}", quoted(known)))
            }
            Self::NDrives { n_free, .. } => (
                codes::N_DRIVES,
                format!("prescribe as many motions as are free: write `--drive` {}", times(*n_free)),
            ),
            Self::NMotions { n_free, n_prescribed } => (
                codes::N_DRIVES,
                format!(
                    "prescribe what is left free, too: add `--motion` {}",
                    times(n_free.saturating_sub(*n_prescribed))
                ),
            ),
            Self::NQuantities { n_free, .. } => (
                codes::N_DRIVES,
                format!("name as many quantities as motions are free: {n_free}"),
            ),
            Self::NotOneMotion { .. } => (
                codes::N_DRIVES,
                "hold or free motions until one is left: limits belong to one free motion"
                    .to_owned(),
            ),
            Self::OneMotion { .. } => (
                codes::N_DRIVES,
                "ask for the curve of the point, `--point`: one motion leads along a curve"
                    .to_owned(),
            ),
            Self::NoMode { .. } => {
                (codes::UNKNOWN_NAME, "write a number that `bksim modes` counts".to_owned())
            }
            Self::NotReached { .. } => (
                codes::NOT_REACHED,
                "write a range within the limits that `bksim kinematics --limits` shows".to_owned(),
            ),
            Self::Singular { .. } => {
                (codes::NOT_REACHED, "drive another motion, or begin in another pose".to_owned())
            }
            Self::NoEquilibrium => (
                codes::NO_EQUILIBRIUM,
                "add what holds the mechanism: a spring, a drive, a stop".to_owned(),
            ),
            Self::NotIsolated { .. } => (
                codes::NO_EQUILIBRIUM,
                "hold what can be anywhere by a drive or a spring, or ask `bksim static` without `--over`"
                    .to_owned(),
            ),
            Self::NotUnique { .. } => (
                codes::UNDETERMINED,
                "name a component that is unique, or free what repeats others: `bksim doctor` tells how"
                    .to_owned(),
            ),
            Self::EffortInReaction { .. } => (
                codes::UNDETERMINED,
                "write a load with a parameter as its force or torque, and make that parameter the input"
                    .to_owned(),
            ),
            Self::NoChannels => (
                codes::UNKNOWN_NAME,
                "write `--input` with a parameter or a joint, and `--output` with a measure"
                    .to_owned(),
            ),
            Self::Unknowns { n_free: 0, .. } => (
                codes::UNDETERMINED,
                "free a motion: nothing can move, and every value is in balance".to_owned(),
            ),
            Self::Unknowns { n_free, .. } => (
                codes::UNDETERMINED,
                format!(
                    "name one unknown parameter for each free motion: write `--solve` {}",
                    times(*n_free)
                ),
            ),
            Self::NotBalanced { .. } => (
                codes::NOT_BALANCED,
                "name a parameter whose force works in that pose, or begin in another pose"
                    .to_owned(),
            ),
            Self::Lost { .. } => (
                codes::NOT_REACHED,
                "end the motion before, or choose one within the limits of the mechanism"
                    .to_owned(),
            ),
            Self::StatesLost { .. } | Self::NoSignal { .. } => (
                codes::WITH_STATES,
                "end the motion before, or give what has no value there as a parameter".to_owned(),
            ),
            Self::GivenEffort { .. } => (
                codes::WITH_STATES,
                "name a joint or a drive: its effort is what the motion needs besides the loads of the model"
                    .to_owned(),
            ),
            Self::UnknownReaction { .. } => (
                codes::UNKNOWN_NAME,
                "write a joint, `A`, or a component of its reaction, `A.fy`, `A.mz` or `A.fy_joint`".to_owned(),
            ),
            Self::NoStiffness { .. } => (
                codes::BAD_RANGE,
                "write `1e8 N/m` of forces, `1e5 N m/rad` of moments".to_owned(),
            ),
            Self::NoActuator { known, .. } if known.is_empty() => (
                codes::UNKNOWN_NAME,
                "write `--actuator` with the joint that has an effort".to_owned(),
            ),
            Self::NoActuator { known, .. } => {
                (codes::UNKNOWN_NAME, format!("name one of {}", quoted(known)))
            }
            Self::BadCurve { .. } => (
                codes::BAD_RANGE,
                "write points such as `0,4` and `300,1`: a speed and the largest effort there, in SI units"
                    .to_owned(),
            ),
            Self::UnknownTable { known, .. } if known.is_empty() => (
                codes::UNKNOWN_NAME,
                "write a table, such as `[tables.motor]`, or name a file: `A=@motor.csv`".to_owned(),
            ),
            Self::UnknownTable { known, .. } => (
                codes::UNKNOWN_NAME,
                format!("name one of {}, or a file: `A=@motor.csv`", quoted(known)),
            ),
            Self::CurveUnits { turns: true, .. } => {
                (codes::BAD_RANGE, "write `units = [\"rad/s\", \"N m\"]` in the table".to_owned())
            }
            Self::CurveUnits { .. } => {
                (codes::BAD_RANGE, "write `units = [\"m/s\", \"N\"]` in the table".to_owned())
            }
            Self::StatesBalance { .. } => (
                codes::UNDETERMINED,
                "name a parameter that the rates of the states depend on, or ask `bksim static` for the states"
                    .to_owned(),
            ),
            Self::NoAssembly { .. } => (
                codes::NO_ASSEMBLY,
                "write a number or a name that `bksim kinematics --assemblies` lists".to_owned(),
            ),
            Self::Undetermined { .. } => (
                codes::UNDETERMINED,
                "ask for as many unknowns as there are independent equations".to_owned(),
            ),
        };
        let mut fault = Diagnostic::error(code, self.to_string());
        if let Self::NoAssembly { span, known, .. } = self {
            let rows = known.iter().map(|(number, name)| format!("{number}: {name}"));
            let listed = rows.collect::<Vec<_>>().join("; ");
            fault = fault.at(span.clone(), "").note(format!("it has {listed}"));
        }
        vec![if help.is_empty() { fault } else { fault.help(help) }]
    }
}

/// Names as a message lists them.
fn quoted(names: &[String]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// A unit as a message names it.
fn named(unit: &str) -> &str {
    if unit.is_empty() { "plain numbers" } else { unit }
}

/// `1 motion is free`, `2 motions are free`.
fn are(n: usize, what: &str) -> String {
    format!("{} {what}", counted(n, "motion is", "motions are"))
}

/// How often an option is written.
fn times(n: usize) -> String {
    counted(n, "time", "times")
}
