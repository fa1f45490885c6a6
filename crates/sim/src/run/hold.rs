//! A run that is held at given instants, in the middle of a step where they lie there.
//!
//! The step that covers an instant is taken, sampled there, and passed no further until a later instant is
//! asked for. So whatever is asked for, the steps are those of a run that nobody holds.

use bksim_dae::{Checkpoint, Control, SolveError};

use super::observer::Observer;
use super::pace::Pace;
use super::problem::Problem;
use super::progress::{Halt, Progress, Run, StepOutcome};
use super::sample::{Sample, StateSensitivity};
use super::sampler::Sampler;
use super::summary::{Failure, Summary};
use crate::modes::Modes;

/// Counters and energies of a run at the instant where it is held.
#[derive(Clone, Debug)]
pub(crate) struct Ledger {
    summary: Summary,
    /// V at the start of the run, J.
    potential_start: f64,
}

/// Nobody looks on: samples are read off the run.
pub(crate) struct Unobserved;

impl Observer for Unobserved {
    fn sample(&mut self, _: &Sample, _: &[StateSensitivity]) -> Control {
        Control::Continue
    }

    /// Whoever holds a run decides by itself how long to go on.
    fn stops_hopeless_runs(&self) -> bool {
        false
    }
}

impl<'a> Run<'a> {
    /// A run at its start, which goes on with the counters and energies of another one.
    pub(crate) fn begin_with(problem: Problem<'a>, ledger: Ledger) -> Self {
        let mut run = Self::begin(problem, &mut Unobserved);
        run.before = ledger.summary.stats;
        run.pace = Pace::begin(run.reached.t, run.before.n_step);
        run.summary = ledger.summary;
        run.sampler.potential_start = ledger.potential_start;
        run.sampler.sample.work = run.summary.energy.work;
        run
    }

    /// A run of the same problem where it was marked.
    pub(crate) fn at_mark(problem: Problem<'a>, mark: &Checkpoint) -> Self {
        Self::try_at_mark(problem, mark).expect("a mark fits the problem that it was made in")
    }

    /// Run ([`Run::at_mark`]) from a mark that may be another problem's.
    ///
    /// # Errors
    /// [`SolveError`] when it is.
    pub(crate) fn try_at_mark(problem: Problem<'a>, mark: &Checkpoint) -> Result<Self, SolveError> {
        let mut run = Self::new(problem);
        run.load(mark)?;
        Ok(run)
    }

    /// Counters and energies up to the sample taken last.
    pub(crate) fn ledger(&self) -> Ledger {
        let Sampler { sample, potential_start, .. } = &self.sampler;
        let mut summary = self.summary.clone();
        summary.energy.work = sample.work;
        Ledger { summary, potential_start: *potential_start }
    }

    /// Samples the motion at `t`, where the run has not yet been beyond; `mark` becomes the run before the
    /// step in which that lies, where it is another one. Returns false where `stop`, asked before every
    /// step, wishes so: the run then stands at the end of a step.
    ///
    /// # Errors
    /// [`Failure`] when the integrator cannot go on to there.
    pub(crate) fn hold_at(
        &mut self,
        t: f64,
        mark: &mut dyn FnMut(Checkpoint),
        stop: &dyn Fn() -> bool,
    ) -> Result<bool, Box<Failure>> {
        self.sampler.ask(t);
        loop {
            // Sample the step that has been taken, or pass it to its end, and sample there at a tick.
            if self.is_sampled_at(t)? {
                return Ok(true);
            }
            let concluded = self.conclude_step(&mut Unobserved, &|| false);
            self.or_held(concluded)?;
            if self.sampler.sample.t == t {
                return Ok(true);
            }

            // Take the next one.
            if stop() {
                return Ok(false);
            }
            mark(self.save());
            let taken = self.take_step();
            if self.or_held(taken)? == Some(StepOutcome::Reached) {
                return Ok(true);
            }
        }
    }

    /// An outcome, or the failure, with the run held at the end of its last step.
    fn or_held<T>(&mut self, outcome: Result<T, Halt>) -> Result<T, Box<Failure>> {
        if outcome.is_err() {
            self.hand_out_last(&mut Unobserved);
        }
        self.or_failure(outcome)
    }

    /// Samples the step that has been taken at `t`, if it covers that; returns whether it does.
    fn is_sampled_at(&mut self, t: f64) -> Result<bool, Box<Failure>> {
        let (mut phase, crossed) = match std::mem::replace(&mut self.progress, Progress::Between) {
            Progress::Passing(phase, crossed) => (phase, crossed),
            progress => {
                self.progress = progress;
                return Ok(false);
            }
        };
        let passed = self.pass_until(t, (&mut phase, crossed.as_ref()), &mut Unobserved);
        self.progress = Progress::Passing(phase, crossed);
        let passed = passed.map_err(|error| self.halt(error));
        self.or_failure(passed)
    }

    /// The sample taken last.
    pub(crate) fn sample(&self) -> &Sample {
        &self.sampler.sample
    }

    /// The modes of the step that has been taken last.
    pub(crate) fn modes(&self) -> &Modes {
        self.mechanism.modes_now()
    }
}
