//! The legs of a run between singular poses: integrate, and where a pose stops the integrator or
//! throws it off its branch, cross it from the last good state and go on behind.

use bksim_dae::{ChatterSettings, Control, End, SolveError, Solver, Stats, Step, solve_events};

use crate::crossing::{State, cross, land, smallest_singular_value, with_accelerations};
use crate::formulate::MotionEquations;
use crate::linear::project;
use crate::model::SolveOptions;
use crate::recorder::{Recorder, Stretch};
use crate::run::{Sample, residuals, settings};
use crate::side::{Pose, Side};
use crate::start::Start;
use crate::switch::{Decider, Unsettled};

/// A run in its legs between singular poses.
pub(crate) struct Run<'a, 'b> {
    pub(crate) recorder: Recorder<'a>,
    observer: &'b mut dyn FnMut(&Sample) -> Control,
    stop: &'b dyn Fn() -> bool,
    /// The observer wants no more.
    pub(crate) is_stopped: bool,
    /// Where the next leg starts.
    reached: State,
    /// End of the last accepted step of this leg.
    last: Option<State>,
    /// The last state in which the constraints were independent by a good margin.
    last_regular: State,
    lambda: Vec<f64>,
    /// Smallest singular value of the independent constraint rows at the start.
    regular: f64,
    /// The side of the last accepted state.
    side: Option<Side>,
    /// Singular poses are crossed; not with fixed steps.
    is_watching: bool,
    /// A step jumped over a singular pose.
    left_branch: bool,
    /// Counters of the legs before this one.
    before: Stats,
    /// What ended the last leg: time, state, functions that crossed zero.
    event: Option<(f64, Vec<f64>, Vec<Decider>)>,
}

/// Dependent rows count as broken beyond this part of the mechanism's size.
const BRANCH_TOLERANCE: f64 = 1e-6;

impl<'a, 'b> Run<'a, 'b> {
    /// A run that has recorded its start.
    pub(crate) fn new(
        mut recorder: Recorder<'a>,
        start: &Start,
        observer: &'b mut dyn FnMut(&Sample) -> Control,
        stop: &'b dyn Fn() -> bool,
    ) -> Self {
        let reached =
            State { t: start.t, q: start.q.clone(), v: start.v.clone(), a: start.a.clone() };
        let regular =
            smallest_singular_value(&mut recorder.evaluator, &reached, &recorder.dependent);
        Self {
            recorder,
            observer,
            stop,
            is_stopped: false,
            last_regular: reached.clone(),
            reached,
            last: None,
            lambda: start.lambda.clone(),
            regular,
            side: None,
            is_watching: false,
            left_branch: false,
            before: Stats::default(),
            event: None,
        }
    }

    /// Integrates to the end, or to where something switches; the error is `None` when the motion
    /// left its branch.
    pub(crate) fn leg(
        &mut self,
        equations: &MotionEquations,
        options: &SolveOptions,
    ) -> Result<End, Option<SolveError>> {
        self.is_watching = options.step.is_none();
        let recorder = &mut self.recorder;
        let regular = self.side.as_ref().map_or(0.0, Side::regular);
        let Recorder { evaluator, dependent, .. } = recorder;
        self.side = Some(Side::of(evaluator, &self.reached, dependent, regular));
        self.last_regular = self.reached.clone();
        self.last = None;
        let recorder = &self.recorder;
        let motion = equations.at(&recorder.switching.parameters, &recorder.dependent);
        let State { t, q, v, a } = &self.reached;
        let mut lookout = recorder.switching.lookout(&recorder.dependent, (*t, q, v));
        let (y, ydot) = equations.state(q, v, a, &self.lambda);
        let from = bksim_dae::Start { t: *t, y, ydot };
        let settings = settings(options, equations);
        let on_step = &mut |step: &Step<'_>| self.on_step(step);
        let outcome = Solver::new(motion, from, options.t_end, settings).and_then(|mut solver| {
            solve_events(&mut solver, &mut lookout, ChatterSettings::default(), on_step)
        });
        if self.left_branch {
            return Err(None);
        }
        let stats = match &outcome {
            Ok(outcome) => Some(outcome.outcome.stats),
            Err(error) => error.stats().copied(),
        };
        let summary = &mut self.recorder.summary;
        summary.stats = stats.map_or(summary.stats, |stats| sum(&self.before, &stats));
        let ended = outcome.map_err(Some)?;
        if ended.terminal.is_some() {
            self.event = Some((ended.outcome.t, ended.outcome.y, lookout.fired));
        }
        Ok(ended.outcome.end)
    }

    /// Passes the event that ended a leg; false when none did.
    pub(crate) fn pass_event(&mut self) -> Result<bool, Unsettled> {
        let Some((t, y, fired)) = self.event.take() else { return Ok(false) };
        let nq = self.reached.q.len();
        let (q, v) = (y[..nq].to_vec(), y[nq..2 * nq].to_vec());
        let recorder = &mut self.recorder;
        let changes = &mut recorder.summary.changes;
        let settled = recorder.switching.pass(&fired, (t, q, v), changes)?;
        recorder.summary.energy.work += settled.blow;
        recorder.summary.energy.blows += settled.blow;
        recorder.evaluator = recorder.compiled.evaluator(&recorder.switching.parameters);
        recorder.dependent = settled.dependent;
        self.before = recorder.summary.stats;
        self.lambda = settled.lambda;
        self.reached = State { t, q: settled.q, v: settled.v, a: settled.a };
        self.side = None;
        let Recorder { evaluator, dependent, .. } = recorder;
        self.regular = smallest_singular_value(evaluator, &self.reached, dependent);
        Ok(true)
    }

    /// Hands out the end of the last step of a run that ends early.
    pub(crate) fn record_last(&mut self) {
        let Some(State { t, q, v, .. }) = &self.last else { return };
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
        let pose = self.pose_after(step);
        if pose == Pose::Passed {
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
        let state = self.last.get_or_insert_default();
        state.t = step.t1();
        state.q.clear();
        state.q.extend_from_slice(&step.y1()[..nq]);
        state.v.clear();
        state.v.extend_from_slice(&step.y1()[nq..2 * nq]);
        if pose == Pose::Regular {
            self.last_regular.clone_from(state);
        }
        self.is_stopped = self.recorder.pass(&stretch, self.observer) == Control::Stop;
        if self.is_stopped || (self.stop)() { Control::Stop } else { Control::Continue }
    }

    /// Whether a step has jumped over a singular pose: its equations had no unique solution on the
    /// way, so what it came to need not be the same motion.
    fn pose_after(&mut self, step: &Step<'_>) -> Pose {
        if self.is_off_branch(step) {
            return Pose::Passed;
        }
        let Recorder { evaluator, dependent, .. } = &mut self.recorder;
        match &mut self.side {
            Some(side) if self.is_watching => side.follow(evaluator, step, dependent, self.regular),
            _ => Pose::Weak,
        }
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
    pub(crate) fn pass_singular_pose(&mut self, options: &SolveOptions) -> bool {
        let regular = self.regular;
        let stopped_at = self.last.as_ref().unwrap_or(&self.reached).t;
        if options.step.is_some() || !self.is_near_singular(regular) {
            return false;
        }
        let from = self.last_regular_state();
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
        self.reached = passed.pop().unwrap_or_default();
        true
    }

    fn is_near_singular(&mut self, regular: f64) -> bool {
        const NEAR: f64 = 0.2;
        let state = self.last.as_ref().unwrap_or(&self.reached);
        let recorder = &mut self.recorder;
        let now = smallest_singular_value(&mut recorder.evaluator, state, &recorder.dependent);
        self.left_branch || now < NEAR * regular
    }

    /// The last regular state, on the constraints. Steps shrink towards a singular pose, and the
    /// states nearest to it have lost digits.
    fn last_regular_state(&mut self) -> State {
        let Recorder { evaluator, dependent, .. } = &mut self.recorder;
        let State { t, mut q, mut v, .. } = self.last_regular.clone();
        project(evaluator, t, &mut q, &mut v, dependent);
        with_accelerations(evaluator, t, q, v, dependent)
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
