//! The legs of a run: stretches with one method, each from where the last one ended.
//!
//! ```text
//! auto       explicit ──stiff──▶ radau ──singular pose ahead──▶ explicit ──regular──▶ radau
//! radau                          radau ──singular pose ahead──▶ explicit ──regular──▶ radau
//! explicit   explicit
//! ```
//!
//! A leg also ends where something switches (see [`crate::switch`]); the next one has the same method and
//! other modes.
//!
//! Through a singular pose the motion is smooth, only the implicit equations have no unique
//! solution. The accelerations have a limit there, explicit steps go on along the tangent, and
//! their error test keeps them on the branch.

use bksim_dae::{Cause, Control, ExplicitSolver, SolveError, Solver, Start as From, Stats, Step};

use super::explicit::ExplicitMotion;
use super::implicit::settings;
use super::recorder::{Recorder, Stretch};
use super::singular::{NOTICEABLE, REGULAR, Sighting, Watch, is_ahead};
use super::{Integrator, MethodChange, Reason, Sample};
use crate::compile::CompiledSystem;
use crate::formulate::MotionEquations;
use crate::model::{Formulation, Method, SolveOptions};
use crate::multiplier::{MultiplierSystem, largest};
use crate::start::Start;
use crate::switch::{Crossed, Lookout, Unsettled};

/// A run in its legs.
pub(crate) struct Run<'a, 'b> {
    pub(crate) recorder: Recorder<'a>,
    options: &'b SolveOptions,
    observer: &'b mut dyn FnMut(&Sample) -> Control,
    stop: &'b dyn Fn() -> bool,
    /// Constraint rows that follow from the others.
    dependent: Vec<usize>,
    /// End of the last accepted step.
    reached: State,
    multipliers: MultiplierSystem,
    watch: Watch,
    /// Until when explicit steps pass a singular pose in Radau's place.
    passing: Option<f64>,
    /// Where a leg failed last.
    failed_at: Option<f64>,
    /// Counters of the legs before this one.
    before: Stats,
}

/// Positions and velocities at one instant.
#[derive(Clone, PartialEq, Debug)]
struct State {
    t: f64,
    q: Vec<f64>,
    v: Vec<f64>,
}

impl State {
    fn take(&mut self, t: f64, y: &[f64]) {
        let nq = self.q.len();
        self.t = t;
        self.q.copy_from_slice(&y[..nq]);
        self.v.copy_from_slice(&y[nq..2 * nq]);
    }
}

/// Why a leg ended.
enum LegEnd {
    /// The end time is reached.
    Reached,
    /// The observer or the caller asked to stop.
    Stopped,
    /// Stability limits explicit steps.
    Stiff,
    /// A step of Radau's, up to this time, came near a singular pose; it is not part of the run.
    SingularAhead(f64),
    /// Explicit steps have passed it.
    Regular,
    /// Something switched where the run stands now.
    Switched(Crossed),
    /// The integrator cannot go on; `None` when the motion left its branch.
    Failed(Option<SolveError>),
}

/// Why a run cannot go on; nothing stated when the motion left its branch.
#[derive(Debug, Default)]
pub(crate) struct Halt {
    /// The integrator's reason.
    pub(crate) error: Option<SolveError>,
    /// What has no consistent modes.
    pub(crate) unsettled: Option<Unsettled>,
}

/// Dependent rows count as broken beyond this part of the mechanism's size.
const BRANCH_TOLERANCE: f64 = 1e-6;

impl<'a, 'b> Run<'a, 'b> {
    /// A run whose start has been recorded.
    pub(crate) fn new(
        recorder: Recorder<'a>,
        start: &Start,
        options: &'b SolveOptions,
        observer: &'b mut dyn FnMut(&Sample) -> Control,
        stop: &'b dyn Fn() -> bool,
    ) -> Self {
        let reached = State { t: start.t, q: start.q.clone(), v: start.v.clone() };
        let multipliers = recorder.multipliers.clone();
        Self {
            dependent: start.dependent_rows().to_vec(),
            recorder,
            options,
            observer,
            stop,
            reached,
            multipliers,
            watch: Watch::default(),
            passing: None,
            failed_at: None,
            before: Stats::default(),
        }
    }

    /// Runs to the end, or until it is stopped.
    ///
    /// # Errors
    /// [`Halt`] says why the run cannot go on.
    pub(crate) fn run_to_end(
        &mut self,
        compiled: &'a CompiledSystem,
        equations: &MotionEquations,
    ) -> Result<(), Halt> {
        let is_fixed = self.options.step.is_some();
        let (mut method, reason) = match self.options.method {
            Method::Auto if is_fixed => (Integrator::Radau, Reason::Asked),
            Method::Auto => (Integrator::Explicit, Reason::Cheapest),
            Method::Radau => (Integrator::Radau, Reason::Asked),
            Method::Explicit => (Integrator::Explicit, Reason::Asked),
        };
        self.note(method, reason);
        loop {
            let end = match method {
                Integrator::Explicit => self.explicit_leg(compiled),
                Integrator::Radau => self.radau_leg(equations),
            };
            self.before = self.recorder.summary.stats;
            let end = self.or_switched(end);
            if let LegEnd::Switched(crossed) = end {
                if let Err(fault) = self.pass_event(compiled, &crossed) {
                    self.record_last();
                    return Err(Halt { error: None, unsettled: Some(fault) });
                }
                continue;
            }
            self.passing = None;
            let reason;
            (method, reason) = match end {
                LegEnd::Reached | LegEnd::Switched(_) => return Ok(()),
                LegEnd::Stopped => {
                    self.record_last();
                    return Ok(());
                }
                LegEnd::Stiff => (Integrator::Radau, Reason::Stiff),
                LegEnd::Regular => (Integrator::Radau, Reason::Regular),
                LegEnd::SingularAhead(t) => {
                    self.passing = Some(t);
                    (Integrator::Explicit, Reason::SingularPose)
                }
                LegEnd::Failed(error) => {
                    let Some(next) = self.after_failure(method) else {
                        self.record_last();
                        return Err(Halt { error, unsettled: None });
                    };
                    next
                }
            };
            self.note(method, reason);
        }
    }

    /// What to try where a method has failed.
    fn after_failure(&mut self, method: Integrator) -> Option<(Integrator, Reason)> {
        let t = self.reached.t;
        let is_stuck = self.failed_at.replace(t) == Some(t);
        if is_stuck || self.options.step.is_some() {
            return None;
        }
        match (self.options.method, method) {
            (Method::Auto, Integrator::Explicit) => Some((Integrator::Radau, Reason::OtherFailed)),
            (Method::Auto | Method::Radau, Integrator::Radau) if self.weakness() < REGULAR => {
                self.passing = Some(t);
                Some((Integrator::Explicit, Reason::SingularPose))
            }
            _ => None,
        }
    }

    /// A leg that failed short of a switch has reached it: what lies behind a kink need have no value
    /// on this side's branch.
    fn or_switched(&mut self, end: LegEnd) -> LegEnd {
        let LegEnd::Failed(Some(
            SolveError::NotFinite { .. }
            | SolveError::StepTooSmall { cause: Cause::NotFinite { .. }, .. },
        )) = end
        else {
            return end;
        };
        let State { t, q, v } = &mut self.reached;
        match self.recorder.switching.kink_ahead(t, q, v, &self.dependent) {
            Some(crossed) => LegEnd::Switched(crossed),
            None => end,
        }
    }

    /// Goes on in other modes where something has switched.
    fn pass_event(
        &mut self,
        compiled: &'a CompiledSystem,
        crossed: &Crossed,
    ) -> Result<(), Unsettled> {
        let State { t, q, v } = &self.reached;
        let recorder = &mut self.recorder;
        let changes = &mut recorder.summary.changes;
        let state = (*t, q.clone(), v.clone());
        let settled = recorder.switching.pass(&crossed.fired, state, changes)?;
        recorder.summary.energy.work += settled.blow;
        recorder.summary.energy.blows += settled.blow;
        recorder.evaluator = compiled.evaluator(&recorder.switching.parameters);
        recorder.multipliers = MultiplierSystem::new(&compiled.shape, &settled.dependent);
        self.multipliers = recorder.multipliers.clone();
        self.watch = Watch::default();
        self.dependent = settled.dependent;
        (self.reached.q, self.reached.v) = (settled.q, settled.v);
        Ok(())
    }

    /// What would end a leg from here; `None` when nothing ever switches.
    fn lookout(&self) -> Option<Lookout<'a>> {
        let State { t, q, v } = &self.reached;
        self.recorder.switching.lookout(&self.dependent, (*t, q, v))
    }

    /// Takes a step up to where something switches in it; `None` when nothing does.
    fn until_event(
        &mut self,
        lookout: &mut Lookout<'_>,
        step: &Step<'_>,
        has_work: bool,
    ) -> Option<LegEnd> {
        let crossed = lookout.first_in(step)?;
        let (n, nq) = (step.y1().len(), self.reached.q.len());
        let mut y = vec![0.0; n];
        step.at(crossed.t, &mut y);
        let at = |t: f64, y: &mut [f64]| step.at(t, &mut y[..n]);
        let stats = sum(&self.before, step.stats());
        let stretch =
            Stretch { t0: step.t0(), t1: crossed.t, at: &at, has_work, h: step.h(), stats };
        let control = self.recorder.pass(&stretch, self.observer);
        if has_work {
            self.recorder.summary.energy.work = y[2 * nq];
        }
        self.recorder.summary.stats = stats;
        self.reached.take(crossed.t, &y);
        let is_over = self.or_stop(control) == Control::Stop;
        Some(if is_over { LegEnd::Stopped } else { LegEnd::Switched(crossed) })
    }

    fn note(&mut self, method: Integrator, reason: Reason) {
        self.recorder.summary.methods.push(MethodChange { t: self.reached.t, method, reason });
    }

    /// Integrates with explicit steps.
    fn explicit_leg(&mut self, compiled: &'a CompiledSystem) -> LegEnd {
        let nq = self.reached.q.len();
        let parameters = &self.recorder.switching.parameters;
        let motion = ExplicitMotion::new(compiled, parameters, self.multipliers.clone());
        let mut lookout = self.lookout();
        let State { t, q, v } = &self.reached;
        let y = [q.as_slice(), v, &[self.recorder.summary.energy.work]].concat();
        let from = From { t: *t, ydot: vec![0.0; y.len()], y };
        let settings = ExplicitMotion::settings(self.options, nq);
        let mut solver = match ExplicitSolver::new(motion, from, self.options.t_end, settings) {
            Ok(solver) => solver,
            Err(error) => return LegEnd::Failed(Some(error)),
        };
        self.watch.leave();
        let may_switch = self.options.method == Method::Auto && self.passing.is_none();
        let end = loop {
            match solver.advance() {
                Ok(true) => (),
                Ok(false) => break LegEnd::Reached,
                Err(error) => break self.failed(error),
            }
            if let Some(lookout) = &mut lookout {
                let step = match solver.last_step() {
                    Ok(step) => step,
                    Err(error) => break self.failed(error),
                };
                if let Some(end) = self.until_event(lookout, &step, true) {
                    break end;
                }
            }
            let motion = solver.system_mut();
            let weakness = motion.multipliers.weakness();
            let weakest = std::mem::replace(&mut motion.weakest, weakness);
            if self.is_off_branch(solver.t(), solver.y()) {
                break LegEnd::Failed(None);
            }
            if weakest >= NOTICEABLE {
                self.watch.leave();
            } else if let Err(error) = self.search_singular_pose(&mut solver) {
                break self.failed(error);
            }
            match self.pass_explicit_step(&mut solver) {
                Ok(Control::Continue) => (),
                Ok(Control::Stop) => break LegEnd::Stopped,
                Err(error) => break self.failed(error),
            }
            let is_past = |until: f64| (solver.t() - until) * solver.h().signum() >= 0.0;
            if weakness > REGULAR && self.passing.is_some_and(is_past) {
                break LegEnd::Regular;
            }
            if may_switch && solver.is_stiff() {
                break LegEnd::Stiff;
            }
        };
        self.multipliers.clone_from(&solver.system_mut().multipliers);
        end
    }

    /// Outputs of an explicit step; its dense output is made only when it is needed.
    fn pass_explicit_step(
        &mut self,
        solver: &mut ExplicitSolver<ExplicitMotion<'_>>,
    ) -> Result<Control, SolveError> {
        let (t0, t1, nq) = (self.reached.t, solver.t(), self.reached.q.len());
        let mut control = Control::Continue;
        if self.recorder.due(t1).is_some() {
            let step = solver.last_step()?;
            let n = step.y1().len();
            let at = |t: f64, y: &mut [f64]| step.at(t, &mut y[..n]);
            let stats = sum(&self.before, step.stats());
            let stretch = Stretch { t0, t1, at: &at, has_work: true, h: t1 - t0, stats };
            control = self.recorder.pass(&stretch, self.observer);
        }
        self.recorder.summary.energy.work = solver.y()[2 * nq];
        self.recorder.summary.stats = sum(&self.before, solver.stats());
        self.reached.take(t1, solver.y());
        Ok(self.or_stop(control))
    }

    fn or_stop(&self, control: Control) -> Control {
        if control == Control::Stop || (self.stop)() { Control::Stop } else { Control::Continue }
    }

    /// Looks for a singular pose in a step with a weak stage.
    fn search_singular_pose(
        &mut self,
        solver: &mut ExplicitSolver<ExplicitMotion<'_>>,
    ) -> Result<(), SolveError> {
        self.multipliers.clone_from(&solver.system_mut().multipliers);
        let step = solver.last_step()?;
        let evaluator = &mut self.recorder.evaluator;
        let poses = &mut self.recorder.summary.singular_poses;
        match self.watch.search(evaluator, &mut self.multipliers, &step) {
            Some(Sighting::New(pose)) => poses.push(pose),
            Some(Sighting::Better(pose)) => {
                poses.pop();
                poses.push(pose);
            }
            None => (),
        }
        Ok(())
    }

    /// Integrates with Radau IIA.
    fn radau_leg(&mut self, equations: &MotionEquations) -> LegEnd {
        let is_watching = self.options.step.is_none();
        let State { t, q, v } = &self.reached;
        let (mut a, mut lambda) =
            (vec![0.0; q.len()], vec![0.0; self.recorder.sample.lambda.len()]);
        let at = self.recorder.evaluator.dynamics(*t, q, v);
        // What is not finite here is found, and named, by the first step.
        let _ = self.multipliers.accelerations_into(&at, &mut a, &mut lambda);
        let motion = equations.at(&self.recorder.switching.parameters, &self.dependent);
        let mut lookout = self.lookout();
        let (y, ydot) = equations.state(q, v, &a, &lambda);
        let from = From { t: *t, y, ydot };
        let settings = settings(self.options, equations);
        let mut solver = match Solver::new(motion, from, self.options.t_end, settings) {
            Ok(solver) => solver,
            Err(error) => return LegEnd::Failed(Some(error)),
        };
        loop {
            let step = match solver.step() {
                Ok(Some(step)) => step,
                Ok(None) => return LegEnd::Reached,
                Err(error) => return self.failed(error),
            };
            if let Some(lookout) = &mut lookout
                && let Some(end) = self.until_event(lookout, &step, false)
            {
                return end;
            }
            let evaluator = &mut self.recorder.evaluator;
            if is_watching && is_ahead(evaluator, &mut self.multipliers, &step) {
                self.recorder.summary.stats = sum(&self.before, step.stats());
                return LegEnd::SingularAhead(step.t1());
            }
            if self.is_off_branch(step.t1(), step.y1()) {
                return LegEnd::Failed(None);
            }
            if self.pass_radau_step(&step) == Control::Stop {
                return LegEnd::Stopped;
            }
            if self.options.formulation == Formulation::Index1
                && let Err(error) = self.project(&mut solver, equations)
            {
                return self.failed(error);
            }
        }
    }

    fn pass_radau_step(&mut self, step: &Step<'_>) -> Control {
        let n = step.y1().len();
        let at = |t: f64, y: &mut [f64]| step.at(t, &mut y[..n]);
        let stats = sum(&self.before, step.stats());
        let stretch =
            Stretch { t0: step.t0(), t1: step.t1(), at: &at, has_work: false, h: step.h(), stats };
        let control = self.recorder.pass(&stretch, self.observer);
        self.recorder.summary.stats = stats;
        self.reached.take(step.t1(), step.y1());
        self.or_stop(control)
    }

    /// Puts the end of a step of index 1 back onto the constraints, from which it drifts.
    fn project<S: bksim_dae::System>(
        &mut self,
        solver: &mut Solver<S>,
        equations: &MotionEquations,
    ) -> Result<(), SolveError> {
        const CORRECTIONS: usize = 2;
        let State { t, q, v } = &mut self.reached;
        let evaluator = &mut self.recorder.evaluator;
        let (mut a, mut lambda) =
            (vec![0.0; q.len()], vec![0.0; self.recorder.sample.lambda.len()]);
        // The factors of the state before the projection; what is not finite shows in the next step.
        let _ = self.multipliers.factor(&evaluator.dynamics(*t, q, v));
        self.multipliers.project(evaluator, *t, (&mut *q, &mut *v), CORRECTIONS);
        let at = evaluator.dynamics(*t, q, v);
        let _ = self.multipliers.accelerations_into(&at, &mut a, &mut lambda);
        let (y, ydot) = equations.state(q, v, &a, &lambda);
        solver.correct_state(&y, &ydot)
    }

    /// Weakness of the constraints where the run stands.
    fn weakness(&mut self) -> f64 {
        let State { t, q, v } = &self.reached;
        self.multipliers.weakness_at(&self.recorder.evaluator.dynamics(*t, q, v))
    }

    /// Whether rows that used to follow from the others are broken at the end of a step: it has
    /// jumped over a singular pose onto a branch that only the other rows allow.
    fn is_off_branch(&mut self, t: f64, y: &[f64]) -> bool {
        if self.dependent.is_empty() {
            return false;
        }
        let q = &y[..self.reached.q.len()];
        let size = q.iter().fold(1.0, |size: f64, value| size.max(value.abs()));
        let gap = largest(self.recorder.evaluator.constraints(t, q).value);
        gap.is_nan() || gap > BRANCH_TOLERANCE * size
    }

    fn failed(&mut self, error: SolveError) -> LegEnd {
        if let Some(stats) = error.stats() {
            self.recorder.summary.stats = sum(&self.before, stats);
        }
        LegEnd::Failed(Some(error))
    }

    /// Hands out the end of the last step of a run that ends early.
    fn record_last(&mut self) {
        let State { t, q, v } = &self.reached;
        let nq = q.len();
        let at = |_: f64, y: &mut [f64]| {
            y[..nq].copy_from_slice(q);
            y[nq..2 * nq].copy_from_slice(v);
        };
        let h = self.recorder.sample.step_size;
        let stats = self.recorder.summary.stats;
        let stretch = Stretch { t0: *t, t1: *t, at: &at, has_work: false, h, stats };
        self.recorder.take_last(&stretch, self.observer);
    }
}

/// Counters of two legs together.
fn sum(before: &Stats, leg: &Stats) -> Stats {
    Stats {
        n_step: before.n_step + leg.n_step,
        n_accept: before.n_accept + leg.n_accept,
        n_reject: before.n_reject + leg.n_reject,
        n_newton_failed: before.n_newton_failed + leg.n_newton_failed,
        n_newton: before.n_newton + leg.n_newton,
        n_residual: before.n_residual + leg.n_residual,
        n_jacobian: before.n_jacobian + leg.n_jacobian,
        n_factor: before.n_factor + leg.n_factor,
        n_solve: before.n_solve + leg.n_solve,
    }
}
