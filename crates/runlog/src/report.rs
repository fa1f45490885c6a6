//! The numbers that an engineer reads from a run: limits and strokes of all motions and where they are
//! reached, time ratios, largest velocities and accelerations, efforts of drives, reactions, energies.
//!
//! They are of the motion itself, not of its samples: a grid within every step brackets the extremes, a search by
//! parabolas between the instants next to each finds it, and integrals are Gauss sums over the steps.

mod json;
mod number;
mod pins;
mod quantities;
mod ratio;
mod survey;
mod tables;

use bksim_expr::TapeError;
use bksim_sim::run::Unreplayed;

pub use json::json_of;
pub use number::number;
pub use pins::{
    Cell, PinForce, PinTable, angle_unit, pin_sheet, pin_table, six_digits, worst_cases,
};
pub use ratio::TimeRatio;
pub use survey::report;
pub use tables::{Row, tables};

/// A value with its instant.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Extreme {
    /// In the unit of the quantity.
    pub value: f64,
    /// s; the start of the run where the value is the same throughout.
    pub t: f64,
    /// True where the value is the same throughout, but for rounding.
    pub is_steady: bool,
}

/// All numbers of one run.
#[derive(Clone, PartialEq, Debug)]
pub struct Report {
    /// First and last instant, s.
    pub span: [f64; 2],
    /// Every motion of every joint, in the order of the model.
    pub motions: Vec<MotionReport>,
    /// The centre of mass and the named points of every body.
    pub points: Vec<PointReport>,
    /// The drives.
    pub drives: Vec<DriveReport>,
    /// The reactions of the joints, then the forces of the contacts on their second bodies.
    pub reactions: Vec<ReactionReport>,
    /// The outputs of the model.
    pub outputs: Vec<OutputReport>,
    /// The work of every load, belt and drive, in the order of the model, then that of impacts if there were any.
    pub work: Vec<WorkReport>,
    /// Energies and work.
    pub energy: EnergyReport,
}

/// One motion of a joint.
#[derive(Clone, PartialEq, Debug)]
pub struct MotionReport {
    /// `A.angle`, `S.position`.
    pub name: String,
    /// rad or m.
    pub unit: &'static str,
    /// Least and largest value.
    pub limits: [Extreme; 2],
    /// The rate of largest size, with its sign.
    pub rate: Extreme,
    /// The acceleration of largest size, with its sign.
    pub acceleration: Extreme,
    /// The times of its strokes, where it goes to and fro between its limits.
    pub time_ratio: Option<TimeRatio>,
}

impl MotionReport {
    /// The distance between the limits.
    pub fn stroke(&self) -> f64 {
        self.limits[1].value - self.limits[0].value
    }
}

/// The sizes of velocity and acceleration of a point.
#[derive(Clone, PartialEq, Debug)]
pub struct PointReport {
    /// `rod.B`, or `rod` for its centre of mass.
    pub name: String,
    /// m/s.
    pub speed: Extreme,
    /// m/s².
    pub acceleration: Extreme,
}

/// The effort of a drive.
#[derive(Clone, PartialEq, Debug)]
pub struct DriveReport {
    /// Name.
    pub name: String,
    /// `N*m` or `N`.
    pub unit: String,
    /// The effort of largest size, with its sign.
    pub peak: Extreme,
    /// Root of the mean square over time.
    pub rms: f64,
    /// The power of largest size, with its sign, W.
    pub power: Extreme,
    /// Mean power, W.
    pub mean_power: f64,
}

/// The reaction of a joint, or the force of a contact.
#[derive(Clone, PartialEq, Debug)]
pub struct ReactionReport {
    /// Name of the joint, or `contacts.floor` of a contact.
    pub name: String,
    /// Largest size of the force, N.
    pub force: Extreme,
    /// The whole reaction and the pose there.
    pub largest: PinForce,
    /// Root of the mean square of that size, N.
    pub force_rms: f64,
    /// Largest size of the moment, N m.
    pub moment: Extreme,
    /// Root of the mean square of that size, N m.
    pub moment_rms: f64,
    /// True if force and moment are the same in every solution of the equilibrium, at every instant.
    pub is_unique: bool,
}

/// An output of the model.
#[derive(Clone, PartialEq, Debug)]
pub struct OutputReport {
    /// Name.
    pub name: String,
    /// Unit of the output, `N*m` for newton metre.
    pub unit: String,
    /// Least and largest value.
    pub limits: [Extreme; 2],
    /// Mean over time.
    pub mean: f64,
    /// Root of the mean square over time.
    pub rms: f64,
}

/// The work of a part, J.
#[derive(Clone, PartialEq, Debug)]
pub struct WorkReport {
    /// Name of the entry.
    pub name: String,
    /// `load`, `belt`, `drive`, `coupling` or `joint`; `impact` of all impacts together.
    pub kind: &'static str,
    /// The work that it does, without that of its potential.
    pub work: f64,
    /// The potential energy that it holds at the end, less that at the start.
    pub stored: f64,
}

/// Energies of a run, J.
#[derive(Clone, PartialEq, Debug)]
pub struct EnergyReport {
    /// Kinetic energy, largest.
    pub kinetic: Extreme,
    /// Potential energy, least and largest.
    pub potential: [Extreme; 2],
    /// Kinetic and potential energy at the start and at the end.
    pub total: [f64; 2],
    /// Work of loads and drives between them, without that of impacts.
    pub work: f64,
    /// The power of loads and drives of largest size, with its sign, W.
    pub power: Extreme,
}

/// Why a run cannot be reported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Unreported {
    /// The motion is not that of its model.
    #[error(transparent)]
    Unreplayed(#[from] Unreplayed),
    /// Functions of the motion cannot be compiled.
    #[error(transparent)]
    Tape(#[from] TapeError),
}
