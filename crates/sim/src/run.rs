//! A run: from the consistent start to the end time, sample by sample.
//!
//! The integrator's states are evaluated on its dense output at the output times, projected onto
//! the position and velocity constraints, and completed by the accelerations, multipliers and
//! reactions that the equations of motion give there. Nothing that is reported comes from stage
//! values of the multipliers.

mod checkpoint;
mod explicit;
pub(crate) mod implicit;
mod legs;
mod observer;
pub(crate) mod recorder;
mod replay;
pub(crate) mod singular;

use bksim_dae::{Checkpoint, SolveError, Standstill, Stats};

use self::checkpoint::Fingerprint;
pub use self::checkpoint::{RunCheckpoint, Unfit};
use self::legs::{Halt, Run};
pub use self::observer::{Observer, Segment, WithSensitivities};
use self::recorder::Recorder;
pub use self::replay::{Replay, Unreplayed};
pub use self::singular::SingularPose;
use crate::compiled::CompiledSystem;
pub use crate::evaluator::Energy;
use crate::formulate::MotionEquations;
use crate::hybrid::{Change, NoConsistentModes};
use crate::start::Start;
use bksim_model::SolveOptions;

/// Everything about one instant.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Sample {
    /// s.
    pub t: f64,
    /// Coordinates, nq.
    pub q: Vec<f64>,
    /// Velocities, nq.
    pub v: Vec<f64>,
    /// Accelerations, nq.
    pub a: Vec<f64>,
    /// Multipliers, nc.
    pub lambda: Vec<f64>,
    /// Reactions on the successors, by joint: force N, moment N m, world axes.
    pub reactions: Vec<[f64; 6]>,
    /// Values of the model's [inputs](crate::input), SI.
    pub inputs: Vec<f64>,
    /// Energies and power.
    pub energy: Energy,
    /// Work of loads and drives since the start, J.
    pub work: f64,
    /// Largest |g| of the integrator's state and of the sample, m or rad.
    pub position_residual: [f64; 2],
    /// Largest |G v + ∂g/∂t| of the integrator's state and of the sample, m/s or rad/s.
    pub velocity_residual: [f64; 2],
    /// Step size at this instant, s; zero at the start.
    pub step_size: f64,
    /// Counters so far.
    pub stats: Stats,
}

/// How a run ended and how good it was.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Summary {
    /// Whether the end time was reached.
    pub reached_end: bool,
    /// Last instant, s.
    pub t: f64,
    /// Number of samples, the start included.
    pub n_samples: usize,
    /// Work of the integrator.
    pub stats: Stats,
    /// Worst of [`Sample::position_residual`].
    pub position_residual: [f64; 2],
    /// Worst of [`Sample::velocity_residual`].
    pub velocity_residual: [f64; 2],
    /// The energy balance.
    pub energy: EnergyBalance,
    /// The singular poses that were passed.
    pub singular_poses: Vec<SingularPose>,
    /// The methods that were used, the first from the start.
    pub methods: Vec<MethodChange>,
    /// What switched, in order.
    pub changes: Vec<Change>,
    /// What a run that was stopped goes on from; see [`resume`].
    pub checkpoint: Option<RunCheckpoint>,
}

/// A method, from when it was used, and why.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MethodChange {
    /// s.
    pub t: f64,
    /// What integrates from there on.
    pub method: Integrator,
    /// Why.
    pub reason: Reason,
}

/// What integrates the equations of motion.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Integrator {
    /// Dormand–Prince 8(5,3) on the accelerations, with projection.
    Explicit,
    /// Radau IIA on the formulation asked for.
    Radau,
}

/// Why a method is used.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reason {
    /// The model asks for it.
    Asked,
    /// It needs the least work as long as the motion is not stiff.
    Cheapest,
    /// The motion has turned stiff.
    Stiff,
    /// The other method failed here.
    OtherFailed,
    /// Explicit steps pass the singular pose ahead.
    SingularPose,
    /// The singular pose lies behind.
    Regular,
}

/// T + V − W against its value at the start.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct EnergyBalance {
    /// T + V at the start, J.
    pub initial: f64,
    /// T + V at the end, J.
    pub last: f64,
    /// Work of loads and drives, that of impacts included, J.
    pub work: f64,
    /// Work of impacts, J: the change of T at once by stops and kinks of drives.
    pub impacts: f64,
    /// Largest |T + V − W − (T₀ + V₀)| over the samples, J.
    pub worst_error: f64,
    /// Largest |T| + |V − V₀| + |W| over the samples, J: what the error is relative to.
    pub scale: f64,
}

/// Why a run stopped early, with what was reached.
#[derive(Clone, PartialEq, Debug)]
pub struct Failure {
    /// The integrator's reason; `None` when the run met a singular pose that it could not cross.
    pub error: Option<SolveError>,
    /// What could not go on where something switched.
    pub unsettled: Option<NoConsistentModes>,
    /// The run so far.
    pub summary: Summary,
    /// The last state that was reached.
    pub last: Sample,
}

/// Integrates from `start` and hands every sample to `observer`, which may stop the run; `stop` is
/// asked after every step.
///
/// The end may lie before the start where nothing switches: the motion is then followed back in time.
///
/// A run that ends early hands out one more sample, at the end of its last step. One that was
/// stopped goes on from [`Summary::checkpoint`].
///
/// # Errors
/// [`Failure`] when the integrator cannot go on; all samples before it have been handed out.
pub fn run(
    compiled: &CompiledSystem,
    equations: &MotionEquations,
    start: &Start,
    parameters: &[f64],
    options: &SolveOptions,
    observer: &mut dyn Observer,
    stop: &dyn Fn() -> bool,
) -> Result<Summary, Box<Failure>> {
    let mut recorder = Recorder::new(compiled, start, parameters, options, equations.n());
    let control = recorder.record_start(start, observer);
    let mut run = Run::new(recorder, start, options, observer, stop);
    run.begin(control);
    let outcome = run.run_to_end(compiled, equations);
    let fingerprint = || Fingerprint::of(compiled, start, parameters, options);
    finish(run.recorder, outcome, options.t_end, &fingerprint)
}

/// Continues a run that was stopped, as if it had not been: the samples that follow, and the
/// summary of the whole, equal those of the undisturbed run bit for bit. Everything but the observer
/// must be as it was when the run began.
///
/// The sample that a stopped run hands out at the end of its last step is no part of the run; those
/// before it are, [`RunCheckpoint::n_samples`] in number.
///
/// # Errors
/// [`Unresumed`] when the checkpoint belongs to another run, or the integrator cannot go on.
pub fn resume(
    compiled: &CompiledSystem,
    equations: &MotionEquations,
    (start, checkpoint): (&Start, &RunCheckpoint),
    parameters: &[f64],
    options: &SolveOptions,
    observer: &mut dyn Observer,
    stop: &dyn Fn() -> bool,
) -> Result<Summary, Unresumed> {
    let fingerprint = Fingerprint::of(compiled, start, parameters, options);
    checkpoint.check(&fingerprint)?;
    let recorder = Recorder::new(compiled, start, parameters, options, equations.n());
    let mut run = Run::new(recorder, start, options, observer, stop);
    run.load(&checkpoint.numbers, compiled).map_err(Unfit::Damaged)?;
    run.catch_up();
    let outcome = run.run_to_end(compiled, equations);
    finish(run.recorder, outcome, options.t_end, &|| fingerprint.clone()).map_err(|failure| {
        match failure.error {
            Some(error @ SolveError::Checkpoint { .. }) => Unfit::Damaged(error).into(),
            _ => Unresumed::Failed(failure),
        }
    })
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

/// How a run has ended.
fn finish(
    recorder: Recorder<'_>,
    outcome: Result<Option<Checkpoint>, Halt>,
    t_end: f64,
    fingerprint: &dyn Fn() -> Fingerprint,
) -> Result<Summary, Box<Failure>> {
    if recorder.is_undefined {
        return Err(Box::new(undefined(recorder)));
    }
    let is_complete = recorder.is_complete(t_end);
    let Recorder { mut summary, sample: last, .. } = recorder;
    match outcome {
        Ok(numbers) => {
            summary.reached_end = is_complete;
            let numbers = numbers.filter(|_| !is_complete);
            summary.checkpoint = numbers.map(|numbers| RunCheckpoint::new(fingerprint(), numbers));
            Ok(summary)
        }
        Err(Halt { error, unsettled }) => {
            Err(Box::new(Failure { error, unsettled, summary, last }))
        }
    }
}

/// The failure of a run whose equations have no value at an output time.
pub(crate) fn undefined(recorder: Recorder<'_>) -> Failure {
    let Recorder { summary, sample: last, .. } = recorder;
    let at = Standstill {
        t: last.t,
        h: last.step_size,
        worst: Vec::new(),
        y: [last.q.as_slice(), &last.v].concat(),
        stats: summary.stats,
    };
    let error = Some(SolveError::NotFinite { row: 0, at: Box::new(at) });
    Failure { error, unsettled: None, summary, last }
}
