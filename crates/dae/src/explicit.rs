//! Equations that are not stiff: `y′ = f(t, y)` by the Runge–Kutta method of order 8 of Dormand and
//! Prince.
//!
//! ```text
//! k_i = f(t0 + c_i h, y0 + h Σ_{j<i} a_ij k_j)          i = 0 … 11
//! y1  = y0 + h Σ b_i k_i,  k_12 = f(t1, y1)             first stage of the next step
//! err = |h| ‖e5‖² / √(‖e5‖² + ‖e3‖²/100),  e5 = Σ (b_i − b̂_i) k_i, e3 likewise
//! ```
//!
//! HNW1 §II.10 (E. Hairer, S. P. Nørsett, G. Wanner, *Solving Ordinary Differential Equations I*,
//! 2nd ed. 1993) for the error estimate of order 7 out of those of order 5 and 3; §II.4 for the
//! control. A step costs twelve evaluations, its dense output three more when it is asked for.

mod coefficients;
mod control;
mod resume;
mod stages;
mod stiffness;
mod straight_line;
mod sums;
#[cfg(test)]
mod tests;

use self::control::PiController;
use self::stages::StageWork;
pub use self::stiffness::STABLE_RANGE;
use self::stiffness::StiffnessTest;
pub use self::straight_line::{N_STEP_VECTORS, Recorder, STEP_END, record_step};
use crate::accessors::accessors;
use crate::dense::{ContinuousExtension, Interpolant, Step};
use crate::error::{Cause, SolveError, Standstill};
use crate::limits::{
    check_finite, check_length, first_not_finite, next_adaptive, next_fixed, step_floor,
};
use crate::noise::Noise;
use crate::run::{Control, End, Outcome, Start};
use crate::settings::{Settings, StepControl};
use crate::stats::Stats;
use crate::system::{Attempt, NotFinite, Ode, StepSpan};

/// Integrates `y′ = f(t, y)` from `start` to `t_end`, which may lie before `start.t`, and shows
/// every accepted step to `observer`. `start.ydot` is not read.
///
/// # Errors
/// [`SolveError`]: invalid input, or a run that cannot go on; [`SolveError::Stiff`] when a method
/// for stiff equations would need less work.
pub fn solve_ode<S: Ode>(
    system: S,
    start: Start,
    t_end: f64,
    settings: Settings,
    observer: &mut dyn FnMut(&Step<'_>) -> Control,
) -> Result<Outcome, SolveError> {
    let mut solver = ExplicitSolver::new(system, start, t_end, settings)?;
    let mut end = End::Reached;
    while let Some(step) = solver.step()? {
        if observer(&step) == Control::Stop {
            end = End::Stopped;
            break;
        }
        if solver.is_stiff() {
            return Err(SolveError::Stiff { at: solver.standstill(solver.h, Cause::ErrorTest) });
        }
    }
    let ExplicitSolver { t, y, ydot, stats, .. } = solver;
    Ok(Outcome { end, t, y, ydot, stats })
}

/// An explicit run in progress; [`solve_ode`] drives it to the end.
///
/// Of the [`Settings`] it reads the tolerances, the step control and the limits.
/// [`ExplicitSolver::step`] prepares the dense output of every step; where most steps need none,
/// [`ExplicitSolver::advance`] and, as needed, [`ExplicitSolver::last_step`] save a fifth of the
/// work.
pub struct ExplicitSolver<S: Ode> {
    system: S,
    settings: Settings,
    t: f64,
    y: Vec<f64>,
    /// `f(t, y)`.
    ydot: Vec<f64>,
    t_end: f64,
    /// Size of the next step, signed.
    h: f64,
    /// Start of the fixed-step grid and steps taken on it.
    grid: (f64, usize),
    stages: StageWork,
    last: ContinuousExtension,
    last_state: LastStep,
    controller: PiController,
    stiffness: StiffnessTest,
    stats: Stats,
}

/// An attempt at a step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Advance {
    /// The run stands at its end.
    Accepted,
    /// The run stands where it did, and tries a smaller one next.
    Rejected,
    /// No step: the end time is reached.
    Ended,
}

/// Knowledge of the last step.
#[derive(Clone, Copy, PartialEq, Debug)]
enum LastStep {
    /// No step yet.
    Missing,
    /// Step with its stages known, its extension not.
    Taken { error: Option<f64> },
    /// Step with its extension known.
    Extended { error: Option<f64> },
}

impl<S: Ode> ExplicitSolver<S> {
    /// Checks the input, evaluates `f` at the start and chooses the first step.
    ///
    /// # Errors
    /// [`SolveError`] names the vector, value or option that does not fit, or the row of `f` that
    /// has no value at the start.
    pub fn new(
        system: S,
        start: Start,
        t_end: f64,
        settings: Settings,
    ) -> Result<Self, SolveError> {
        let n = system.layout().n();
        settings.check(n)?;
        check_length("y", n, start.y.len())?;
        check_finite("t", &[start.t])?;
        check_finite("t_end", &[t_end])?;
        check_finite("y", &start.y)?;
        let stages = StageWork::new(n, &settings);
        let mut solver = Self {
            last: ContinuousExtension::new(n),
            stages,
            last_state: LastStep::Missing,
            controller: PiController::new(),
            stiffness: StiffnessTest::default(),
            system,
            settings,
            t: start.t,
            grid: (start.t, 0),
            ydot: vec![0.0; n],
            y: start.y,
            t_end,
            h: 0.0,
            stats: Stats::default(),
        };
        solver.begin()?;
        Ok(solver)
    }

    /// Evaluates `f` at the start of the run or after a jump, and chooses the step from there.
    fn begin(&mut self) -> Result<(), SolveError> {
        let Self { system, stages, stats, .. } = self;
        let found = stages.evaluate(system, self.t, &self.y, &mut self.ydot, stats);
        if let Err(NotFinite { row }) = found {
            let at = self.standstill(0.0, Cause::NotFinite { row });
            return Err(SolveError::NotFinite { row, at });
        }
        self.h = self.first_step_size();
        Ok(())
    }

    accessors!(S);

    /// The system.
    pub fn system(&self) -> &S {
        &self.system
    }

    /// True if stability, not accuracy, has limited the last fifteen steps (HW2 §IV.2).
    pub fn is_stiff(&self) -> bool {
        self.stiffness.is_stiff()
    }

    /// `|h| ρ` of the last step, from two states at its end; stable up to
    /// [`STABLE_RANGE`].
    pub fn stability(&self) -> f64 {
        self.stiffness.last.h_rho
    }

    /// How much of the difference of two states at the end of the last step only decays along the run: the cosine between
    /// it and minus that of their derivatives.
    pub fn decay(&self) -> f64 {
        self.stiffness.last.decay
    }

    /// Repeated steps whose error has not fallen with their size, since the solver began.
    pub fn noise(&self) -> Noise {
        self.controller.noise
    }

    /// The error estimate of an unknown in the last step, whether or not it takes part in the error test.
    pub fn error_of(&self, unknown_idx: usize) -> f64 {
        self.stages.error_of(unknown_idx, self.last.h)
    }

    /// Replaces the value of an unknown that no derivative depends on.
    pub fn replace(&mut self, unknown_idx: usize, value: f64) {
        self.y[unknown_idx] = value;
    }

    /// Takes one accepted step with dense output; `None` once `t_end` is reached.
    ///
    /// # Errors
    /// [`SolveError`] when the run cannot go on.
    pub fn step(&mut self) -> Result<Option<Step<'_>>, SolveError> {
        if self.advance()? { self.last_step().map(Some) } else { Ok(None) }
    }

    /// Takes one accepted step; false once `t_end` is reached.
    ///
    /// # Errors
    /// [`SolveError`] when the run cannot go on.
    pub fn advance(&mut self) -> Result<bool, SolveError> {
        loop {
            match self.advance_once()? {
                Advance::Accepted => return Ok(true),
                Advance::Rejected => (),
                Advance::Ended => return Ok(false),
            }
        }
    }

    /// Tries one step.
    ///
    /// # Errors
    /// [`SolveError`] when the run cannot go on.
    pub fn advance_once(&mut self) -> Result<Advance, SolveError> {
        if self.t == self.t_end {
            return Ok(Advance::Ended);
        }
        self.check_limits()?;
        self.stats.n_step += 1;
        let is_accepted = self.attempt(self.next_span())?;
        Ok(if is_accepted { Advance::Accepted } else { Advance::Rejected })
    }

    /// The step that is tried next.
    fn next_span(&self) -> StepSpan {
        let Self { t, h, t_end, grid, .. } = *self;
        let (h, t1) = match self.settings.step {
            StepControl::Adaptive => next_adaptive(t, h, t_end),
            StepControl::Fixed { .. } => next_fixed(t, h, t_end, grid),
        };
        StepSpan { t, h, t1 }
    }

    /// The step that [`ExplicitSolver::advance`] tries next, with the state and its derivative where it begins, so that
    /// [`Ode::whole_step`] may be prepared; `None` at the end.
    pub fn pending(&self) -> Option<(StepSpan, &[f64], &[f64])> {
        (self.t != self.t_end).then(|| (self.next_span(), &self.y[..], &self.ydot[..]))
    }

    /// The last accepted step, with dense output.
    ///
    /// # Errors
    /// [`SolveError::NotFinite`] when `f` has no value inside the step;
    /// [`SolveError::InvalidStart`] before the first step.
    pub fn last_step(&mut self) -> Result<Step<'_>, SolveError> {
        let error = match self.last_state {
            LastStep::Missing => {
                return Err(SolveError::InvalidStart { what: "step", value: f64::NAN });
            }
            LastStep::Extended { error } => error,
            LastStep::Taken { error } => {
                let Self { system, stages, stats, last, y, ydot, .. } = self;
                if let Err(NotFinite { row }) = stages.extend(system, last, y, ydot, stats) {
                    let at = self.standstill(self.last.h, Cause::NotFinite { row });
                    return Err(SolveError::NotFinite { row, at });
                }
                self.last_state = LastStep::Extended { error };
                error
            }
        };
        Ok(Step {
            polynomial: Interpolant::Explicit(&self.last),
            t1: self.t,
            y1: &self.y,
            ydot1: &self.ydot,
            error,
            stats: &self.stats,
        })
    }

    /// Goes on from another state, after a jump.
    ///
    /// # Errors
    /// As for [`ExplicitSolver::new`].
    pub fn restart(&mut self, t: f64, y: &[f64]) -> Result<(), SolveError> {
        check_length("y", self.y.len(), y.len())?;
        check_finite("t", &[t])?;
        check_finite("y", y)?;
        self.t = t;
        self.y.copy_from_slice(y);
        self.grid = (t, 0);
        self.last_state = LastStep::Missing;
        let noise = self.controller.noise;
        self.controller = PiController::new();
        self.controller.noise = noise;
        self.stiffness = StiffnessTest::default();
        self.begin()
    }

    /// Tries one step; true when it was accepted.
    fn attempt(&mut self, span @ StepSpan { h, t1, .. }: StepSpan) -> Result<bool, SolveError> {
        let Self { system, stages, stats, .. } = self;
        let is_adaptive = self.settings.step == StepControl::Adaptive;
        system.note(Attempt::Begun);
        let tried = stages.step(system, span, (&self.y, &self.ydot), stats);
        let error = tried.map(|()| if is_adaptive { stages.error(h, &self.y) } else { 0.0 });
        match error {
            Ok(error) if error.is_finite() && error < 1.0 => {
                match stages.finish(system, t1, stats) {
                    Ok(()) => {
                        let power = self.controller.compare(h, error);
                        self.system.note(Attempt::Accepted { power });
                        self.accept(h, t1, is_adaptive.then_some(error));
                        return Ok(true);
                    }
                    Err(NotFinite { row }) => self.fail(h, row)?,
                }
            }
            Ok(error) => {
                self.stats.n_reject += 1;
                let power = self.controller.compare(h, error);
                self.system.note(Attempt::Rejected { power });
                let smaller = self.controller.after_reject(h, error);
                self.cut(h, smaller, Cause::ErrorTest)?;
            }
            Err(NotFinite { row }) => self.fail(h, row)?,
        }
        Ok(false)
    }

    /// Moves to the end of the step and chooses the size of the next.
    fn accept(&mut self, h: f64, t1: f64, error: Option<f64>) {
        self.stats.n_accept += 1;
        self.grid.1 += 1;
        // The dense output of the step follows from where it began.
        (self.last.t0, self.last.h) = (self.t, h);
        self.last.y0.copy_from_slice(&self.y);
        self.last_state = LastStep::Taken { error };
        self.stiffness.observe(self.stages.stability(h));
        self.t = t1;
        self.y.copy_from_slice(self.stages.y1.values());
        std::mem::swap(&mut self.ydot, &mut self.stages.f1);
        if let Some(error) = error {
            let next = self.controller.after_accept(h, error);
            self.h = next.signum() * next.abs().min(self.settings.h_max);
        }
    }

    /// `f` has no value somewhere in the step.
    fn fail(&mut self, h: f64, row: usize) -> Result<(), SolveError> {
        self.stats.n_newton_failed += 1;
        self.controller.after_failure();
        self.cut(h, 0.5 * h, Cause::NotFinite { row })
    }

    /// Goes on with the smaller step, unless it is too small or steps are constant.
    fn cut(&mut self, h: f64, smaller: f64, cause: Cause) -> Result<(), SolveError> {
        let is_fixed = self.settings.step != StepControl::Adaptive;
        let floor = step_floor(self.t, self.t_end - self.grid.0, self.settings.h_min);
        if !is_fixed && smaller.abs() >= floor {
            self.h = smaller;
            return Ok(());
        }
        let at = self.standstill(h, cause);
        Err(match cause {
            Cause::NotFinite { row } => SolveError::NotFinite { row, at },
            _ if is_fixed => SolveError::FixedStepFailed { cause, at },
            _ => SolveError::StepTooSmall { cause, at },
        })
    }

    fn check_limits(&self) -> Result<(), SolveError> {
        let limit = self.settings.max_steps;
        if self.stats.n_step < limit {
            return Ok(());
        }
        let at = self.standstill(self.h, Cause::ErrorTest);
        Err(SolveError::TooManySteps { limit, at })
    }

    /// The state of the run after a failed attempt.
    fn standstill(&self, h: f64, cause: Cause) -> Box<Standstill> {
        let y = match cause {
            Cause::NotFinite { .. } => self.stages.argument().to_vec(),
            _ => self.y.clone(),
        };
        self.standstill_at(y, h, cause)
    }

    fn standstill_at(&self, y: Vec<f64>, h: f64, cause: Cause) -> Box<Standstill> {
        let worst = match cause {
            Cause::ErrorTest => self.stages.worst(self.system.layout()),
            _ => Vec::new(),
        };
        Box::new(Standstill { t: self.t, h, worst, y, stats: self.stats })
    }

    /// Where the run stands, with the unknowns whose errors keep its steps small.
    pub fn account(&self) -> Standstill {
        *self.standstill_at(self.y.clone(), self.h, Cause::ErrorTest)
    }

    /// Signed size of the first step, by a trial step of Euler's method (HNW1 §II.4).
    fn first_step_size(&mut self) -> f64 {
        let span = self.t_end - self.t;
        let floor = step_floor(self.t, span, self.settings.h_min);
        let size = match (self.settings.step, self.settings.h_initial) {
            (StepControl::Fixed { h, .. }, _) => h,
            (StepControl::Adaptive, Some(h)) => h.min(self.settings.h_max).max(floor),
            (StepControl::Adaptive, None) => {
                let Self { system, stages, stats, .. } = self;
                let at = (self.t, span);
                let guess = stages.first_step(system, at, (&self.y, &self.ydot), stats);
                guess.min(0.1 * span.abs()).min(self.settings.h_max).max(floor)
            }
        };
        size.copysign(span)
    }
}

/// `f(t, y)`, with every entry finite.
fn derivative<S: Ode>(
    system: &mut S,
    t: f64,
    y: &[f64],
    out: &mut [f64],
    stats: &mut Stats,
) -> Result<(), NotFinite> {
    stats.n_residual += 1;
    system.derivative(t, y, out)?;
    match first_not_finite(out) {
        Some(row) => Err(NotFinite { row }),
        None => Ok(()),
    }
}
