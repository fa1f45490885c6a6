//! [`Run`]: a run in progress, step by step, from phase to phase.
//!
//! ```text
//! auto       explicit ──stiff or slow──▶ radau ──singular pose ahead──▶ explicit ──regular──▶ radau
//!            radau ──no longer stiff──▶ explicit
//! radau                          radau ──singular pose ahead──▶ explicit ──regular──▶ radau
//! explicit   explicit
//! ```
//!
//! A phase also ends where something switches (see [`crate::hybrid`]); the next one has the same
//! method and other modes.
//!
//! Through a singular pose the motion is smooth, only the implicit equations have no unique
//! solution. The accelerations have a limit there, explicit steps go on along the tangent, and
//! their error test keeps them on the branch.

use bksim_dae::{Checkpoint, Control, Noise, SolveError, Stats, StepSpan};

use super::checkpoint::{Fingerprint, RunCheckpoint, Unfit};
use super::ending::PhaseEnd;
use super::explicit::{ExplicitStart, ExplicitStepper};
use super::implicit::{RadauStart, RadauStepper};
use super::mechanism::PhaseMechanism;
use super::observer::Observer;
use super::pace::Pace;
use super::phase::{Attempt, Phase};
use super::problem::Problem;
use super::sampler::Sampler;
use super::singular::SingularMonitor;
use super::stepper::Stepper;
use super::summary::{Failure, Integrator, Reason, Summary};
use crate::held_assembly::AssemblyMonitor;
use crate::hybrid::{Crossed, NoConsistentModes, Passage};
use crate::multiplier::MultiplierSystem;
use crate::state::State;
use crate::whole_step::PendingStep;
use bksim_model::Method;

/// A run in progress: [`crate::run::run`] takes it to the end, [`Run::step`] by single steps.
pub struct Run<'a> {
    pub(super) problem: Problem<'a>,
    /// The mechanism in the modes of this phase.
    pub(super) mechanism: PhaseMechanism<'a>,
    pub(super) sampler: Sampler,
    /// The run so far.
    pub(super) summary: Summary,
    /// End of the last accepted step.
    pub(super) reached: State,
    /// Method of this phase.
    pub(super) method: Integrator,
    /// Multiplier system of the last phase; this one's stepper has its own.
    pub(super) multipliers: MultiplierSystem,
    pub(super) singular_monitor: SingularMonitor,
    /// Watches the assembly that the model holds, if it holds one.
    pub(super) assembly_monitor: Option<AssemblyMonitor<'a>>,
    /// Until when explicit steps pass a singular pose in Radau's place.
    pub(super) passing: Option<f64>,
    /// The time beyond which half a turn of a rope or belt is to be counted first.
    half_turn: Option<f64>,
    /// Where a phase failed last.
    pub(super) failed_at: Option<f64>,
    /// Counters of the phases before this one, and their noise.
    pub(super) before: Stats,
    pub(super) noise_before: Noise,
    pub(super) pace: Pace,
    pub(super) progress: Progress<'a>,
    /// The event that the last step ended at.
    pub(super) passed: Option<Passage>,
    /// The observer or the caller has asked to stop.
    pub(super) is_stopping: bool,
    /// The run as it was some steps ago, from which one that is stopped within a step goes on.
    mark: Option<Mark>,
}

/// A run between two steps, and how far it had come then.
struct Mark {
    numbers: Checkpoint,
    n_done: usize,
}

/// Steps and samples after which a run is marked again: a mark takes about as long as a step.
const MARK_PERIOD: usize = 100;

/// Where a run stands with its phase.
pub(super) enum Progress<'a> {
    /// The next phase has not begun.
    Between,
    /// A phase goes on from where it was saved.
    Saved(Checkpoint),
    /// A phase is in progress.
    Within(Box<Phase<'a>>),
    /// A step of it has been taken, up to the event in it, and not yet been passed to its end.
    Passing(Box<Phase<'a>>, Option<Crossed>),
}

/// Where a step has led.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum StepOutcome {
    /// The run can go on.
    Ongoing,
    /// The end time is reached.
    Reached,
    /// The observer or the caller asked to stop.
    Stopped,
}

/// Why a run cannot go on; nothing stated when the motion left its branch.
#[derive(Debug, Default)]
pub(super) struct Halt {
    /// The integrator's reason.
    pub(super) error: Option<SolveError>,
    /// Contacts or kinks without consistent modes.
    pub(super) no_modes: Option<NoConsistentModes>,
}

impl State {
    /// Takes the first of an integrator's unknowns.
    pub(super) fn take(&mut self, t: f64, y: &[f64]) {
        let nq = self.q.len();
        self.t = t;
        self.q.copy_from_slice(&y[..nq]);
        self.v.copy_from_slice(&y[nq..2 * nq]);
    }
}

impl<'a> Run<'a> {
    /// A run at its start, which is the first sample.
    pub fn begin(problem: Problem<'a>, observer: &mut dyn Observer) -> Self {
        let mut run = Self::new(problem);
        run.summary.note_uniqueness(problem.start.t, problem.start.uniqueness.clone());
        run.tell_uniqueness(0, observer);
        let Self { sampler, mechanism, summary, .. } = &mut run;
        let control = sampler.begin(problem.start, mechanism, summary, observer);
        let options = problem.options;
        let is_choice = options.method == Method::Auto && options.step.is_none();
        run.note(if is_choice { Reason::Cheapest } else { Reason::Asked });
        run.is_stopping = control == Control::Stop;
        run.watch_assembly();
        run
    }

    /// A run where it was stopped; samples kept back then are handed out now. Everything but the
    /// observer must be as it was when the run began.
    ///
    /// # Errors
    /// [`Unfit`] when the checkpoint belongs to another run.
    pub fn resume(
        problem: Problem<'a>,
        checkpoint: &RunCheckpoint,
        observer: &mut dyn Observer,
    ) -> Result<Self, Unfit> {
        checkpoint.check(&Fingerprint::of(problem))?;
        let mut run = Self::new(problem);
        run.load(&checkpoint.numbers).map_err(Unfit::Damaged)?;
        let control = run.sampler.hand_out_pending(&mut run.summary, observer);
        run.is_stopping = control == Control::Stop;
        run.watch_assembly();
        Ok(run)
    }

    pub(super) fn new(problem: Problem<'a>) -> Self {
        let Problem { start, options, .. } = problem;
        let mechanism = PhaseMechanism::new(problem);
        let method = match options.method {
            // Fixed steps are Radau's unless the others are asked for.
            Method::Auto if options.step.is_none() => Integrator::Explicit,
            Method::Auto | Method::Radau => Integrator::Radau,
            Method::Explicit => Integrator::Explicit,
        };
        Self {
            problem,
            sampler: Sampler::new(problem, &mechanism),
            summary: Summary::default(),
            reached: State { t: start.t, q: start.q.clone(), v: start.v.clone() },
            method,
            multipliers: mechanism.multipliers(),
            singular_monitor: SingularMonitor::default(),
            assembly_monitor: AssemblyMonitor::of(problem.compiled, mechanism.parameters()),
            mechanism,
            passing: None,
            half_turn: None,
            failed_at: None,
            before: Stats::default(),
            noise_before: Noise::default(),
            pace: Pace::begin(start.t, 0),
            progress: Progress::Between,
            passed: None,
            is_stopping: false,
            mark: None,
        }
    }

    /// Positions and velocities at the end of the last step, as the integrator has them.
    pub fn reached(&self) -> &State {
        &self.reached
    }

    /// The run so far.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// Takes one step of the integrator, hands out its samples, and passes the event or changes the
    /// method at its end. `stop` is asked once.
    ///
    /// # Errors
    /// [`Failure`] when the integrator cannot go on; the end of its last step has been handed out, unless forces have no bound there.
    pub fn step(
        &mut self,
        observer: &mut dyn Observer,
        stop: &dyn Fn() -> bool,
    ) -> Result<StepOutcome, Box<Failure>> {
        if self.is_stopping {
            return Ok(StepOutcome::Stopped);
        }
        self.keep_mark();
        let n_known = self.summary.uniqueness.len();
        let outcome = self.step_or_halt(observer, stop);
        if let Some(passed) = self.passed.take() {
            observer.passage(&passed);
        }
        self.tell_uniqueness(n_known, observer);
        if outcome.is_err() && !self.is_in_singular_pose() {
            self.hand_out_last(observer);
        }
        self.or_failure(outcome)
    }

    /// The step that is tried next, where it may be taken together with those of other runs.
    pub(super) fn pending(&self) -> Option<PendingStep<'_>> {
        match &self.progress {
            Progress::Within(phase) if !self.is_stopping => phase.stepper.pending(),
            _ => None,
        }
    }

    /// Room for the results of the step that was pending.
    pub(super) fn room_for(&mut self, span: StepSpan) -> Option<&mut Vec<f64>> {
        match &mut self.progress {
            Progress::Within(phase) => phase.stepper.room_for(span),
            _ => None,
        }
    }

    /// Hands out changes of uniqueness that the observer does not know.
    fn tell_uniqueness(&self, n_known: usize, observer: &mut dyn Observer) {
        self.summary.uniqueness[n_known..].iter().for_each(|change| observer.uniqueness(change));
    }

    /// An integrator's error as the reason to end the run.
    pub(super) fn halt(&mut self, error: SolveError) -> Halt {
        match self.failed(error) {
            PhaseEnd::Failed(error) => Halt { error, no_modes: None },
            _ => unreachable!("an error ends a phase as a failure"),
        }
    }

    /// An outcome, or the failure with what was reached.
    pub(super) fn or_failure<T>(&self, outcome: Result<T, Halt>) -> Result<T, Box<Failure>> {
        if let Some(failure) = self.undefined() {
            return Err(Box::new(failure));
        }
        let (summary, last) = (&self.summary, &self.sampler.sample);
        outcome.map_err(|Halt { error, no_modes }| {
            let (summary, last) = (summary.clone(), last.clone());
            let no_sensitivity = None;
            Box::new(Failure { error, no_modes, no_sensitivity, start: None, summary, last })
        })
    }

    /// The failure of a run of which the last sample had a number that is not finite.
    pub(crate) fn undefined(&self) -> Option<Failure> {
        let Self { summary, sampler, .. } = self;
        sampler.is_undefined.then(|| Failure::undefined(summary.clone(), sampler.sample.clone()))
    }

    /// Takes steps until one ends at or after `t`.
    ///
    /// # Errors
    /// [`Failure`] as [`Run::step`].
    pub fn advance_until(
        &mut self,
        t: f64,
        observer: &mut dyn Observer,
        stop: &dyn Fn() -> bool,
    ) -> Result<StepOutcome, Box<Failure>> {
        let Problem { start, options, .. } = self.problem;
        let forward = (options.t_end - start.t).signum();
        let mut outcome = StepOutcome::Ongoing;
        while outcome == StepOutcome::Ongoing && (t - self.reached.t) * forward > 0.0 {
            outcome = self.step(observer, stop)?;
        }
        Ok(outcome)
    }

    /// Ends the run. One that has been stopped hands out one more sample, at the end of its last
    /// step, and goes on from [`Summary::checkpoint`].
    pub fn finish(mut self, observer: &mut dyn Observer) -> Summary {
        let t_end = self.problem.options.t_end;
        if self.sampler.is_complete(&self.summary, t_end) {
            self.summary.reached_end = true;
            return self.summary;
        }
        let checkpoint = self.checkpoint();
        self.hand_out_last(observer);
        self.summary.reached_end = self.sampler.is_complete(&self.summary, t_end);
        if !self.summary.reached_end {
            self.summary.checkpoint = Some(checkpoint);
        }
        self.summary
    }

    /// State between two steps from which a run goes on: the present one, or an earlier one where the run
    /// was stopped within a step.
    pub fn checkpoint(&mut self) -> RunCheckpoint {
        let numbers = match &self.mark {
            Some(mark) if self.sampler.is_cut => mark.numbers.clone(),
            _ => self.save(),
        };
        RunCheckpoint::new(Fingerprint::of(self.problem), numbers)
    }

    /// Marks the run before a step that may have too many samples, where many steps have been taken since the last mark.
    fn keep_mark(&mut self) {
        let Stats { n_accept, .. } = self.summary.stats;
        let n_done = n_accept + self.summary.n_samples;
        let is_near = |mark: &Mark| n_done < mark.n_done + MARK_PERIOD;
        if self.sampler.may_be_cut() && !self.mark.as_ref().is_some_and(is_near) {
            self.mark = Some(Mark { numbers: self.save(), n_done });
        }
    }

    fn step_or_halt(
        &mut self,
        observer: &mut dyn Observer,
        stop: &dyn Fn() -> bool,
    ) -> Result<StepOutcome, Halt> {
        match self.take_step()? {
            None => self.conclude_step(observer, stop),
            Some(outcome) => Ok(outcome),
        }
    }

    /// Takes a step in the present phase, or in a new one; where there is none, the phase ends, and this
    /// returns what that has led to.
    pub(super) fn take_step(&mut self) -> Result<Option<StepOutcome>, Halt> {
        // A start with a number that is not finite goes nowhere.
        if self.sampler.is_undefined {
            return Err(Halt::default());
        }
        let mut phase = match self.phase() {
            Ok(phase) => phase,
            Err(error) => return self.end_phase(PhaseEnd::Failed(Some(error))).map(Some),
        };
        let attempt = self.step_in(&mut phase);
        match attempt.unwrap_or_else(|error| Attempt::End(self.failed(error))) {
            Attempt::Step(crossed) => {
                self.progress = Progress::Passing(phase, crossed);
                Ok(None)
            }
            Attempt::Rejected => {
                self.progress = Progress::Within(phase);
                Ok(Some(StepOutcome::Ongoing))
            }
            Attempt::End(end) => {
                self.multipliers.clone_from(phase.stepper.multipliers());
                self.end_phase(end).map(Some)
            }
        }
    }

    /// Passes the step that has been taken to its end, and goes over to the next phase where this one ends
    /// with it.
    pub(super) fn conclude_step(
        &mut self,
        observer: &mut dyn Observer,
        stop: &dyn Fn() -> bool,
    ) -> Result<StepOutcome, Halt> {
        let (mut phase, crossed) = match std::mem::replace(&mut self.progress, Progress::Between) {
            Progress::Passing(phase, crossed) => (phase, crossed),
            progress => {
                self.progress = progress;
                return Ok(self.ongoing());
            }
        };
        let mut end = self.conclude_in(&mut phase, crossed, observer, stop);
        if let Ok(None) = end {
            end = Ok(self.judge_pace(&phase, observer));
        }
        if let Ok(None) = end
            && self.tick_here().is_some()
        {
            end = Ok(Some(PhaseEnd::Tick));
        }
        let Some(end) = end.unwrap_or_else(|error| Some(self.failed(error))) else {
            self.progress = Progress::Within(phase);
            return Ok(self.ongoing());
        };
        self.multipliers.clone_from(phase.stepper.multipliers());
        let outcome = self.end_phase(end)?;
        match self.tick_here() {
            Some(_) => self.pass_tick(observer),
            None => Ok(outcome),
        }
    }

    /// Goes over to the next phase, if there is one.
    fn end_phase(&mut self, end: PhaseEnd) -> Result<StepOutcome, Halt> {
        let is_at_tick = self.tick_here().is_some();
        // A phase may end short of the end, to count half a turn there.
        let is_short = matches!(end, PhaseEnd::Reached)
            && self.half_turn.take().is_some()
            && self.reached.t != self.problem.options.t_end;
        if matches!(end, PhaseEnd::Reached) && !is_at_tick && !is_short {
            return Ok(StepOutcome::Reached);
        }
        (self.before, self.noise_before) = (self.summary.stats, self.summary.noise);
        match self.or_switched(end) {
            PhaseEnd::Switched(crossed) => self.pass_event(&crossed)?,
            // What stood short of a tick has reached it without a step.
            PhaseEnd::Reached if is_at_tick => self.enter_tick()?,
            PhaseEnd::Reached | PhaseEnd::Tick => (),
            PhaseEnd::HalfTurnAhead(t) => self.half_turn = Some(t),
            PhaseEnd::HalfTurn => {
                self.half_turn = None;
                self.mechanism.count_half_turns(&self.reached);
                self.sampler.count_half_turns(&self.mechanism);
            }
            PhaseEnd::OtherRows(inactive) => {
                self.mechanism.inactive = inactive;
                self.enter_rows();
            }
            end => self.change_method(end)?,
        }
        Ok(self.ongoing())
    }

    pub(super) fn ongoing(&self) -> StepOutcome {
        if self.is_stopping { StepOutcome::Stopped } else { StepOutcome::Ongoing }
    }

    /// The phase in progress, taken out; a new one where there is none.
    ///
    /// # Errors
    /// [`SolveError`] when its integrator cannot begin.
    fn phase(&mut self) -> Result<Box<Phase<'a>>, SolveError> {
        let saved = match std::mem::replace(&mut self.progress, Progress::Between) {
            Progress::Within(phase) => return Ok(phase),
            Progress::Passing(..) => unreachable!("a step is passed to its end before the next"),
            Progress::Saved(saved) => Some(saved),
            Progress::Between => None,
        };
        let Self { problem, mechanism, reached, sampler, half_turn, .. } = self;
        // Up to the next tick.
        let tick = mechanism.next_tick();
        let end = problem.options.t_end;
        let t_end =
            tick.filter(|tick| tick.is_before(end)).map_or(end, |tick| tick.t.max(reached.t));
        let forward = (t_end - reached.t).signum();
        let is_nearer = |t: &f64| (t - reached.t) * forward > 0.0 && (t_end - t) * forward > 0.0;
        let t_end = half_turn.filter(is_nearer).unwrap_or(t_end);
        sampler.hold_back(tick);
        let mut monitor = mechanism.monitor(reached);
        let stepper: Box<dyn Stepper + 'a> = match self.method {
            Integrator::Explicit => {
                if saved.is_none() {
                    self.singular_monitor.leave();
                }
                let start = ExplicitStart {
                    state: reached,
                    t_end,
                    work: self.summary.energy.work,
                    multipliers: &self.multipliers,
                    passing: self.passing,
                };
                let (saved, monitor) = (saved.as_ref(), monitor.as_mut());
                Box::new(ExplicitStepper::new(*problem, &start, mechanism, saved, monitor)?)
            }
            Integrator::Radau => {
                let start =
                    RadauStart { state: reached, t_end, multipliers: &mut self.multipliers };
                let (saved, monitor) = (saved.as_ref(), monitor.as_mut());
                Box::new(RadauStepper::new(*problem, start, mechanism, saved, monitor)?)
            }
        };
        Ok(Box::new(Phase { stepper, monitor }))
    }

    pub(super) fn failed(&mut self, error: SolveError) -> PhaseEnd {
        if let Some(stats) = error.stats() {
            self.summary.stats = *stats;
            self.summary.stats += self.before;
        }
        PhaseEnd::Failed(Some(error))
    }
}
