//! The legs of a run: stretches with one method, each from where the last one ended.
//!
//! ```text
//! auto       explicit ──stiff──▶ radau ──singular pose ahead──▶ explicit ──regular──▶ radau
//! radau                          radau ──singular pose ahead──▶ explicit ──regular──▶ radau
//! explicit   explicit
//! ```
//!
//! A leg also ends where something switches (see [`crate::hybrid`]); the next one has the same method and
//! other modes.
//!
//! Through a singular pose the motion is smooth, only the implicit equations have no unique
//! solution. The accelerations have a limit there, explicit steps go on along the tangent, and
//! their error test keeps them on the branch.

use bksim_dae::{Cause, Checkpoint, Control, SolveError, Stats, Step};

use super::recorder::{Recorder, Stretch};
use super::singular::{REGULAR, Watch};
use super::{Integrator, MethodChange, Observer, Reason};
use crate::compiled::CompiledSystem;
use crate::formulate::MotionEquations;
use crate::hybrid::{Crossed, EventMonitor, NoConsistentModes};
use crate::multiplier::{MultiplierSystem, largest};
use crate::start::Start;
use bksim_model::{Method, SolveOptions};

/// A run in its legs.
pub(crate) struct Run<'a, 'b> {
    pub(crate) recorder: Recorder<'a>,
    pub(super) options: &'b SolveOptions,
    pub(super) observer: &'b mut dyn Observer,
    stop: &'b dyn Fn() -> bool,
    /// What integrates.
    pub(super) method: Integrator,
    /// Constraint rows that follow from the others.
    pub(super) dependent: Vec<usize>,
    /// End of the last accepted step.
    pub(super) reached: State,
    pub(super) multipliers: MultiplierSystem,
    pub(super) watch: Watch,
    /// Until when explicit steps pass a singular pose in Radau's place.
    pub(super) passing: Option<f64>,
    /// Where a leg failed last.
    pub(super) failed_at: Option<f64>,
    /// Counters of the legs before this one.
    pub(super) before: Stats,
    /// The observer or the caller has asked to stop.
    is_stopping: bool,
    /// The leg in progress of a run that was stopped: its solver, and what is behind that.
    pub(super) leg: Option<Checkpoint>,
}

/// Positions and velocities at one instant.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct State {
    pub(super) t: f64,
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
}

impl State {
    pub(super) fn take(&mut self, t: f64, y: &[f64]) {
        let nq = self.q.len();
        self.t = t;
        self.q.copy_from_slice(&y[..nq]);
        self.v.copy_from_slice(&y[nq..2 * nq]);
    }
}

/// Why a leg ended.
pub(super) enum LegEnd {
    /// The end time is reached.
    Reached,
    /// The observer or the caller asked to stop; the leg is kept.
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
    pub(crate) unsettled: Option<NoConsistentModes>,
}

/// Dependent rows count as broken beyond this part of the mechanism's size.
const BRANCH_TOLERANCE: f64 = 1e-6;

impl<'a, 'b> Run<'a, 'b> {
    /// A run whose start has been recorded.
    pub(crate) fn new(
        recorder: Recorder<'a>,
        start: &Start,
        options: &'b SolveOptions,
        observer: &'b mut dyn Observer,
        stop: &'b dyn Fn() -> bool,
    ) -> Self {
        let reached = State { t: start.t, q: start.q.clone(), v: start.v.clone() };
        let multipliers = recorder.multipliers.clone();
        let method = match options.method {
            // Fixed steps are Radau's unless the others are asked for.
            Method::Auto if options.step.is_none() => Integrator::Explicit,
            Method::Auto | Method::Radau => Integrator::Radau,
            Method::Explicit => Integrator::Explicit,
        };
        Self {
            method,
            dependent: start.inactive_rows().to_vec(),
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
            is_stopping: false,
            leg: None,
        }
    }

    /// Notes the first method; nothing follows where the observer of the start has asked to stop.
    pub(crate) fn begin(&mut self, control: Control) {
        let is_choice = self.options.method == Method::Auto && self.options.step.is_none();
        self.note(if is_choice { Reason::Cheapest } else { Reason::Asked });
        self.is_stopping = control == Control::Stop;
    }

    /// Hands out what had been kept back of the last step.
    pub(crate) fn catch_up(&mut self) {
        let control = self.recorder.hand_out_pending(self.observer);
        self.is_stopping = control == Control::Stop;
    }

    /// Runs to the end, or until it is stopped; then it says from what it can go on.
    ///
    /// # Errors
    /// [`Halt`] says why the run cannot go on.
    pub(crate) fn run_to_end(
        &mut self,
        compiled: &'a CompiledSystem,
        equations: &MotionEquations,
    ) -> Result<Option<Checkpoint>, Halt> {
        while !self.is_stopping {
            let end = match self.method {
                Integrator::Explicit => self.explicit_leg(compiled),
                Integrator::Radau => self.radau_leg(equations),
            };
            match end {
                LegEnd::Reached => return Ok(None),
                LegEnd::Stopped => break,
                _ => (),
            }
            self.before = self.recorder.summary.stats;
            let passed = match self.or_switched(end) {
                LegEnd::Switched(crossed) => self.pass_event(compiled, &crossed),
                end => self.change_method(end),
            };
            if let Err(halt) = passed {
                self.record_last();
                return Err(halt);
            }
        }
        let checkpoint = self.save();
        self.record_last();
        Ok(Some(checkpoint).filter(|_| !self.recorder.is_cut))
    }

    /// Goes on with another method from where a leg has ended.
    fn change_method(&mut self, end: LegEnd) -> Result<(), Halt> {
        self.passing = None;
        let (method, reason) = match end {
            LegEnd::Stiff => (Integrator::Radau, Reason::Stiff),
            LegEnd::SingularAhead(t) => {
                self.passing = Some(t);
                (Integrator::Explicit, Reason::SingularPose)
            }
            LegEnd::Failed(error) => match self.after_failure(error.as_ref()) {
                Some(next) => next,
                None => return Err(Halt { error, unsettled: None }),
            },
            _ => (Integrator::Radau, Reason::Regular),
        };
        self.method = method;
        self.note(reason);
        Ok(())
    }

    /// What to try where a method has failed.
    fn after_failure(&mut self, error: Option<&SolveError>) -> Option<(Integrator, Reason)> {
        let t = self.reached.t;
        let is_stuck = self.failed_at.replace(t) == Some(t);
        let is_refused = matches!(error, Some(SolveError::Checkpoint { .. }));
        if is_stuck || is_refused || self.options.step.is_some() {
            return None;
        }
        match (self.options.method, self.method) {
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
    fn pass_event(&mut self, compiled: &'a CompiledSystem, crossed: &Crossed) -> Result<(), Halt> {
        let State { t, q, v } = &self.reached;
        let recorder = &mut self.recorder;
        let changes = &mut recorder.summary.changes;
        let state = (*t, q.clone(), v.clone());
        let settled = recorder.switching.pass(&crossed.fired, state, changes);
        let settled =
            settled.map_err(|unsettled| Halt { error: None, unsettled: Some(unsettled) })?;
        recorder.summary.energy.work += settled.impact_work;
        recorder.summary.energy.impacts += settled.impact_work;
        recorder.evaluator = compiled.evaluator(&recorder.switching.parameters);
        recorder.multipliers = MultiplierSystem::new(&compiled.shape, &settled.inactive);
        recorder.dependent.clone_from(&settled.inactive);
        self.multipliers = recorder.multipliers.clone();
        self.watch = Watch::default();
        self.dependent = settled.inactive;
        (self.reached.q, self.reached.v) = (settled.q, settled.v);
        Ok(())
    }

    /// What would end a leg from here; `None` when nothing ever switches.
    pub(super) fn lookout(&self) -> Option<EventMonitor<'a>> {
        let State { t, q, v } = &self.reached;
        self.recorder.switching.monitor(&self.dependent, (*t, q, v))
    }

    /// Takes a step up to where something switches in it; `None` when nothing does.
    pub(super) fn until_event(
        &mut self,
        lookout: &mut EventMonitor<'_>,
        step: &Step<'_>,
        has_work: bool,
    ) -> Option<LegEnd> {
        let crossed = lookout.first_in(step)?;
        let (n, nq) = (step.y1().len(), self.reached.q.len());
        let mut y = vec![0.0; n];
        step.at(crossed.t, &mut y);
        let at = |t: f64, y: &mut [f64]| step.at(t, &mut y[..n]);
        let stats = sum(&self.before, step.stats());
        let stretch = Stretch {
            t0: step.t0(),
            t1: crossed.t,
            at: &at,
            degree: step.degree(),
            has_work,
            h: step.h(),
            stats,
        };
        let control = self.recorder.pass(&stretch, self.observer);
        if has_work {
            self.recorder.summary.energy.work = y[2 * nq];
        }
        self.recorder.summary.stats = stats;
        self.reached.take(crossed.t, &y);
        self.or_stop(control);
        Some(LegEnd::Switched(crossed))
    }

    fn note(&mut self, reason: Reason) {
        let method = self.method;
        self.recorder.summary.methods.push(MethodChange { t: self.reached.t, method, reason });
    }

    /// Whether the run is to stop behind this step.
    pub(super) fn or_stop(&mut self, control: Control) -> bool {
        self.is_stopping = control == Control::Stop || (self.stop)();
        self.is_stopping
    }

    /// Weakness of the constraints where the run stands.
    pub(super) fn weakness(&mut self) -> f64 {
        let State { t, q, v } = &self.reached;
        self.multipliers.rank_margin_at(&self.recorder.evaluator.dynamics(*t, q, v))
    }

    /// Whether rows that used to follow from the others are broken at the end of a step: it has
    /// jumped over a singular pose onto a branch that only the other rows allow.
    pub(super) fn is_off_branch(&mut self, t: f64, y: &[f64]) -> bool {
        if self.dependent.is_empty() {
            return false;
        }
        let q = &y[..self.reached.q.len()];
        let size = q.iter().fold(1.0, |size: f64, value| size.max(value.abs()));
        let gap = largest(self.recorder.evaluator.constraints(t, q).value);
        gap.is_nan() || gap > BRANCH_TOLERANCE * size
    }

    pub(super) fn failed(&mut self, error: SolveError) -> LegEnd {
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
        let stretch = Stretch { t0: *t, t1: *t, at: &at, degree: 0, has_work: false, h, stats };
        self.recorder.take_last(&stretch, self.observer);
    }
}

/// Counters of two legs together.
pub(super) fn sum(before: &Stats, leg: &Stats) -> Stats {
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
