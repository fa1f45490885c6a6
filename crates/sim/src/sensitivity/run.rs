//! A run with sensitivities: Radau IIA throughout, every sample with its derivatives.

use bksim_dae::{
    Control, Layout, NotFinite, Pattern, SensitivitySolver, SensitivityStart, SensitivityStep,
    SensitivitySystem, SolveError, Start as From, System,
};
use bksim_expr::Workspace;

use super::tangent::{State, Tangents};
use super::{SensitivityEquations, StateSensitivity};
use crate::compiled::CompiledSystem;
use crate::evaluator::gather;
use crate::formulate::{Motion, MotionEquations};
use crate::run::implicit::settings;
use crate::run::recorder::{Recorder, Stretch};
use crate::run::singular::is_ahead;
use crate::run::{
    Failure, Integrator, MethodChange, Observer, Reason, Sample, Segment, Summary, undefined,
};
use crate::start::Start;
use bksim_model::SolveOptions;

/// Why a run with sensitivities ended.
enum End {
    Reached,
    /// The observer or the caller asked to stop.
    Stopped,
    /// The integrator cannot go on; `None` at a singular pose.
    Failed(Option<SolveError>),
}

/// Integrates from `start`, whose sensitivities are `begin`, with Radau IIA, and hands every sample
/// with its sensitivities to `observer`, which may stop the run; `stop` is asked after every step.
///
/// # Errors
/// [`Failure`] when the integrator cannot go on, or comes to a singular pose, where sensitivities
/// may have no bound.
#[expect(clippy::too_many_arguments, reason = "those of `run`, and the sensitivities")]
pub fn run_with_sensitivities(
    compiled: &CompiledSystem,
    motion: &MotionEquations,
    equations: &SensitivityEquations,
    (start, begin): (&Start, &[StateSensitivity]),
    parameters: &[f64],
    options: &SolveOptions,
    observer: &mut dyn Observer,
    stop: &dyn Fn() -> bool,
) -> Result<Summary, Box<Failure>> {
    let mut recorder = Recorder::new(compiled, start, parameters, options, motion.n());
    let first = &mut |sample: &Sample| observer.sample(sample, begin);
    if recorder.record_start(start, first) == Control::Stop {
        return Ok(recorder.summary);
    }
    let method = MethodChange { t: start.t, method: Integrator::Radau, reason: Reason::Asked };
    recorder.summary.methods.push(method);
    let tangents = Tangents::new(equations, compiled, parameters, start.inactive_rows());
    let mut run = Run { recorder, tangents, observer, stop, n_sensitive: begin.len() };
    let end = run.integrate(motion, equations, (start, begin), options);
    let recorder = run.recorder;
    if recorder.is_undefined {
        return Err(Box::new(undefined(recorder)));
    }
    let Recorder { mut summary, sample: last, .. } = recorder;
    match end {
        End::Reached | End::Stopped => {
            summary.reached_end = summary.t == options.t_end;
            Ok(summary)
        }
        End::Failed(error) => Err(Box::new(Failure { error, unsettled: None, summary, last })),
    }
}

struct Run<'a, 'b> {
    recorder: Recorder<'a>,
    tangents: Tangents<'a>,
    observer: &'b mut dyn Observer,
    stop: &'b dyn Fn() -> bool,
    n_sensitive: usize,
}

impl Run<'_, '_> {
    fn integrate(
        &mut self,
        motion: &MotionEquations,
        equations: &SensitivityEquations,
        (start, begin): (&Start, &[StateSensitivity]),
        options: &SolveOptions,
    ) -> End {
        let parameters = self.recorder.switching.parameters.clone();
        let system = SensitiveMotion {
            motion: motion.at(&parameters, start.inactive_rows()),
            equations,
            workspace: equations.columns.tape().workspace(&parameters),
            inputs: Vec::new(),
        };
        let (y, ydot) = motion.state(&start.q, &start.v, &start.a, &start.lambda);
        let from = From { t: start.t, y, ydot };
        let of_start = |s: &StateSensitivity| motion.state(&s.q, &s.v, &s.a, &s.lambda);
        let (s, sdot) = begin.iter().map(of_start).unzip();
        let begin = SensitivityStart { s, sdot };
        let settings = settings(options, motion);
        let solver = SensitivitySolver::new(system, from, &begin, options.t_end, settings);
        let mut solver = match solver {
            Ok(solver) => solver,
            Err(error) => return End::Failed(Some(error)),
        };
        loop {
            let step = match solver.step() {
                Ok(Some(step)) => step,
                Ok(None) => return End::Reached,
                Err(error) => return End::Failed(Some(error)),
            };
            let Recorder { evaluator, multipliers, .. } = &mut self.recorder;
            if options.step.is_none() && is_ahead(evaluator, multipliers, &step.step) {
                return End::Failed(None);
            }
            if self.pass(&step) == Control::Stop || (self.stop)() {
                return End::Stopped;
            }
        }
    }

    /// Samples the output times of a step.
    fn pass(&mut self, step: &SensitivityStep<'_>) -> Control {
        let Self { recorder, tangents, observer, n_sensitive, .. } = self;
        let whole = &step.step;
        let n = whole.y1().len();
        let at = |t: f64, y: &mut [f64]| whole.at(t, &mut y[..n]);
        let stretch = Stretch {
            t0: whole.t0(),
            t1: whole.t1(),
            at: &at,
            degree: whole.degree(),
            has_work: false,
            h: whole.h(),
            stats: *whole.stats(),
        };
        let mut completing = Completing {
            step,
            tangents,
            n_sensitive: *n_sensitive,
            s: vec![0.0; n],
            is_finite: true,
            observer: &mut **observer,
        };
        let control = recorder.pass(&stretch, &mut completing);
        recorder.is_undefined |= !completing.is_finite;
        recorder.summary.stats = *whole.stats();
        control
    }
}

/// Completes the samples of one step by their sensitivities.
struct Completing<'a, 'b, 'c> {
    step: &'a SensitivityStep<'a>,
    tangents: &'a mut Tangents<'b>,
    n_sensitive: usize,
    /// The sensitivity of the integrator's unknowns to one quantity.
    s: Vec<f64>,
    is_finite: bool,
    observer: &'c mut dyn Observer,
}

impl Observer for Completing<'_, '_, '_> {
    fn sample(&mut self, sample: &Sample, _: &[StateSensitivity]) -> Control {
        let Self { step, tangents, n_sensitive, s, .. } = self;
        let Sample { t, q, v, a, lambda, .. } = sample;
        let at = State { t: *t, q, v, a, lambda };
        let mut by = |k: usize| {
            step.s_at(k, *t, s);
            let (dq, dv) = s[..2 * q.len()].split_at(q.len());
            tangents.complete(at, k, (dq, dv))
        };
        let Ok(all) = (0..*n_sensitive).map(&mut by).collect::<Result<Vec<_>, _>>() else {
            self.is_finite = false;
            return Control::Stop;
        };
        self.observer.sample(sample, &all)
    }

    fn wants_segments(&self) -> bool {
        self.observer.wants_segments()
    }

    fn segment(&mut self, segment: &Segment) {
        self.observer.segment(segment);
    }
}

/// The equations of motion with their derivatives by parameters.
struct SensitiveMotion<'a> {
    motion: Motion<'a>,
    equations: &'a SensitivityEquations,
    workspace: Workspace,
    inputs: Vec<f64>,
}

impl System for SensitiveMotion<'_> {
    fn layout(&self) -> &Layout {
        self.motion.layout()
    }

    fn pattern(&self) -> &Pattern {
        self.motion.pattern()
    }

    fn explicit_rows(&self) -> &[(usize, usize)] {
        self.motion.explicit_rows()
    }

    fn residual(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        out: &mut [f64],
    ) -> Result<(), NotFinite> {
        self.motion.residual(t, y, ydot, out)
    }

    fn jacobian(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        df_dy: &mut [f64],
        df_dydot: &mut [f64],
    ) -> Result<(), NotFinite> {
        self.motion.jacobian(t, y, ydot, df_dy, df_dydot)
    }
}

impl SensitivitySystem for SensitiveMotion<'_> {
    fn n_parameters(&self) -> usize {
        self.equations.sensitive.len()
    }

    /// Not finite values are found by the solver.
    fn parameter_jacobian(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        out: &mut [f64],
    ) -> Result<(), NotFinite> {
        gather(&mut self.inputs, t, &[y, ydot]);
        self.equations.columns.evaluate(&mut self.workspace, &self.inputs, out);
        for column in out.chunks_exact_mut(y.len()) {
            self.motion.held().iter().for_each(|&row| column[row] = 0.0);
        }
        Ok(())
    }
}
