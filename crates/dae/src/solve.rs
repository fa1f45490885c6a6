//! The run: step after step from `t0` to `t_end`, each accepted, repeated or given up.

mod resume;

use crate::accessors::accessors;
use crate::controller::Controller;
use crate::dense::{CollocationPolynomial, Interpolant, Step};
use crate::error::{Cause, SolveError, Standstill};
use crate::limits::{check_finite, check_length, next_adaptive, next_fixed, step_floor};
use crate::newton::Point;
use crate::noise::Noise;
use crate::order::{OrderChoice, lower};
use crate::run::{Control, End, Outcome, Start};
use crate::scale::{Scale, Unit};
use crate::settings::{Order, Settings, Stages, StepControl};
use crate::stats::Stats;
use crate::step::{Attempt, Stepper, max_iterations};
use crate::system::System;

/// Integrates `system` from `start` to `t_end`, which may lie before `start.t`, and shows every
/// accepted step to `observer`.
///
/// # Errors
/// [`SolveError`]: invalid input, or a run that cannot go on, with its last state and counters.
pub fn solve<S: System>(
    system: S,
    start: Start,
    t_end: f64,
    settings: Settings,
    observer: &mut dyn FnMut(&Step<'_>) -> Control,
) -> Result<Outcome, SolveError> {
    let mut solver = Solver::new(system, start, t_end, settings)?;
    let mut end = End::Reached;
    while let Some(step) = solver.step()? {
        if observer(&step) == Control::Stop {
            end = End::Stopped;
            break;
        }
    }
    Ok(Outcome { end, t: solver.t, y: solver.y, ydot: solver.ydot, stats: solver.stats })
}

/// A run in progress; [`solve`] drives it to the end, [`Solver::step`] by single steps.
pub struct Solver<S: System> {
    pub(crate) system: S,
    pub(crate) settings: Settings,
    t: f64,
    pub(crate) y: Vec<f64>,
    ydot: Vec<f64>,
    t_end: f64,
    /// Size of the next step, signed.
    h: f64,
    /// Start of the fixed-step grid and steps taken on it.
    grid: (f64, usize),
    /// Polynomial of the last accepted step.
    pub(crate) last: CollocationPolynomial,
    has_last: bool,
    pub(crate) stepper: Stepper,
    controller: Controller,
    order: OrderChoice,
    /// Failures of Newton's iteration since the last accepted step.
    n_failed: usize,
    pub(crate) stats: Stats,
}

impl<S: System> Solver<S> {
    /// Checks the input and prepares all buffers.
    ///
    /// # Errors
    /// [`SolveError`] names the vector, value or option that does not fit.
    pub fn new(
        system: S,
        start: Start,
        t_end: f64,
        settings: Settings,
    ) -> Result<Self, SolveError> {
        let n = system.layout().n();
        settings.check(n)?;
        check_length("pattern", n, system.pattern().n())?;
        check_length("y", n, start.y.len())?;
        check_length("ydot", n, start.ydot.len())?;
        check_finite("t", &[start.t])?;
        check_finite("t_end", &[t_end])?;
        check_finite("y", &start.y)?;
        check_finite("ydot", &start.ydot)?;

        let settings = settings.for_one_step(system.layout());
        let stepper = Stepper::new(&system, &settings)?;
        let stages = settings.order.initial().count();
        let mut solver = Self {
            controller: Controller::new(stages, max_iterations(&settings, stages)),
            last: CollocationPolynomial::new(n, stepper.largest()),
            has_last: false,
            order: OrderChoice::default(),
            n_failed: 0,
            stepper,
            system,
            settings,
            t: start.t,
            grid: (start.t, 0),
            y: start.y,
            ydot: start.ydot,
            t_end,
            h: 0.0,
            stats: Stats::default(),
        };
        solver.h = solver.first_step_size();
        Ok(solver)
    }

    accessors!(S);

    /// Replaces the state at [`Solver::t`] by a nearby one, such as its projection to constraints.
    ///
    /// The next step is still predicted from the last one, so the change must be of the size of
    /// the error tolerance.
    ///
    /// # Errors
    /// [`SolveError::WrongLength`] or [`SolveError::InvalidStart`].
    pub fn correct_state(&mut self, y: &[f64], ydot: &[f64]) -> Result<(), SolveError> {
        check_length("y", self.y.len(), y.len())?;
        check_length("ydot", self.ydot.len(), ydot.len())?;
        check_finite("y", y)?;
        check_finite("ydot", ydot)?;
        self.y.copy_from_slice(y);
        self.ydot.copy_from_slice(ydot);
        Ok(())
    }

    /// Goes on from another state, as from a start: after a jump, for instance.
    ///
    /// # Errors
    /// [`SolveError::WrongLength`] or [`SolveError::InvalidStart`].
    pub fn restart(&mut self, start: &Start) -> Result<(), SolveError> {
        check_finite("t", &[start.t])?;
        self.correct_state(&start.y, &start.ydot)?;
        self.t = start.t;
        self.grid = (start.t, 0);
        self.has_last = false;
        self.n_failed = 0;
        self.order = OrderChoice::default();
        let stages = self.settings.order.initial();
        self.stepper.expire_jacobian();
        self.stepper.set_order(stages, &self.settings);
        let limit = max_iterations(&self.settings, stages.count());
        let noise = self.controller.noise;
        self.controller = Controller::new(stages.count(), limit);
        self.controller.noise = noise;
        self.h = self.first_step_size();
        Ok(())
    }

    /// Takes one accepted step, however many attempts it needs; `None` once `t_end` is reached.
    ///
    /// # Errors
    /// [`SolveError`] when the run cannot go on.
    pub fn step(&mut self) -> Result<Option<Step<'_>>, SolveError> {
        if self.t == self.t_end {
            return Ok(None);
        }
        loop {
            self.check_limits()?;
            self.stats.n_step += 1;
            let (h, t1) = self.next_interval();
            match self.attempt(h) {
                Attempt::Solved { error: None } => return Ok(Some(self.accept(h, t1, None))),
                Attempt::Solved { error: Some(error) } if error < 1.0 => {
                    return Ok(Some(self.accept(h, t1, Some(error))));
                }
                Attempt::Solved { error: Some(error) } => self.reject(h, error)?,
                Attempt::Failed { cause, shrink, is_stale } => {
                    self.fail(h, cause, shrink, is_stale)?;
                }
            }
        }
    }

    /// Repeated steps whose error has not fallen with their size, since the solver began.
    pub fn noise(&self) -> Noise {
        self.controller.noise
    }

    /// The last accepted step again, without its error; before the first one it has no extent.
    pub fn last_step(&self) -> Step<'_> {
        Step {
            polynomial: Interpolant::Collocation(&self.last),
            t1: self.t,
            y1: &self.y,
            ydot1: &self.ydot,
            error: None,
            stats: &self.stats,
        }
    }

    fn attempt(&mut self, h: f64) -> Attempt {
        let attempt = self.stepper.attempt(
            &mut self.system,
            Point { t: self.t, h, y: &self.y, ydot: &self.ydot },
            self.has_last.then_some(&self.last),
            self.controller.filter(),
            &mut self.stats,
        );
        match attempt {
            Attempt::Solved { error } => {
                Attempt::Solved { error: error.map(|error| self.controller.part(error)) }
            }
            Attempt::Failed { .. } => attempt,
        }
    }

    /// Size and end of the next step; the last one ends at `t_end` to the bit.
    fn next_interval(&self) -> (f64, f64) {
        match self.settings.step {
            StepControl::Adaptive => next_adaptive(self.t, self.h, self.t_end),
            StepControl::Fixed { .. } => next_fixed(self.t, self.h, self.t_end, self.grid),
        }
    }

    /// Moves to the end of the step and chooses the size of the next.
    fn accept(&mut self, h: f64, t1: f64, error: Option<f64>) -> Step<'_> {
        self.stats.n_accept += 1;
        self.grid.1 += 1;
        self.n_failed = 0;

        let at = Point { t: self.t, h, y: &self.y, ydot: &self.ydot };
        let (y1, ydot1) = self.stepper.finish(at, &mut self.last);
        self.has_last = true;
        self.t = t1;
        self.y.copy_from_slice(y1);
        self.ydot.copy_from_slice(ydot1);
        self.plan_next(h, error);
        Step { error, ..self.last_step() }
    }

    /// Chooses order and size of the next step after an accepted one of size `h`.
    fn plan_next(&mut self, h: f64, error: Option<f64>) {
        let may_keep = self.stepper.age_jacobian();
        let Some(error) = error else { return };
        let (iterations, rate) = (self.stepper.iterations(), self.stepper.rate());
        let mut proposed = self.controller.after_accept(h, error, iterations, rate, may_keep);
        let smoothness = self.stepper.smoothness(h, error);
        self.order.observe(self.stepper.tableau().gamma, smoothness);
        if self.settings.order == Order::Auto {
            let gammas = self.stepper.gammas();
            let better = self.order.after_accept(self.stepper.stages(), &gammas, smoothness);
            if let Some((stages, h)) = better {
                self.set_order(stages);
                proposed = h;
            }
        }
        self.h = proposed.signum() * proposed.abs().min(self.settings.h_max);
    }

    fn set_order(&mut self, stages: Stages) {
        self.stepper.set_order(stages, &self.settings);
        let limit = max_iterations(&self.settings, stages.count());
        self.controller.set_order(stages.count(), limit);
        self.order.steps = 0;
    }

    /// The error test failed: cut the step.
    fn reject(&mut self, h: f64, error: f64) -> Result<(), SolveError> {
        self.stats.n_reject += 1;
        let smaller = self.controller.after_reject(h, error, self.stepper.iterations());
        self.cut(h, smaller, Cause::ErrorTest)
    }

    /// The stage equations were not solved: renew the Jacobian, or cut the step.
    fn fail(
        &mut self,
        h: f64,
        cause: Cause,
        shrink: f64,
        is_stale: bool,
    ) -> Result<(), SolveError> {
        self.stats.n_newton_failed += 1;
        if is_stale {
            return Ok(());
        }
        // Newton's iteration that fails again and again may do better with fewer stages.
        self.n_failed += 1;
        if self.settings.order == Order::Auto
            && self.n_failed >= 2
            && let Some(stages) = lower(self.stepper.stages())
        {
            self.set_order(stages);
        }
        if matches!(self.settings.step, StepControl::Fixed { .. }) {
            let at = self.standstill(h, cause);
            return Err(match cause {
                Cause::NotFinite { row } => SolveError::NotFinite { row, at },
                _ => SolveError::FixedStepFailed { cause, at },
            });
        }
        let smaller = self.controller.after_failure(h, shrink);
        self.cut(h, smaller, cause)
    }

    /// Goes on with the smaller step, unless it is too small.
    fn cut(&mut self, h: f64, smaller: f64, cause: Cause) -> Result<(), SolveError> {
        if smaller.abs() >= self.h_floor() {
            self.h = smaller;
            return Ok(());
        }
        let at = self.standstill(h, cause);
        Err(match cause {
            Cause::NotFinite { row } => SolveError::NotFinite { row, at },
            _ => SolveError::StepTooSmall { cause, at },
        })
    }

    fn check_limits(&self) -> Result<(), SolveError> {
        let limit = self.settings.max_steps;
        if self.stats.n_step < limit {
            return Ok(());
        }
        let at = Standstill {
            t: self.t,
            h: self.h,
            worst: Vec::new(),
            y: self.y.clone(),
            stats: self.stats,
        };
        Err(SolveError::TooManySteps { limit, at: Box::new(at) })
    }

    fn h_floor(&self) -> f64 {
        step_floor(self.t, self.t_end - self.grid.0, self.settings.h_min)
    }

    /// The last attempt, for the report of a failure.
    fn standstill(&self, h: f64, cause: Cause) -> Box<Standstill> {
        let worst = self.stepper.worst(self.system.layout(), cause);
        let y = self.stepper.last_tried().to_vec();
        Box::new(Standstill { t: self.t, h, worst, y, stats: self.stats })
    }

    /// Where the run stands, with the unknowns whose errors keep its steps small.
    pub fn account(&self) -> Standstill {
        let worst = self.stepper.worst(self.system.layout(), Cause::ErrorTest);
        Standstill { t: self.t, h: self.h, worst, y: self.y.clone(), stats: self.stats }
    }

    /// Signed size of the first step.
    ///
    /// The tangent crosses one tolerance in the time `1/‖y′‖`; with the solution varying over the
    /// `rtol⁻¹`-fold of it, an error of order `s + 1` allows `rtol^{1/(s+1)}` of that. A tenth is
    /// taken. A first step far too small, as is usual, would spoil unknowns of index 3, whose
    /// rounding errors grow like `h⁻²`.
    fn first_step_size(&self) -> f64 {
        let span = self.t_end - self.t;
        let size = match self.settings.step {
            StepControl::Fixed { h, .. } => h,
            StepControl::Adaptive => self
                .settings
                .h_initial
                .unwrap_or_else(|| self.guess_first_step().min(0.1 * span.abs()))
                .min(self.settings.h_max)
                .max(self.h_floor()),
        };
        size.copysign(span)
    }

    fn guess_first_step(&self) -> f64 {
        let mut scale = Scale::new(self.y.len());
        let index = self.system.layout().index();
        scale.update(&Unit::new(&self.settings), index, &self.y, 1.0);
        let tangent = scale.rms(&self.ydot);
        let rtol = self.settings.rtol;
        let exponent = 1.0 / (self.settings.order.initial().count() as f64 + 1.0);
        let guess = 0.1 * rtol.powf(exponent) / (rtol * tangent);
        if guess.is_finite() { guess } else { f64::INFINITY }
    }
}
