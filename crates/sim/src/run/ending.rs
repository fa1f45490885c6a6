//! [`PhaseEnd`]: why a phase of a run ends.

use bksim_dae::SolveError;

use crate::hybrid::Crossed;

/// Why a phase ended.
pub(super) enum PhaseEnd {
    /// The end time is reached.
    Reached,
    /// Stability limits explicit steps.
    Stiff,
    /// Explicit steps would be far too many.
    Slow,
    /// Radau IIA would need far too many steps as well.
    NoGain,
    /// Explicit steps could be nearly as large as Radau's.
    Relaxed,
    /// A step of Radau's, up to this time, came near a singular pose; it is not part of the run.
    SingularAhead(f64),
    /// Explicit steps have passed it.
    Regular,
    /// Other rows hold the motion better than those that have been active: these are to be inactive.
    OtherRows(Vec<usize>),
    /// Something switched where the run stands now.
    Switched(Crossed),
    /// A clock ticks where the run stands now.
    Tick,
    /// A rope or belt has gone on by half a turn, which is counted.
    HalfTurn,
    /// A step, which is no part of the run, went on too far from half a turn at about this time.
    HalfTurnAhead(f64),
    /// The integrator cannot go on; `None` when the motion left its branch.
    Failed(Option<SolveError>),
}
