//! Values of a start, and why there is none.

use bksim_expr::TapeError;
use bksim_model::{ClockId, JointId, LoadId};

use crate::hybrid::NoConsistentModes;

/// One stated or guessed value and what became of it.
#[derive(Clone, PartialEq, Debug)]
pub struct Moved {
    /// Name as written: `A.angle`.
    pub name: String,
    /// The value that the author wrote, SI.
    pub stated: f64,
    /// The value at the start, SI.
    pub found: f64,
    /// True if it was free to move.
    pub is_guess: bool,
}

/// Why there is no consistent start, with what a diagnostic needs.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum StartError {
    /// Every body is welded to the ground.
    NoCoordinates,
    /// The end lies before the start, but something switches on the way.
    Irreversible,
    /// The options ask for more samples or fixed steps than any log holds.
    TooMuch,
    /// A clock ticks more often than any run can follow.
    TooManyTicks {
        /// The clock.
        clock: ClockId,
        /// From tick to tick, s.
        every: f64,
    },
    /// The joints cannot meet at all.
    CannotClose {
        /// The gap left at each open joint, largest first.
        gaps: Vec<Gap>,
        /// The closest positions found.
        q: Vec<f64>,
    },
    /// The joints can meet, but not where the drives start.
    DrivesOutOfReach {
        /// Drives by their index, with the positions nearest to their starts where the joints meet.
        drives: Vec<(usize, f64)>,
    },
    /// The joints can meet, but not at the stated values.
    StatedPositions {
        /// The stated values, as indices into `Model::initial`, with what the joints would allow.
        conflicts: Vec<Conflict>,
    },
    /// The stated rates cannot all hold.
    StatedVelocities {
        /// The stated rates that exclude each other.
        conflicts: Vec<Conflict>,
    },
    /// A drive prescribes a motion the joints forbid.
    DriveCannotMove {
        /// The drive's index.
        drive_idx: usize,
    },
    /// Some motion has neither inertia nor constraint.
    NoInertia {
        /// Positions of the start.
        q: Vec<f64>,
        /// Coordinates that take part in it.
        coordinates: Vec<usize>,
    },
    /// Friction depends on a reaction that joints share among themselves.
    SharedReaction {
        /// The joint that rubs.
        joint: JointId,
    },
    /// A load, constraint or energy has no finite value at the start.
    NotFinite {
        /// The positions found, nq.
        q: Vec<f64>,
        /// The velocities found, nq; none where they were not looked for.
        v: Vec<f64>,
    },
    /// A joint starts beyond a stop.
    BeyondStop {
        /// The stop.
        load: LoadId,
        /// How far, m or rad.
        by: f64,
    },
    /// No branches and contacts are consistent.
    NoConsistentModes(NoConsistentModes),
    /// The functions could not be compiled.
    Compile(TapeError),
}

/// The gap at a joint in the closest position found.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Gap {
    /// The joint.
    pub joint: JointId,
    /// Between its points, m; of a link (d² − ℓ²) / (2 ℓ), where its ends are d apart and its length is ℓ.
    pub distance: f64,
    /// Between its axes, rad.
    pub angle: f64,
}

/// Another assembly, nearly as near to the guesses as the start.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Rival {
    /// Of guesses.
    Guessed {
        /// The guess that tells them apart best, as an index into `Model::initial`.
        initial_idx: usize,
        /// Value there, SI.
        found: f64,
        /// How far all guesses of this part of the mechanism are there, over how far they are at the start.
        ratio: f64,
    },
    /// Assembly as near to the shape without any guess: a mirror image, say.
    Unguessed {
        /// The coordinate that tells them apart best.
        column: usize,
        /// Value there, rad or m.
        found: f64,
    },
}

/// A stated value that the other stated values exclude.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Conflict {
    /// Index into `Model::initial`.
    pub initial_idx: usize,
    /// Stated value, SI.
    pub stated: f64,
    /// The value that is consistent with all other stated ones; `None` when the others already
    /// exclude each other.
    pub consistent: Option<f64>,
}
