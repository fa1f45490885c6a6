//! [`ExplicitMotion`]: the motion as an ordinary differential equation: accelerations from the multiplier system, the
//! constraints kept by projection.
//!
//! ```text
//! y = (q, v, W)      q′ = v,  v′ = a(t, q, v) of the multiplier system,  W′ = P
//! ```
//!
//! W, the work of loads and drives, rides along with the accuracy of the method and without a part
//! in its error control. Projection after every step: E. Eich, *Convergence results for a
//! coordinate projection method applied to mechanical systems with algebraic constraints*, SIAM
//! J. Numer. Anal. 30 (1993).

use bksim_dae::{Attempt, Layout, NotFinite, Ode, Settings, StepControl, StepSpan, Tolerance};

use super::holding::Holding;
use super::singular::{CLOSE, NOTICEABLE};
use crate::compiled::CompiledSystem;
use crate::evaluator::Evaluator;
use crate::function::Buffers;
use crate::multiplier::MultiplierSystem;
use crate::multiplier::projection::{CLOSED, size_of};
use crate::whole_step::{ProjectedEnd, StepBuffers, StepResults, are_finite};
use bksim_model::SolveOptions;

/// A mechanism as y′ = f(t, y).
pub(crate) struct ExplicitMotion<'a> {
    evaluator: Evaluator<'a>,
    pub(crate) multipliers: MultiplierSystem,
    /// The least rank margin of the stages since it was last looked at.
    pub(crate) least_margin: f64,
    pub(super) holding: Holding,
    layout: Layout,
    lambda: Vec<f64>,
    /// Whole steps.
    step: Option<StepBuffers>,
    /// Further projections of their ends.
    closing: Option<Buffers>,
    pub(super) parameters: Vec<f64>,
    /// One that was taken together with those of other runs.
    offered: Offered,
    /// True while the factors of the last state are with the evaluator alone.
    has_left_factors: bool,
}

/// A step that others have taken.
#[derive(Default)]
struct Offered {
    /// Where it lies, until it is tried.
    span: Option<StepSpan>,
    results: Vec<f64>,
}

/// The integrator is asked for this part of the tolerance: what it keeps below is the error of a
/// step in the mean over the unknowns, what is asked of it is the error of the run in each. A step
/// of order eight grows only by 1.8 for it.
const SAFETY: f64 = 0.01;

/// Steps of Newton's method at most, each with a projection of the velocities.
const MAX_PASSES: usize = 3;

impl<'a> ExplicitMotion<'a> {
    /// The motion at one set of parameters, its accelerations from these multiplier systems.
    pub(crate) fn new(
        compiled: &'a CompiledSystem,
        parameters: &[f64],
        multipliers: MultiplierSystem,
    ) -> Self {
        Self {
            evaluator: compiled.evaluator(parameters),
            multipliers,
            least_margin: 1.0,
            holding: Holding::default(),
            layout: compiled.unknowns.clone(),
            lambda: vec![0.0; compiled.nc()],
            step: None,
            closing: None,
            offered: Offered::default(),
            parameters: parameters.to_vec(),
            has_left_factors: false,
        }
    }

    /// Buffers of a function of these parameters.
    fn buffers(&self) -> Buffers {
        Buffers::new(self.parameters.as_slice().into())
    }

    /// True where whole steps serve: next to a singular pose, they hardly ever do.
    pub(super) fn has_whole_steps(&self) -> bool {
        let system = self.evaluator.system();
        system.step.is_some()
            && !self.holding.is_on
            && self.multipliers.is_whole(system.nc())
            && self.multipliers.rank_margin() >= CLOSE
    }

    /// Room for the results of this step, which others take; it is the next one that is tried.
    pub(super) fn room_for(&mut self, span: StepSpan) -> &mut Vec<f64> {
        self.offered.span = Some(span);
        &mut self.offered.results
    }

    /// Looks at the pivots of states, see [`MultiplierSystem::accept_stages`].
    fn accept_pivots(&mut self, pivots: &[f64]) -> bool {
        let Self { multipliers, holding, least_margin, .. } = self;
        multipliers.accept_stages(pivots, NOTICEABLE, |margin| {
            holding.observe(margin);
            *least_margin = least_margin.min(margin);
        })
    }

    /// True where the gap of a projected end is closed, or no step of Newton's method helps; see
    /// [`ExplicitMotion::project`].
    fn is_closed(&self, end: &ProjectedEnd<'_>, y: &[f64]) -> bool {
        match *end.gaps {
            [before, after] => {
                let q = &y[..self.multipliers.n_coordinates()];
                after <= CLOSED * size_of(q) || after >= before
            }
            _ => true,
        }
    }

    /// Takes an end whose pivots need no closer look.
    fn take_end(
        &mut self,
        end: &ProjectedEnd<'_>,
        pivots: &[f64],
        (y1, ydot1): (&mut [f64], &mut [f64]),
    ) -> bool {
        let is_regular = self.accept_pivots(pivots);
        if is_regular {
            let [state, slope] = end.state;
            y1.copy_from_slice(state);
            ydot1.copy_from_slice(slope);
        }
        is_regular
    }

    /// The integrator's settings for a model's options.
    pub(crate) fn settings(options: &SolveOptions, nq: usize) -> Settings {
        let rtol = (SAFETY * options.rtol).max(1e-14);
        let mut atol = vec![SAFETY * options.atol; 2 * nq];
        // Not controlled.
        atol.push(f64::MAX.sqrt());
        let step = match options.step {
            None => StepControl::Adaptive,
            Some(h) => StepControl::Fixed { h, newton_tolerance: options.newton_tolerance },
        };
        Settings { rtol, atol: Tolerance::PerUnknown(atol), step, ..Settings::default() }
    }
}

impl Ode for ExplicitMotion<'_> {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn derivative(&mut self, t: f64, y: &[f64], ydot: &mut [f64]) -> Result<(), NotFinite> {
        let Self {
            evaluator, multipliers, holding, least_margin, lambda, has_left_factors, ..
        } = self;
        let nq = (y.len() - 1) / 2;
        let (q, v) = y[..2 * nq].split_at(nq);
        let (qdot, rest) = ydot.split_at_mut(nq);
        let (vdot, power) = rest.split_at_mut(nq);
        qdot.copy_from_slice(v);
        *has_left_factors =
            !holding.is_on && multipliers.line_into(evaluator, t, (q, v), vdot, lambda);
        if !*has_left_factors {
            let solved = if holding.is_on {
                multipliers.nearby_into(evaluator, t, (q, v), vdot, lambda)
            } else {
                multipliers.limit_into(evaluator, t, (q, v), vdot, lambda).map(|_| ())
            };
            solved.map_err(|NotFinite { row }| NotFinite { row: nq + row.min(nq) })?;
        }
        let margin = multipliers.rank_margin();
        holding.observe(margin);
        *least_margin = least_margin.min(margin);
        power[0] = evaluator.power(t, q, v, lambda);
        Ok(())
    }

    fn whole_step(
        &mut self,
        span: StepSpan,
        y: &[f64],
        ydot: &[f64],
        results: &mut Vec<f64>,
    ) -> bool {
        if !self.has_whole_steps() {
            return false;
        }
        let Self { evaluator, step, parameters, offered, .. } = self;
        let Some(whole) = &evaluator.system().step else { return false };
        match offered.span.take() {
            Some(of) if of == span => std::mem::swap(results, &mut offered.results),
            _ if whole.take(step, parameters, span, (y, ydot), results) => (),
            _ => return false,
        }
        let StepResults { numbers, factors, pivots, .. } = whole.results(results);
        if !are_finite(numbers) || !self.accept_pivots(pivots) {
            return false;
        }
        self.multipliers.take_stage(factors);
        self.has_left_factors = false;
        true
    }

    fn whole_end(&mut self, t1: f64, results: &[f64], y1: &mut [f64], ydot1: &mut [f64]) -> bool {
        let Some(whole) = &self.evaluator.system().step else { return false };
        if !self.multipliers.is_projected() {
            return false;
        }
        let StepResults { end, factors, end_pivots, .. } = whole.results(results);
        if self.is_closed(&end, y1) {
            return self.take_end(&end, end_pivots, (y1, ydot1));
        }
        // Long steps leave a gap that one step of Newton's method does not close.
        let mut closing = self.closing.take().unwrap_or_else(|| self.buffers());
        let mut is_taken = false;
        let mut state = end.state[0].to_vec();
        for pass in 2..=MAX_PASSES {
            let (end, pivots) = whole.close(&mut closing, t1, (&state, factors));
            if pass == MAX_PASSES || self.is_closed(&end, y1) {
                is_taken = end.is_finite() && self.take_end(&end, pivots, (y1, ydot1));
                break;
            }
            state.copy_from_slice(end.state[0]);
        }
        self.closing = Some(closing);
        is_taken
    }

    fn note(&mut self, attempt: Attempt) {
        self.holding.note(attempt);
    }

    fn project(&mut self, t: f64, y: &mut [f64]) -> Result<(), NotFinite> {
        if std::mem::take(&mut self.has_left_factors) {
            self.multipliers.take_factors(&self.evaluator);
        }
        let nq = (y.len() - 1) / 2;
        let (q, rest) = y.split_at_mut(nq);
        let v = &mut rest[..nq];
        let size = size_of(q);
        for _ in 0..MAX_PASSES {
            let drift = self.multipliers.project(&mut self.evaluator, t, (&mut *q, &mut *v), 1);
            if drift.position[1].is_nan() || drift.velocity[1].is_nan() {
                return Err(NotFinite { row: 0 });
            }
            let has_gained = drift.position[1] < drift.position[0];
            if drift.position[1] <= CLOSED * size || !has_gained {
                break;
            }
        }
        Ok(())
    }
}
