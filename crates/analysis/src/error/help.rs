//! The code of each question without an answer, and what to write instead.

use bksim_model::diagnostic::Diagnostic;
use bksim_model::file::suggest;
use bksim_model::message::counted;

use super::AnalysisError;
use crate::codes;
use crate::way_rates::in_words;

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
            Self::UnknownMeasure { near, .. } => (
                codes::UNKNOWN_NAME,
                near.clone().unwrap_or_else(|| {
                    "write `JOINT.angle`, `JOINT.position`, `BODY.angle`, `BODY.x` or `BODY.POINT.x`"
                        .to_owned()
                }),
            ),
            Self::UnknownGoal { name, known } => {
                let known: Vec<&str> = known.iter().map(String::as_str).collect();
                (codes::UNKNOWN_NAME, suggest(name, &known))
            }
            Self::NoSlope { .. } => (
                bksim_sim::codes::NO_SENSITIVITY,
                "ask for its mean, or for its largest or smallest value".to_owned(),
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
            Self::NMotions { n_free, n_prescribed, left, .. } => {
                let named = left.iter().map(|name| format!("--motion {name}=0"));
                let written = match n_free.saturating_sub(*n_prescribed) {
                    n if n == left.len() => {
                        format!("`{}`, or its motion", named.collect::<Vec<_>>().join(" "))
                    }
                    n => format!("`--motion` {}", times(n)),
                };
                (codes::N_DRIVES, format!("prescribe what is left free, too: add {written}"))
            }
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
            Self::NotAtRest { .. } => (
                codes::NO_EQUILIBRIUM,
                "write `static` or `start` for it; `bksim linearize --at t=…` has the poles about an instant"
                    .to_owned(),
            ),
            Self::MovingInput { .. } => (
                codes::MOVING_INPUT,
                "take the effort of a joint or a parameter of loads as the input, or solve the motion with a function of time in place of the parameter"
                    .to_owned(),
            ),
            Self::NotReached { .. } => (
                codes::NOT_REACHED,
                "write a range within the limits that `bksim kinematics --limits` shows".to_owned(),
            ),
            Self::GoesNowhere { .. } => (
                codes::GOES_NOWHERE,
                "begin in another pose, or change a length so that the joints are not in line: `bksim doctor` shows the motion that ends at once"
                    .to_owned(),
            ),
            Self::BranchPoint { cure, .. } => (codes::BRANCH_POINT, (*cure).to_owned()),
            Self::StillBranch { .. } => (
                codes::BRANCH_POINT,
                "choose another branch, or drive another motion".to_owned(),
            ),
            Self::NoBranch { n, .. } => {
                (codes::BRANCH_POINT, format!("write a number from 1 to {n}"))
            }
            Self::Singular { .. } => {
                (codes::NOT_REACHED, "drive another motion, or begin in another pose".to_owned())
            }
            Self::NoSuchEquilibrium { .. } => (
                codes::NO_EQUILIBRIUM,
                "write a number that `bksim static` lists, from 1 on for the nearest to the start"
                    .to_owned(),
            ),
            Self::NoStable { .. } => (
                codes::NO_EQUILIBRIUM,
                "write `--at static` for the nearest to the start, whatever its stability".to_owned(),
            ),
            Self::NoEquilibrium => (
                codes::NO_EQUILIBRIUM,
                "add what holds the mechanism: a spring, a drive, a stop".to_owned(),
            ),
            Self::NoneWithoutFriction { .. } => (
                codes::NO_EQUILIBRIUM,
                "see whether friction holds it by `bksim solve`, or begin at rest, where friction sticks"
                    .to_owned(),
            ),
            Self::StopsBefore { .. } => (
                codes::NO_EQUILIBRIUM,
                "begin where the stop is closed, so that it counts as a constraint, or write other limits"
                    .to_owned(),
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
            Self::NotClosed { .. } => (
                codes::NOT_CLOSED,
                "name a parameter that the loop depends on, or state other values in `[initial]`"
                    .to_owned(),
            ),
            Self::OpenStart { .. } => (
                codes::NOT_CLOSED,
                "state one more position in `[initial]` for each that is left free, or name fewer parameters"
                    .to_owned(),
            ),
            Self::ShortTable { least, .. } => (
                codes::NO_MOTION,
                format!("write {least} rows or more of a time and a value, such as `0.1,0.25`"),
            ),
            Self::TimesDescend { .. } => (
                codes::NO_MOTION,
                "sort the rows by time, and keep one row of each time".to_owned(),
            ),
            Self::BeyondTable { ends: [from, to], .. } => (
                codes::BEYOND_TABLE,
                format!("ask for `--times {from}:{to}:101`, or give the table rows up to there"),
            ),
            Self::NoNumber { .. } => (
                codes::NO_NUMBER,
                "leave that place out, or keep the expression within bounds: `1/max(x, 1e-3)` in place of `1/x`"
                    .to_owned(),
            ),
            Self::Undetermined { .. } => (
                codes::UNDETERMINED,
                "ask for as many unknowns as there are independent equations".to_owned(),
            ),
        };
        let mut fault = Diagnostic::error(code, self.to_string());
        if let Self::BranchPoint { ways, .. } = self {
            for (k, way) in ways.iter().enumerate() {
                fault = fault.note(format!("branch {}: {}", k + 1, in_words(way)));
            }
        }
        if let Self::NMotions { open, .. } = self
            && !open.is_empty()
        {
            let (which, bear) = if open.len() == 1 { ("stop", "bears") } else { ("stops", "bear") };
            fault = fault.note(format!(
                "{which} {} {bear} nothing at the start: where it is closed then, it holds a motion",
                quoted(open)
            ));
        }
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

/// How often an option is written.
fn times(n: usize) -> String {
    counted(n, "time", "times")
}
