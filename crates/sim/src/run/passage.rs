//! Passages from one phase of a [`Run`] to the next: another method, other modes, other rows.

use bksim_dae::{Cause, Control, SolveError};

use super::dense::DenseOutput;
use super::ending::PhaseEnd;
use super::mechanism::PhaseMechanism;
use super::observer::Observer;
use super::problem::Problem;
use super::progress::{Halt, Run, StepOutcome};
use super::sample::Sample;
use super::singular::{CLOSE, REGULAR, SingularMonitor};
use super::summary::{Integrator, MethodChange, Reason};
use crate::hybrid::{ConsistentModes, Crossed, Passage};
use crate::redundancy::MovingInstant;
use crate::sampled::Tick;
use crate::state::State;
use bksim_model::Method;

impl Run<'_> {
    /// Goes on with another method from where a phase has ended.
    pub(super) fn change_method(&mut self, end: PhaseEnd) -> Result<(), Halt> {
        self.passing = None;
        let (method, reason) = match end {
            PhaseEnd::Stiff => (Integrator::Radau, Reason::Stiff),
            PhaseEnd::Slow => (Integrator::Radau, Reason::Slow),
            PhaseEnd::NoGain => (Integrator::Explicit, Reason::NoGain),
            PhaseEnd::Relaxed => (Integrator::Explicit, Reason::Relaxed),
            PhaseEnd::SingularAhead(t) => {
                self.passing = Some(t);
                (Integrator::Explicit, Reason::SingularPose)
            }
            PhaseEnd::Failed(error) => match self.after_failure(error.as_ref()) {
                Some(next) => next,
                None => return Err(Halt { error, no_modes: None }),
            },
            PhaseEnd::Regular
            | PhaseEnd::Reached
            | PhaseEnd::Switched(_)
            | PhaseEnd::Tick
            | PhaseEnd::HalfTurn
            | PhaseEnd::HalfTurnAhead(_)
            | PhaseEnd::OtherRows(_) => (Integrator::Radau, Reason::Regular),
        };
        if reason == Reason::NoGain {
            self.pace.end_trial();
        }
        self.method = method;
        self.pace.restart(self.reached.t, self.summary.stats.n_step);
        self.note(reason);
        Ok(())
    }

    /// Method to try where one has failed.
    pub(super) fn after_failure(
        &mut self,
        error: Option<&SolveError>,
    ) -> Option<(Integrator, Reason)> {
        let t = self.reached.t;
        let is_stuck = self.failed_at.replace(t) == Some(t);
        let is_refused =
            matches!(error, Some(SolveError::Checkpoint { .. } | SolveError::TooManySteps { .. }));
        let options = self.problem.options;
        if is_stuck || is_refused || options.step.is_some() {
            return None;
        }
        match (options.method, self.method) {
            // It was only tried.
            (Method::Auto, Integrator::Radau) if self.pace.is_on_trial() => {
                Some((Integrator::Explicit, Reason::NoGain))
            }
            (Method::Auto, Integrator::Explicit) => Some((Integrator::Radau, Reason::OtherFailed)),
            (Method::Auto | Method::Radau, Integrator::Radau) if self.rank_margin() < REGULAR => {
                self.passing = Some(t);
                Some((Integrator::Explicit, Reason::SingularPose))
            }
            _ => None,
        }
    }

    /// A phase that failed short of a switch has reached it: beyond a kink, the branch on this side
    /// need have no value.
    pub(super) fn or_switched(&mut self, end: PhaseEnd) -> PhaseEnd {
        let PhaseEnd::Failed(Some(
            SolveError::NotFinite { .. }
            | SolveError::StepTooSmall { cause: Cause::NotFinite { .. }, .. },
        )) = end
        else {
            return end;
        };
        match self.mechanism.kink_ahead(&mut self.reached) {
            Some(crossed) => PhaseEnd::Switched(crossed),
            None => end,
        }
    }

    /// Goes on in other modes where something has switched.
    pub(super) fn pass_event(&mut self, crossed: &Crossed) -> Result<(), Halt> {
        let changes = &mut self.summary.changes;
        let before = self.mechanism.modes_now().clone();
        let inactive = self.mechanism.inactive.clone();
        let entered = self.mechanism.switch(crossed, self.reached.clone(), changes);
        let entered = entered.map_err(|no_modes| Halt { error: None, no_modes: Some(no_modes) })?;
        self.passed = Some(Passage {
            state: self.reached.clone(),
            before,
            inactive,
            fired: crossed.fired.clone(),
            after: entered.clone(),
        });
        self.take_modes(entered);
        Ok(())
    }

    /// Stands where an event has led.
    fn take_modes(&mut self, entered: ConsistentModes) {
        self.summary.energy.work += entered.impact_work;
        self.summary.energy.impacts += entered.impact_work;
        self.note_uniqueness(&entered);
        (self.reached.q, self.reached.v) = (entered.q, entered.v);
        self.enter_rows();
    }

    /// The tick that the run has come to, and not yet passed.
    pub(super) fn tick_here(&self) -> Option<Tick> {
        self.mechanism.next_tick().filter(|tick| !tick.is_after(self.reached.t))
    }

    /// Goes on with the values that sampled signals take at a tick.
    pub(super) fn enter_tick(&mut self) -> Result<(), Halt> {
        let changes = &mut self.summary.changes;
        let entered = self.mechanism.tick(self.reached.clone(), changes);
        let entered = entered.map_err(|no_modes| Halt { error: None, no_modes: Some(no_modes) })?;
        if let Some(entered) = entered {
            self.take_modes(entered);
        }
        Ok(())
    }

    /// Passes a tick, and hands out what is due there.
    pub(super) fn pass_tick(&mut self, observer: &mut dyn Observer) -> Result<StepOutcome, Halt> {
        self.enter_tick()?;
        let Self { sampler, mechanism, summary, reached, .. } = self;
        let dense = DenseOutput::instant(reached.as_ref(), sampler.step_size, summary.stats);
        let is_stopping = self.is_stopping;
        let control = sampler.take_tick(&dense, mechanism, summary, (observer, is_stopping));
        self.is_stopping |= control == Control::Stop;
        let is_end = self.reached.t == self.problem.options.t_end && !self.is_stopping;
        Ok(if is_end { StepOutcome::Reached } else { self.ongoing() })
    }

    /// Goes on with the rows that the mechanism now has active.
    pub(super) fn enter_rows(&mut self) {
        self.sampler.enter(&self.mechanism);
        self.multipliers = self.mechanism.multipliers();
        self.singular_monitor = SingularMonitor::default();
    }

    /// Takes note of which reactions are unique in other modes.
    pub(super) fn note_uniqueness(&mut self, entered: &ConsistentModes) {
        let Problem { compiled, parameters, .. } = self.problem;
        let t = self.reached.t;
        let instant = MovingInstant { t, q: &entered.q, v: &entered.v, a: &entered.a };
        let uniqueness = compiled.uniqueness(parameters, instant, &entered.modes);
        self.summary.note_uniqueness(t, uniqueness);
    }

    pub(super) fn note(&mut self, reason: Reason) {
        let method = self.method;
        self.summary.methods.push(MethodChange { t: self.reached.t, method, reason });
    }

    /// True if the last step ends so near to a singular pose that multipliers are without bound.
    pub(super) fn is_in_singular_pose(&mut self) -> bool {
        self.rank_margin() < CLOSE
    }

    /// Rank margin of the constraints at the end of the last step.
    pub(super) fn rank_margin(&mut self) -> f64 {
        let State { t, q, v } = &self.reached;
        self.multipliers.rank_margin_at(&self.mechanism.evaluator.dynamics(*t, q, v))
    }

    /// Notes where, since the state that was reached last, the motion passed over into another assembly.
    pub(super) fn watch_assembly(&mut self) {
        let Self { assembly_monitor: Some(monitor), mechanism, reached, summary, .. } = self else {
            return;
        };
        let PhaseMechanism { evaluator, inactive, .. } = mechanism;
        let State { t, q, v } = reached;
        summary.assembly_changes.extend(monitor.observe(evaluator, inactive, None, (*t, q, v)));
    }

    /// Hands out the end of the last step of a run that ends early.
    pub(super) fn hand_out_last(&mut self, observer: &mut dyn Observer) {
        let Self { sampler, mechanism, summary, reached, .. } = self;
        let Sample { step_size, .. } = sampler.sample;
        let dense = DenseOutput::instant(reached.as_ref(), step_size, summary.stats);
        sampler.take_last(&dense, mechanism, summary, observer);
    }
}
