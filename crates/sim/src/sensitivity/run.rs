//! A run with sensitivities, every sample with its derivatives: any method, followed by them, or Radau IIA with its
//! stages shared.

use bksim_dae::{
    Control, Layout, NotFinite, Pattern, SensitivitySolver, SensitivityStart, SensitivityStep,
    SensitivitySystem, SolveError, System,
};

use super::derive::Way;
use super::follower::Follower;
use super::following::Following;
use super::tangent::{TangentPoint, Tangents};
use super::{SensitivityEquations, SensitivityPlan};
use crate::formulate::{MotionEquations, MotionSystem};
use crate::function::{Buffers, Function};
use crate::run::dense::DenseOutput;
use crate::run::implicit::settings;
use crate::run::mechanism::PhaseMechanism;
use crate::run::sample::StateSensitivity;
use crate::run::sampler::Sampler;
use crate::run::singular::is_ahead;
use crate::run::{
    Failure, Integrator, MethodChange, Observer, Problem, Reason, Sample, Segment, Summary, run,
};
use crate::start::Start;
use crate::state::{AccelerationRef, StateRef};

/// Why a run with sensitivities ended.
enum End {
    Reached,
    /// The observer or the caller asked to stop.
    Stopped,
    /// The integrator cannot go on; `None` at a singular pose.
    Failed(Option<SolveError>),
}

/// Integrates from the start, whose sensitivities `plan` knows, and hands every sample with its sensitivities to
/// `observer`, which may stop the run; `stop` is asked after every step.
///
/// # Errors
/// [`Failure`] when the integrator cannot go on, or comes to a singular pose, where sensitivities
/// may have no bound, or where the motion has no derivative.
pub fn run_with_sensitivities(
    problem: Problem<'_>,
    plan: &SensitivityPlan,
    observer: &mut dyn Observer,
    stop: &dyn Fn() -> bool,
) -> Result<Summary, Box<Failure>> {
    match &plan.equations.way {
        Way::Staggered(columns) => staggered(problem, (plan, columns), observer, stop),
        Way::Followed(following) => followed(problem, (plan, following), observer, stop),
    }
}

/// Any method, its motion followed.
fn followed(
    problem: Problem<'_>,
    (plan, following): (&SensitivityPlan, &Following),
    observer: &mut dyn Observer,
    stop: &dyn Fn() -> bool,
) -> Result<Summary, Box<Failure>> {
    let mut follower = Follower::new(problem, plan, following, observer);
    let outcome = run(problem, &mut follower, stop);
    let Some(fault) = follower.fault else { return outcome };
    let (mut summary, last) = match outcome {
        Ok(summary) => (summary, None),
        Err(failure) => (failure.summary, Some(failure.last)),
    };
    let Start { t, q, v, a, lambda, .. } = problem.start.clone();
    let last = last.unwrap_or(Sample { t, q, v, a, lambda, ..Sample::default() });
    summary.reached_end = false;
    let no_sensitivity = Some(fault);
    Err(Box::new(Failure {
        error: None,
        no_modes: None,
        no_sensitivity,
        start: None,
        summary,
        last,
    }))
}

/// Radau IIA, the sensitivities with its stages.
fn staggered(
    problem: Problem<'_>,
    (plan, columns): (&SensitivityPlan, &Function),
    observer: &mut dyn Observer,
    stop: &dyn Fn() -> bool,
) -> Result<Summary, Box<Failure>> {
    let Problem { compiled, start, options, .. } = problem;
    let mut mechanism = PhaseMechanism::new(problem);
    let mut sampler = Sampler::new(problem, &mechanism);
    let mut summary = Summary::default();
    summary.note_uniqueness(start.t, start.uniqueness.clone());

    // The start.
    summary.uniqueness.iter().for_each(|change| observer.uniqueness(change));
    let shown = (&plan.equations, plan.equations.channels.buffers(mechanism.parameters()));
    let tangents =
        Tangents::new(&plan.equations, compiled, mechanism.parameters(), start.inactive_rows());
    let mut shown = Shown { equations: shown.0, buffers: shown.1 };
    let first = &mut |sample: &Sample| {
        let mut all = plan.start.clone();
        all.iter_mut().enumerate().for_each(|(k, by)| shown.complete(sample, k, by));
        observer.sample(sample, &all)
    };
    if sampler.begin(start, &mut mechanism, &mut summary, first) == Control::Stop {
        return Ok(summary);
    }
    let method = MethodChange { t: start.t, method: Integrator::Radau, reason: Reason::Asked };
    summary.methods.push(method);

    // The steps.
    let mut run = SensitiveRun { mechanism, sampler, summary, tangents, shown, plan, columns };
    let end = run.integrate(problem, observer, stop);

    // The end.
    let SensitiveRun { sampler, mut summary, .. } = run;
    let last = sampler.sample;
    if sampler.is_undefined {
        return Err(Box::new(Failure::undefined(summary, last)));
    }
    match end {
        End::Reached | End::Stopped => {
            summary.reached_end = summary.t == options.t_end;
            Ok(summary)
        }
        End::Failed(error) => {
            let (no_modes, no_sensitivity) = (None, None);
            Err(Box::new(Failure { error, no_modes, no_sensitivity, start: None, summary, last }))
        }
    }
}

struct SensitiveRun<'a> {
    mechanism: PhaseMechanism<'a>,
    sampler: Sampler,
    summary: Summary,
    tangents: Tangents<'a>,
    shown: Shown<'a>,
    plan: &'a SensitivityPlan,
    columns: &'a Function,
}

/// The channels besides the state.
struct Shown<'a> {
    equations: &'a SensitivityEquations,
    buffers: Buffers,
}

impl Shown<'_> {
    fn complete(&mut self, sample: &Sample, k: usize, by: &mut StateSensitivity) {
        let Sample { t, q, v, a, lambda, .. } = sample;
        let state = StateRef { t: *t, q, v };
        let at = TangentPoint { state, acceleration: AccelerationRef { a, lambda } };
        let Self { equations, buffers } = self;
        by.channels = equations.channels.evaluate(buffers, at, equations.change(k), by);
    }
}

impl SensitiveRun<'_> {
    fn integrate(
        &mut self,
        problem: Problem<'_>,
        observer: &mut dyn Observer,
        stop: &dyn Fn() -> bool,
    ) -> End {
        let mut solver = match self.solver(problem, (self.plan, self.columns)) {
            Ok(solver) => solver,
            Err(error) => return End::Failed(Some(error)),
        };
        loop {
            // Take an accepted step.
            let step = match solver.step() {
                Ok(Some(step)) => step,
                Ok(None) => return End::Reached,
                Err(error) => return End::Failed(Some(error)),
            };

            // Throw it away where the equations lose their unique solution.
            let evaluator = &mut self.mechanism.evaluator;
            let multipliers = &mut self.sampler.multipliers;
            if problem.options.step.is_none() && is_ahead(evaluator, multipliers, &step.step) {
                return End::Failed(None);
            }

            // Hand out its samples.
            if self.pass(&step, observer) == Control::Stop || stop() {
                return End::Stopped;
            }
        }
    }

    /// The solver at the start.
    ///
    /// # Errors
    /// [`SolveError`] when the start is not finite.
    fn solver<'e>(
        &self,
        problem: Problem<'e>,
        (plan, columns): (&'e SensitivityPlan, &'e Function),
    ) -> Result<SensitivitySolver<SensitiveMotion<'e>>, SolveError> {
        let Problem { equations, start, options, .. } = problem;
        let equations: &MotionEquations = equations;
        let parameters = self.mechanism.parameters();
        let system = SensitiveMotion {
            motion: equations.at(parameters, start.inactive_rows()),
            n_parameters: plan.start.len(),
            function: columns,
            columns: columns.buffers(parameters),
        };
        let Start { t, q, v, a, lambda, .. } = start;
        let unknowns = |q: &[f64], v: &[f64], a: &[f64], lambda: &[f64]| {
            equations.unknowns(StateRef { t: *t, q, v }, AccelerationRef { a, lambda })
        };
        let from = unknowns(q, v, a, lambda);
        let of_start = |s: &StateSensitivity| unknowns(&s.q, &s.v, &s.a, &s.lambda);
        let (s, sdot) = plan.start.iter().map(of_start).map(|s| (s.y, s.ydot)).unzip();
        let begin = SensitivityStart { s, sdot };
        let settings = settings(options, equations);
        SensitivitySolver::new(system, from, &begin, options.t_end, settings)
    }

    /// Samples the output times of a step.
    fn pass(&mut self, step: &SensitivityStep<'_>, observer: &mut dyn Observer) -> Control {
        let mut completing = Completing {
            step,
            tangents: &mut self.tangents,
            shown: &mut self.shown,
            n_sensitive: self.plan.start.len(),
            s: vec![0.0; step.step.y1().len()],
            is_finite: true,
            observer,
        };
        let dense = DenseOutput::from(step.step);
        let Self { sampler, mechanism, summary, .. } = self;
        sampler.begin_step_without_work(summary);
        let control = sampler.pass(&dense, mechanism, summary, &mut completing);
        sampler.end_step(summary);
        sampler.is_undefined |= !completing.is_finite;
        summary.stats = dense.stats;
        control
    }
}

/// Completes the samples of one step by their sensitivities.
struct Completing<'a, 'b, 'c> {
    step: &'a SensitivityStep<'a>,
    tangents: &'a mut Tangents<'b>,
    shown: &'a mut Shown<'b>,
    n_sensitive: usize,
    /// The sensitivity of the integrator's unknowns to one quantity.
    s: Vec<f64>,
    is_finite: bool,
    observer: &'c mut dyn Observer,
}

impl Observer for Completing<'_, '_, '_> {
    fn sample(&mut self, sample: &Sample, _: &[StateSensitivity]) -> Control {
        let Self { step, tangents, shown, n_sensitive, s, .. } = self;
        let Sample { t, q, v, a, lambda, .. } = sample;
        let state = StateRef { t: *t, q, v };
        let at = TangentPoint { state, acceleration: AccelerationRef { a, lambda } };
        let mut by = |k: usize| {
            step.s_at(k, *t, s);
            let (dq, dv) = s[..2 * q.len()].split_at(q.len());
            let with = (shown.equations.change(k), &[][..]);
            let mut by = tangents.complete(at, with, (dq, dv))?;
            shown.complete(sample, k, &mut by);
            Ok::<_, NotFinite>(by)
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
    motion: MotionSystem<'a>,
    n_parameters: usize,
    /// F_p of (t, y, y′).
    function: &'a Function,
    columns: Buffers,
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
        self.n_parameters
    }

    /// Jacobian by parameters; values that are not finite are found by the solver.
    fn parameter_jacobian(
        &mut self,
        t: f64,
        y: &[f64],
        ydot: &[f64],
        out: &mut [f64],
    ) -> Result<(), NotFinite> {
        self.function.evaluate_into(&mut self.columns, &[&[t], y, ydot], out);
        for column in out.chunks_exact_mut(y.len()) {
            self.motion.held().iter().for_each(|&row| column[row] = 0.0);
        }
        Ok(())
    }
}
