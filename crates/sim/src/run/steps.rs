//! The loop over the steps of a phase. A step is taken first, and passed to its end afterwards: a caller who holds
//! the run samples it in between.

use bksim_dae::{Advance, Control, SolveError};

use super::dense::DenseOutput;
use super::ending::PhaseEnd;
use super::observer::Observer;
use super::pace::{Slowness, TINY, Verdict};
use super::phase::{Attempt, Phase};
use super::progress::Run;
use super::race::STABLE;
use super::singular::{NOTICEABLE, Sighting, better_rows};
use super::stepper::Stepper;
use super::summary::Integrator;
use crate::half_turns::HalfTurn;
use crate::hybrid::Crossed;
use crate::multiplier::MultiplierSystem;
use bksim_model::Method;

impl<'a> Run<'a> {
    /// Takes one step of a phase.
    ///
    /// # Errors
    /// [`SolveError`] when the integrator cannot go on.
    pub(super) fn step_in(&mut self, phase: &mut Phase<'a>) -> Result<Attempt, SolveError> {
        let Phase { stepper, monitor } = phase;

        // Take an accepted step.
        match stepper.advance()? {
            Advance::Accepted => (),
            Advance::Rejected => return Ok(Attempt::Rejected),
            Advance::Ended => return Ok(Attempt::End(PhaseEnd::Reached)),
        }
        let atol = self.problem.options.atol;
        self.sampler.begin_step(stepper.as_ref(), &self.summary, atol);

        // Keep only the part of it before the first event.
        if let Some(monitor) = monitor
            && let Some(crossed) = monitor.first_in(&stepper.last_step()?)
        {
            return Ok(Attempt::Step(Some(crossed)));
        }

        // Or before half a turn of a rope or belt, which is counted there.
        if self.mechanism.counts_half_turns() {
            match self.mechanism.half_turn_in(&stepper.last_step()?) {
                Some(HalfTurn::At(t)) => {
                    return Ok(Attempt::Step(Some(Crossed { t, fired: Vec::new() })));
                }
                Some(HalfTurn::Ahead(t)) => {
                    self.summary.stats = *stepper.stats();
                    self.summary.stats += self.before;
                    return Ok(Attempt::End(PhaseEnd::HalfTurnAhead(t)));
                }
                None => (),
            }
        }

        // Throw it away where the equations lose their unique solution, or another branch begins.
        if stepper.is_singular_ahead(&mut self.mechanism.evaluator) {
            self.summary.stats = *stepper.stats();
            self.summary.stats += self.before;
            return Ok(Attempt::End(PhaseEnd::SingularAhead(stepper.t())));
        }
        if self.mechanism.is_off_branch(stepper.t(), &stepper.y()[..self.reached.q.len()]) {
            return Ok(Attempt::End(PhaseEnd::Failed(None)));
        }

        // Note the singular pose that it has crossed.
        let evaluator = &mut self.mechanism.evaluator;
        let poses = &mut self.summary.singular_poses;
        match stepper.crossed_singular_pose(evaluator, &mut self.singular_monitor)? {
            Some(Sighting::New(pose)) => poses.push(pose),
            Some(Sighting::Better(pose)) => {
                poses.pop();
                poses.push(pose);
            }
            None => (),
        }
        Ok(Attempt::Step(None))
    }

    /// Passes the step just taken to its end; returns why the phase ends with it, if it does.
    ///
    /// # Errors
    /// [`SolveError`] as [`Run::step_in`].
    pub(super) fn conclude_in(
        &mut self,
        phase: &mut Phase<'a>,
        crossed: Option<Crossed>,
        observer: &mut dyn Observer,
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<PhaseEnd>, SolveError> {
        let stepper = phase.stepper.as_mut();
        if let Some(crossed) = crossed {
            let control = self.pass_to(&crossed, stepper, observer)?;
            self.note_stop(control, stop);
            // Half a turn switches nothing.
            let is_half_turn = crossed.fired.is_empty();
            let end = if is_half_turn { PhaseEnd::HalfTurn } else { PhaseEnd::Switched(crossed) };
            return Ok((!self.sampler.is_cut).then_some(end));
        }

        // Hand out its samples, and stand at its end.
        let control = self.pass(stepper, observer)?;
        self.note_stop(control, stop);
        if self.sampler.is_cut {
            return Ok(None);
        }

        // Stay on the constraints.
        stepper.correct(&mut self.mechanism.evaluator, &mut self.reached)?;
        self.watch_assembly();

        // Leave the rest to other rows, or to another method, where they do better.
        if let Some(inactive) = self.other_rows(stepper.multipliers()) {
            return Ok(Some(PhaseEnd::OtherRows(inactive)));
        }
        Ok(stepper.succession())
    }

    /// The rows to be inactive from here on, where others than the active ones hold the motion better.
    fn other_rows(&mut self, multipliers: &MultiplierSystem) -> Option<Vec<usize>> {
        let Self { mechanism, reached, .. } = self;
        if mechanism.inactive.is_empty() || multipliers.rank_margin() >= NOTICEABLE {
            return None;
        }
        let (closed, at) = (mechanism.closed_rows(), (reached.t, &*reached.q));
        better_rows(&mut mechanism.evaluator, at, &mechanism.inactive, &closed)
    }

    /// Samples the step just taken at the instants that are due up to `t`, if it reaches that far;
    /// returns whether it does.
    ///
    /// # Errors
    /// [`SolveError`] as [`Run::step_in`].
    pub(super) fn pass_until(
        &mut self,
        t: f64,
        (phase, crossed): (&mut Phase<'a>, Option<&Crossed>),
        observer: &mut dyn Observer,
    ) -> Result<bool, SolveError> {
        let stepper = phase.stepper.as_mut();
        let forward = (self.problem.options.t_end - self.problem.start.t).signum();
        let end = crossed.map_or(stepper.t(), |crossed| crossed.t);
        // What is due at a tick is sampled after it.
        if (t - end) * forward > 0.0 || self.sampler.is_held_back(t) {
            return Ok(false);
        }
        let dense = self.dense_output(stepper, crossed)?;
        let Self { sampler, mechanism, summary, .. } = self;
        // Whoever holds a run decides by itself whether to go on.
        let _ = sampler.pass_until(t, &dense, mechanism, summary, observer);
        Ok(true)
    }

    /// The motion over the step just taken, up to the event in it.
    fn dense_output<'s>(
        &self,
        stepper: &'s mut dyn Stepper,
        crossed: Option<&Crossed>,
    ) -> Result<DenseOutput<'s>, SolveError> {
        let has_work = stepper.work().is_some() && !self.sampler.needs_work();
        let mut dense = match crossed {
            None => stepper.dense_output()?,
            Some(crossed) => {
                let mut dense = DenseOutput::from(stepper.last_step()?);
                dense.t1 = crossed.t;
                dense
            }
        };
        dense.has_work = has_work;
        dense.stats += self.before;
        Ok(dense)
    }

    /// Outputs of a whole step; its dense output is made only when it is needed.
    fn pass(
        &mut self,
        stepper: &mut dyn Stepper,
        observer: &mut dyn Observer,
    ) -> Result<Control, SolveError> {
        let mut control = Control::Continue;
        let (t0, t1) = (self.reached.t, stepper.t());
        let is_unknown = self.sampler.needs_work() || stepper.work().is_none();
        let needs_all = observer.wants_segments() || is_unknown;
        let due = self.sampler.due(t1);
        if needs_all || due.is_some() {
            let is_of_end = !needs_all && due == Some(t1);
            let dense = if is_of_end {
                let mut stats = self.before;
                stats += *stepper.stats();
                DenseOutput::end(t0, (t1, stepper.y()), stats)
            } else {
                self.dense_output(stepper, None)?
            };
            control = self.sampler.pass(&dense, &mut self.mechanism, &mut self.summary, observer);
        }
        // A step that is not passed to its end is no part of the run.
        if self.sampler.is_cut {
            return Ok(control);
        }
        match stepper.work() {
            Some(_) if self.sampler.needs_work() => stepper.set_work(self.summary.energy.work),
            Some(work) => self.summary.energy.work = work,
            None => (),
        }
        self.sampler.end_step(&mut self.summary);
        self.summary.stats = *stepper.stats();
        self.summary.stats += self.before;
        self.summary.noise = self.noise_before;
        self.summary.noise += stepper.noise();
        self.sampler.step_size = stepper.t() - self.reached.t;
        self.reached.take(stepper.t(), stepper.y());
        Ok(control)
    }

    /// Outputs of a step up to an event.
    fn pass_to(
        &mut self,
        crossed: &Crossed,
        stepper: &mut dyn Stepper,
        observer: &mut dyn Observer,
    ) -> Result<Control, SolveError> {
        let n = stepper.y().len();
        let dense = self.dense_output(stepper, Some(crossed))?;
        let control = self.sampler.pass(&dense, &mut self.mechanism, &mut self.summary, observer);
        if self.sampler.is_cut {
            return Ok(control);
        }
        let mut y = vec![0.0; n];
        dense.at(crossed.t, &mut y);
        if dense.has_work {
            // The last of the unknowns.
            self.summary.energy.work = y[n - 1];
        }
        self.sampler.end_step(&mut self.summary);
        self.summary.stats = dense.stats;
        self.sampler.step_size = dense.h;
        self.reached.take(crossed.t, &y);
        Ok(control)
    }

    /// Why the phase should end, if the run would take far too many steps.
    pub(super) fn judge_pace(
        &mut self,
        phase: &Phase<'a>,
        observer: &mut dyn Observer,
    ) -> Option<PhaseEnd> {
        let options = self.problem.options;
        let n_step = self.summary.stats.n_step;
        if self.method == Integrator::Radau && self.pace.has_lost(self.reached.t, n_step) {
            return Some(PhaseEnd::NoGain);
        }

        // Radau IIA may lead further for the same work, where stability limits explicit steps.
        let may_choose = options.method == Method::Auto && options.step.is_none();
        let may_choose = may_choose && self.passing.is_none();
        let is_explicit = self.method == Integrator::Explicit;
        let here = (self.reached.t, options.t_end);
        if may_choose
            && is_explicit
            && self.pace.begins_race(here, n_step, phase.stepper.stability())
        {
            return Some(PhaseEnd::Stiff);
        }

        // Or explicit steps for less.
        if may_choose
            && !is_explicit
            && let Some(way) = self.pace.looks_at_radau(self.reached.t, n_step)
            && self.spectral_radius().is_some_and(|radius| radius * way < STABLE)
        {
            self.pace.go_back();
            return Some(PhaseEnd::Relaxed);
        }

        // Judge how many steps are left.
        let end = (options.t_end, options.step.is_some());
        let (steps_left, is_hopeless) = match self.pace.observe(self.reached.t, n_step, end) {
            Verdict::Fine => return None,
            Verdict::Hopeless(left) => (left, true),
            Verdict::Slow(left) => (left, false),
        };

        // Radau IIA may need fewer, where the mechanism hardly moves in a step.
        let account = phase.stepper.account();
        let way = self.reached.v.iter().fold(0.0, |way: f64, v| way.max((v * account.h).abs()));
        let may_try = may_choose && is_explicit && self.pace.may_try();
        if may_try && (way < TINY || is_hopeless) {
            self.pace.try_radau(here, n_step, steps_left);
            return Some(PhaseEnd::Slow);
        }

        // Say so once, and when it is stopped.
        let is_stopped = is_hopeless && observer.stops_hopeless_runs();
        if is_stopped || self.summary.slowness.is_none() {
            let nq = self.reached.q.len();
            let slowness = Slowness::new(&account, nq, n_step, (steps_left, is_stopped));
            if !is_stopped {
                observer.slow(&slowness);
            }
            self.summary.slowness = Some(slowness);
        }
        let error = SolveError::TooManySteps { limit: n_step, at: Box::new(account) };
        is_stopped.then(|| self.failed(error))
    }

    /// Takes note that the observer or the caller asks to stop.
    fn note_stop(&mut self, control: Control, stop: &dyn Fn() -> bool) {
        self.is_stopping = control == Control::Stop || stop();
    }
}
