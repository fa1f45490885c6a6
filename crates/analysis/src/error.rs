//! [`AnalysisError`]: why a question has no answer, in the author's terms.

mod help;

use bksim_expr::TapeError;
use bksim_model::AssemblyChoice;
use bksim_model::diagnostic::{Rejected, Span};
use bksim_model::message::{counted, listed, short};

use crate::way_rates::WayRates;

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
        /// Text as written.
        text: String,
        /// The SI unit that was expected.
        unit: String,
    },
    /// Frequencies from zero or below have no even steps of their logarithm.
    #[error(
        "`{text}` is no range of frequencies: its ends must be above zero, for it has even steps of the logarithm"
    )]
    NoFrequencies {
        /// Text as written.
        text: String,
    },
    /// Nothing of this name can be measured.
    #[error("the model has nothing called `{name}`")]
    UnknownMeasure {
        /// Name as written.
        name: String,
        /// The help by the nearest name, if one is near.
        near: Option<String>,
    },
    /// Nothing with a derivative has this name among what a run shows.
    #[error("no quantity of the run with a derivative is called `{name}`")]
    UnknownGoal {
        /// Name as written.
        name: String,
        /// Names that the model has.
        known: Vec<String>,
    },
    /// The root of a mean square that is zero has a kink.
    #[error("the rms of `{name}` is zero, where it has no derivative")]
    NoSlope {
        /// The quantity.
        name: String,
    },
    /// No point, joint or body has this name.
    #[error("no point, joint or body is called `{name}`")]
    UnknownPoint {
        /// Name as written.
        name: String,
    },
    /// No body has this name.
    #[error("no body is called `{name}`")]
    UnknownBody {
        /// Name as written.
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
        /// Name as written.
        name: String,
    },
    /// No parameter has this name.
    #[error("no parameter is called `{name}`")]
    UnknownParameter {
        /// Name as written.
        name: String,
    },
    /// No cam of this name, or not one alone.
    #[error("{}", .name.as_ref().map_or_else(|| format!("the model has {} cams and laws, not one", .known.len()),
        |name| format!("no cam or law is called `{name}`")))]
    UnknownCam {
        /// Name as written.
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
        /// Joint positions that would prescribe the rest.
        left: Vec<String>,
        /// Stops, open at the start, that would hold some of it.
        open: Vec<String>,
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
    /// Modes about a state that moves.
    #[error("modes are about a pose at rest, not about the run at t = {t} s")]
    NotAtRest {
        /// s.
        t: f64,
    },
    /// An input that joints or drives depend on: its rates move the mechanism, too.
    #[error(
        "the input `{name}` moves {what}, so that its rate and acceleration act as well as its value"
    )]
    MovingInput {
        /// The parameter.
        name: String,
        /// The drive, joint or coupling.
        what: String,
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
        "`{name}` cannot be brought from {} to {}: it stops at {}",
        shown(*from, unit), shown(*to, unit), shown(*at, unit)
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
    /// A start whose rows yield to first order alone.
    #[error("the start yields in {}, but goes nowhere: it is a singular pose", listed(&.moves.iter().map(String::as_str).collect::<Vec<_>>()))]
    GoesNowhere {
        /// Positions of joints that yield.
        moves: Vec<String>,
    },
    /// A pose in which several motions cross.
    #[error("branches cross in this pose: {} lead on from it", counted(ways.len(), "motion", "motions"))]
    BranchPoint {
        /// Rates of joints along each of them.
        ways: Vec<WayRates>,
        /// Text to write instead.
        cure: &'static str,
    },
    /// No branch through the start has this number.
    #[error("the start has no branch {number}, of {n}")]
    NoBranch {
        /// From one.
        number: usize,
        /// Number of branches.
        n: usize,
    },
    /// A branch along which what is prescribed stands still.
    #[error("nothing that is prescribed moves along branch {number}")]
    StillBranch {
        /// From one.
        number: usize,
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
    /// No equilibrium was found of what holds by friction at most, which is left out.
    #[error("no equilibrium was found without {}, which is left out as it slides at the start", .left_out.join(", "))]
    NoneWithoutFriction {
        /// The dry friction, as `friction `NAME``.
        left_out: Vec<String>,
    },
    /// No equilibrium has this number.
    #[error("there is no equilibrium {number}, of {n}")]
    NoSuchEquilibrium {
        /// From one.
        number: usize,
        /// Number of equilibria.
        n: usize,
    },
    /// Equilibria, none of which is stable.
    #[error("none of {} is stable", counted(*n, "equilibrium", "equilibria"))]
    NoStable {
        /// Number of equilibria.
        n: usize,
    },
    /// Stops that are open at the start leave no equilibrium before them.
    #[error("no equilibrium lies before {} {}", if .stops.len() == 1 { "stop" } else { "stops" },
        listed(&.stops.iter().map(String::as_str).collect::<Vec<_>>()))]
    StopsBefore {
        /// Their names.
        stops: Vec<String>,
    },
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
    /// More or fewer unknowns than free motions: only equal numbers can be balanced.
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
        /// Name of the element.
        name: String,
        /// s.
        t: f64,
    },
    /// A load, signal or state in the place of an actuator.
    #[error("the model itself gives `{name}` its value: no effort is left to be found")]
    GivenEffort {
        /// Name as written.
        name: String,
    },
    /// No joint or component of a reaction has this name.
    #[error("no joint and no component of a reaction is called `{name}`")]
    UnknownReaction {
        /// Name as written.
        name: String,
    },
    /// A joint that yields by what is no stiffness.
    #[error("`{text}` is no stiffness of `{name}`")]
    NoStiffness {
        /// The joint, or its component.
        name: String,
        /// Text as written.
        text: String,
    },
    /// No actuator has this name.
    #[error("no actuator is called `{name}`")]
    NoActuator {
        /// Name as written.
        name: String,
        /// Names that the model has.
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
        /// Name as written.
        name: String,
        /// Names that the model has.
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
    /// No values of parameters close the start.
    #[error("no value of {} near its own closes the start at the values that it states", listed(&.names.iter().map(String::as_str).collect::<Vec<_>>()))]
    NotClosed {
        /// The parameters.
        names: Vec<String>,
    },
    /// A start that closes with many values of parameters.
    #[error("the start closes with many values of {}: {} left free", listed(&.names.iter().map(String::as_str).collect::<Vec<_>>()), counted(*n, "motion or parameter is", "motions or parameters are"))]
    OpenStart {
        /// Unknowns that are left.
        n: usize,
        /// The parameters.
        names: Vec<String>,
    },
    /// A table of a motion with too few rows.
    #[error("the table of `{name}` has {}, and a motion needs {least}", counted(*rows, "row of numbers", "rows of numbers"))]
    ShortTable {
        /// The motion.
        name: String,
        /// Rows that it has.
        rows: usize,
        /// Rows that it needs.
        least: usize,
    },
    /// A table of a motion whose times do not ascend.
    #[error("the table of `{name}` goes back in time: from {} s in one row to {} s in the next", short(times[0]), short(times[1]))]
    TimesDescend {
        /// The motion.
        name: String,
        /// Times of both rows, s.
        times: [f64; 2],
    },
    /// A motion asked for at a time that its table does not reach.
    #[error("`{name}` is asked for at t = {} s, and its table goes from {} s to {} s", short(*t), short(ends[0]), short(ends[1]))]
    BeyondTable {
        /// The motion.
        name: String,
        /// Time that is asked for, s.
        t: f64,
        /// First and last time of the table, s.
        ends: [f64; 2],
    },
    /// A number of a table is none.
    #[error("`{name}` has no value {place}: it is {}", if .value.is_nan() { "no number".to_owned() } else { value.to_string() })]
    NoNumber {
        /// The quantity.
        name: String,
        /// Where: `at t = 0 s`.
        place: String,
        /// Infinity, or no number at all.
        value: f64,
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

/// A value with its unit, angles in degrees.
fn shown(value: f64, unit: &str) -> String {
    match unit {
        "rad" => format!("{} deg", short(value.to_degrees())),
        unit => format!("{} {unit}", short(value)),
    }
}

/// A unit as a message names it.
fn named(unit: &str) -> &str {
    if unit.is_empty() { "plain numbers" } else { unit }
}

/// `1 motion is free`, `2 motions are free`.
fn are(n: usize, what: &str) -> String {
    format!("{} {what}", counted(n, "motion is", "motions are"))
}
