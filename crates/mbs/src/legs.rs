//! The legs of a run between singular poses: integrate, and where a pose stops the integrator or
//! throws it off its branch, cross it from the last good state and go on behind.

use std::collections::VecDeque;

use bksim_dae::{Control, End, SolveError, Stats, Step, solve};

use crate::crossing::{REGULAR, State, cross, land, smallest_singular_value, with_accelerations};
use crate::formulate::MotionEquations;
use crate::linear::project;
use crate::model::SolveOptions;
use crate::recorder::{Recorder, Stretch};
use crate::run::{Sample, residuals, settings};
use crate::start::Start;

/// A run in its legs between singular poses.
pub(crate) struct Run<'a, 'b> {
    pub(crate) recorder: Recorder<'a>,
    observer: &'b mut dyn FnMut(&Sample) -> Control,
    stop: &'b dyn Fn() -> bool,
    /// The observer wants no more.
    pub(crate) is_stopped: bool,
    /// Where the next leg starts.
    reached: State,
    /// Ends of the last accepted steps of this leg.
    history: VecDeque<State>,
    lambda: Vec<f64>,
    /// A step jumped to where rows that depended on others no longer hold.
    left_branch: bool,
    /// Counters of the legs before this one.
    before: Stats,
}

/// Dependent rows count as broken beyond this part of the mechanism's size.
const BRANCH_TOLERANCE: f64 = 1e-6;

/// States kept of a leg; the approach to a singular pose takes fewer steps.
const HISTORY: usize = 1024;

impl<'a, 'b> Run<'a, 'b> {
    /// A run that has recorded its start.
    pub(crate) fn new(
        recorder: Recorder<'a>,
        start: &Start,
        observer: &'b mut dyn FnMut(&Sample) -> Control,
        stop: &'b dyn Fn() -> bool,
    ) -> Self {
        let reached =
            State { t: start.t, q: start.q.clone(), v: start.v.clone(), a: start.a.clone() };
        Self {
            recorder,
            observer,
            stop,
            is_stopped: false,
            reached,
            history: VecDeque::with_capacity(HISTORY),
            lambda: start.lambda.clone(),
            left_branch: false,
            before: Stats::default(),
        }
    }

    /// Smallest singular value of the independent constraint rows at the start.
    pub(crate) fn regular(&mut self) -> f64 {
        let recorder = &mut self.recorder;
        smallest_singular_value(&mut recorder.evaluator, &self.reached, &recorder.dependent)
    }

    /// Integrates to the end; the error is `None` when the motion left its branch.
    pub(crate) fn leg(
        &mut self,
        equations: &MotionEquations,
        parameters: &[f64],
        options: &SolveOptions,
    ) -> Result<End, Option<SolveError>> {
        let motion = equations.at(parameters, &self.recorder.dependent);
        let State { t, q, v, a } = &self.reached;
        let (y, ydot) = equations.state(q, v, a, &self.lambda);
        let from = bksim_dae::Start { t: *t, y, ydot };
        let on_step = &mut |step: &Step<'_>| self.on_step(step);
        let settings = settings(options, equations);
        let outcome = solve(motion, from, options.t_end, settings, on_step);
        if self.left_branch {
            return Err(None);
        }
        let stats = match &outcome {
            Ok(outcome) => Some(outcome.stats),
            Err(error) => error.stats().copied(),
        };
        let summary = &mut self.recorder.summary;
        summary.stats = stats.map_or(summary.stats, |stats| sum(&self.before, &stats));
        outcome.map(|outcome| outcome.end).map_err(Some)
    }

    /// Hands out the end of the last step of a run that ends early.
    pub(crate) fn record_last(&mut self) {
        let Some(State { t, q, v, .. }) = self.history.back() else { return };
        let nq = q.len();
        let stretch = Stretch {
            t0: *t,
            t1: *t,
            at: &|_, y| {
                y[..nq].copy_from_slice(q);
                y[nq..2 * nq].copy_from_slice(v);
            },
            h: self.recorder.sample.step_size,
            stats: self.recorder.summary.stats,
        };
        self.recorder.take_last(&stretch, self.observer);
    }

    fn on_step(&mut self, step: &Step<'_>) -> Control {
        if self.is_off_branch(step) {
            self.left_branch = true;
            self.recorder.summary.stats = sum(&self.before, step.stats());
            return Control::Stop;
        }
        let stretch = Stretch {
            t0: step.t0(),
            t1: step.t1(),
            at: &|t, y| step.at(t, y),
            h: step.h(),
            stats: sum(&self.before, step.stats()),
        };
        let nq = self.reached.q.len();
        let mut state = match self.history.len() {
            HISTORY => self.history.pop_front().unwrap_or_default(),
            _ => State::default(),
        };
        state.t = step.t1();
        state.q.clear();
        state.q.extend_from_slice(&step.y1()[..nq]);
        state.v.clear();
        state.v.extend_from_slice(&step.y1()[nq..2 * nq]);
        self.history.push_back(state);
        self.is_stopped = self.recorder.pass(&stretch, self.observer) == Control::Stop;
        if self.is_stopped || (self.stop)() { Control::Stop } else { Control::Continue }
    }

    /// Whether rows that used to follow from the others are broken at the end of a step: it has
    /// jumped over a singular pose onto a branch that only the other rows allow.
    fn is_off_branch(&mut self, step: &Step<'_>) -> bool {
        if self.recorder.dependent.is_empty() {
            return false;
        }
        let nq = self.reached.q.len();
        let (q, v) = step.y1()[..2 * nq].split_at(nq);
        let size = q.iter().fold(1.0, |size: f64, value| size.max(value.abs()));
        let [gap, _] = residuals(&mut self.recorder.evaluator, step.t1(), q, v);
        gap.is_nan() || gap > BRANCH_TOLERANCE * size
    }

    /// Crosses the singular pose that stopped a leg; false when there is none to cross.
    pub(crate) fn pass_singular_pose(&mut self, options: &SolveOptions, regular: f64) -> bool {
        let Some(stopped_at) = self.history.back().map(|state| state.t) else {
            return false;
        };
        if options.step.is_some() || !self.is_near_singular(regular) {
            return false;
        }
        let Some(from) = self.last_regular_state(regular) else {
            return false;
        };
        let recorder = &mut self.recorder;
        let dependent = recorder.dependent.clone();
        let Some(mut passed) =
            cross(&mut recorder.evaluator, from, options.t_end, &dependent, regular)
        else {
            return false;
        };
        let Some(found) = land(&mut recorder.evaluator, &mut passed, &dependent) else {
            return false;
        };

        // Up to where the leg stopped, everything has been recorded.
        let stats = recorder.summary.stats;
        let forward = (options.t_end - stopped_at).signum();
        for pair in passed.windows(2) {
            let [from, to] = pair else { continue };
            if (to.t - stopped_at) * forward <= 0.0 {
                continue;
            }
            let is_recorded = (from.t - stopped_at) * forward < 0.0;
            let stretch = Stretch {
                t0: if is_recorded { stopped_at } else { from.t },
                t1: to.t,
                at: &|t, y| from.between_into(to, t, y),
                h: to.t - from.t,
                stats,
            };
            if recorder.pass(&stretch, self.observer) == Control::Stop {
                self.is_stopped = true;
                return true;
            }
        }
        let t_singular = found.t_singular;
        recorder.summary.singular_poses.push(t_singular);
        recorder.dependent = found.dependent;
        self.left_branch = false;
        self.before = stats;
        self.lambda = found.lambda;
        self.history.clear();
        self.reached = passed.pop().unwrap_or_default();
        true
    }

    fn is_near_singular(&mut self, regular: f64) -> bool {
        const NEAR: f64 = 0.2;
        let Some(state) = self.history.back() else { return false };
        let recorder = &mut self.recorder;
        let now = smallest_singular_value(&mut recorder.evaluator, state, &recorder.dependent);
        self.left_branch || now < NEAR * regular
    }

    /// The last state before the constraints became weak, on the constraints. Steps shrink towards
    /// a singular pose, and the states nearest to it have lost digits.
    fn last_regular_state(&mut self, regular: f64) -> Option<State> {
        let recorder = &mut self.recorder;
        let evaluator = &mut recorder.evaluator;
        let is_regular = |state: &&State| {
            smallest_singular_value(evaluator, state, &recorder.dependent) >= REGULAR * regular
        };
        let found = self.history.iter().rev().find(is_regular).or(self.history.front())?;
        let State { t, mut q, mut v, .. } = found.clone();
        let evaluator = &mut recorder.evaluator;
        project(evaluator, t, &mut q, &mut v, &recorder.dependent);
        Some(with_accelerations(evaluator, t, q, v, &recorder.dependent))
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
