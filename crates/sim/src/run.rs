//! A run: from the consistent start to the end time, sample by sample.
//!
//! The integrator's states are evaluated on its dense output at the output times, projected onto
//! the position and velocity constraints, and completed by the accelerations, multipliers and
//! reactions that the equations of motion give there. Nothing that is reported comes from stage
//! values of the multipliers.

mod checkpoint;
mod completion;
pub(crate) mod dense;
mod ending;
mod ensemble;
mod explicit;
pub(crate) mod hold;
mod holding;
pub(crate) mod implicit;
pub(crate) mod mechanism;
mod motion;
mod observer;
mod pace;
mod passage;
mod peak;
mod phase;
mod problem;
mod progress;
mod race;
mod replay;
pub(crate) mod sample;
pub(crate) mod sampler;
mod schedule;
pub(crate) mod singular;
mod spectrum;
mod stepper;
mod steps;
mod storage;
mod summary;
mod work;

use bksim_dae::SolveError;

pub use self::checkpoint::{RunCheckpoint, Unfit};
pub use self::ensemble::{ensemble_size, run_together};
pub use self::observer::{Observer, Segment, WithSensitivities};
pub use self::pace::Slowness;
pub use self::peak::peak;
pub use self::problem::Problem;
pub use self::progress::{Run, StepOutcome};
pub use self::replay::{Replay, Unreplayed};
pub use self::sample::{Energy, Sample, StateSensitivity};
pub use self::summary::{
    EnergyBalance, Failure, Integrator, MethodChange, NearPole, NoSensitivity, Reason,
    SingularPose, Summary, Undefined,
};

/// Integrates from the start and hands every sample to `observer`, which may stop the run; `stop` is
/// asked after every step.
///
/// The end may lie before the start where nothing switches: the motion is then followed back in time.
///
/// A run that ends early hands out one more sample, at the end of its last step, unless it was stopped
/// within that. One that was stopped goes on from [`Summary::checkpoint`].
///
/// # Errors
/// [`Failure`] when the integrator cannot go on; all samples before it have been handed out.
pub fn run(
    problem: Problem<'_>,
    observer: &mut dyn Observer,
    stop: &dyn Fn() -> bool,
) -> Result<Summary, Box<Failure>> {
    to_end(Run::begin(problem, observer), observer, stop)
}

/// Continues a run that was stopped, as if it had not been: the samples that follow, and the
/// summary of the whole, equal those of the undisturbed run bit for bit. Everything but the observer
/// must be as it was when the run began.
///
/// Of the samples that a run has handed out, the first [`RunCheckpoint::n_samples`] stay; those after them
/// are handed out again, but for the one at the end of the last step of a run that was stopped.
///
/// # Errors
/// [`Unresumed`] when the checkpoint belongs to another run, or the integrator cannot go on.
pub fn resume(
    problem: Problem<'_>,
    checkpoint: &RunCheckpoint,
    observer: &mut dyn Observer,
    stop: &dyn Fn() -> bool,
) -> Result<Summary, Unresumed> {
    let run = Run::resume(problem, checkpoint, observer)?;
    to_end(run, observer, stop).map_err(|failure| match failure.error {
        Some(error @ SolveError::Checkpoint { .. }) => Unfit::Damaged(error).into(),
        _ => Unresumed::Failed(failure),
    })
}

fn to_end(
    mut run: Run<'_>,
    observer: &mut dyn Observer,
    stop: &dyn Fn() -> bool,
) -> Result<Summary, Box<Failure>> {
    while run.step(observer, stop)? == StepOutcome::Ongoing {
        if observer.wants_checkpoint() {
            observer.checkpoint(&run.checkpoint());
        }
    }
    Ok(run.finish(observer))
}

/// Why a run was not continued to its end.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum Unresumed {
    /// The checkpoint cannot be used.
    #[error(transparent)]
    Unfit(#[from] Unfit),
    /// The integrator cannot go on.
    #[error("the run stopped early at t = {} s", .0.summary.t)]
    Failed(Box<Failure>),
}
