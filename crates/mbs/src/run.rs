//! A run: from the consistent start to the end time, sample by sample.
//!
//! The integrator's states are evaluated on the collocation polynomial at the output times,
//! projected onto the position and velocity constraints, and completed by the accelerations,
//! multipliers and reactions that the equations of motion give there. Nothing that is reported
//! comes from stage values of the multipliers. Where a singular pose stops the integrator, the run
//! crosses it (see `crossing`) and goes on behind it.

use bksim_dae::{
    Control, End, ErrorTest, NewtonSettings, Settings, SolveError, Standstill, Stats, StepControl,
};
use nalgebra::DVector;

use crate::compile::{CompiledSystem, Energy, Evaluator};
use crate::formulate::MotionEquations;
use crate::legs::Run;
use crate::linear::largest;
use crate::model::SolveOptions;
use crate::recorder::Recorder;
use crate::start::Start;
use crate::switch::{Change, Unsettled};

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
    /// Times of the singular poses that were crossed, s.
    pub singular_poses: Vec<f64>,
    /// What switched, in order.
    pub changes: Vec<Change>,
}

/// T + V − W against its value at the start.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct EnergyBalance {
    /// T + V at the start, J.
    pub initial: f64,
    /// T + V at the end, J.
    pub last: f64,
    /// Work of loads and drives, that of blows included, J.
    pub work: f64,
    /// Work of blows, J: what stops and kinks of drives have done to T at once.
    pub blows: f64,
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
    pub unsettled: Option<Unsettled>,
    /// The run so far.
    pub summary: Summary,
    /// The last state that was reached.
    pub last: Sample,
}

/// Integrates from `start` and hands every sample to `observer`, which may stop the run; `stop` is
/// asked after every step.
///
/// A run that ends early hands out one more sample, at the end of its last step.
///
/// # Errors
/// [`Failure`] when the integrator cannot go on; all samples before it have been handed out.
pub fn run(
    compiled: &CompiledSystem,
    equations: &MotionEquations,
    start: &Start,
    parameters: &[f64],
    options: &SolveOptions,
    observer: &mut dyn FnMut(&Sample) -> Control,
    stop: &dyn Fn() -> bool,
) -> Result<Summary, Box<Failure>> {
    let mut recorder = Recorder::new(compiled, start, parameters, options, equations.n());
    if recorder.record_start(start, observer) == Control::Stop {
        return Ok(recorder.summary);
    }
    let mut run = Run::new(recorder, start, observer, stop);
    loop {
        let error = match run.leg(equations, options) {
            Ok(End::Reached) => break,
            Ok(End::Stopped) => {
                match run.pass_event() {
                    Ok(true) if !run.is_stopped => continue,
                    Ok(_) => (),
                    Err(fault) => {
                        run.record_last();
                        let Recorder { summary, sample: last, .. } = run.recorder;
                        let unsettled = Some(fault);
                        return Err(Box::new(Failure { error: None, unsettled, summary, last }));
                    }
                }
                if !run.is_stopped {
                    run.record_last();
                }
                break;
            }
            Err(error) => error,
        };
        if !run.pass_singular_pose(options) {
            run.record_last();
            let Recorder { summary, sample, .. } = run.recorder;
            return Err(Box::new(Failure { error, unsettled: None, summary, last: sample }));
        }
        if run.is_stopped || run.recorder.summary.t == options.t_end {
            break;
        }
    }
    if run.recorder.is_undefined {
        return Err(Box::new(undefined(run.recorder)));
    }
    let mut summary = run.recorder.summary;
    summary.reached_end = summary.t == options.t_end;
    Ok(summary)
}

/// The failure of a run whose equations have no value at an output time.
fn undefined(recorder: Recorder<'_>) -> Failure {
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

/// The integrator's settings for a model's options.
pub(crate) fn settings(options: &SolveOptions, equations: &MotionEquations) -> Settings {
    Settings {
        rtol: options.rtol,
        atol: equations.tolerances(options.atol),
        step: match options.step {
            None => StepControl::Adaptive,
            Some(h) => StepControl::Fixed { h, newton_tolerance: options.newton_tolerance },
        },
        // Multipliers feel a change of contact or a weak pose before positions do.
        error_test: ErrorTest::All,
        newton: NewtonSettings { keep_jacobian_below: Some(1e-3), ..NewtonSettings::default() },
        ..Settings::default()
    }
}

/// The largest constraint residual of a state.
pub(crate) fn residuals(evaluator: &mut Evaluator, t: f64, q: &[f64], v: &[f64]) -> [f64; 2] {
    let at = evaluator.dynamics(t, q, v);
    let rate = &at.jacobian * DVector::from_column_slice(v) + &at.rate;
    [largest(&at.constraint), largest(&rate)]
}
