//! The motion as an ordinary differential equation: accelerations from the multiplier system, the
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

use bksim_dae::{
    Advance, Attempt, Checkpoint, ExplicitMethod, ExplicitSolver, Index, Lanes, Layout, Loader,
    Method, Noise, NotFinite, Ode, Saver, Settings, SolveError, Standstill, Start as From, Stats,
    Step, StepControl, StepSpan, Tolerance,
};

use super::dense::DenseOutput;
use super::ending::PhaseEnd;
use super::holding::Holding;
use super::lanes::LaneMotion;
use super::mechanism::PhaseMechanism;
use super::problem::Problem;
use super::race::LARGE;
use super::singular::{CLOSE, FLAT, NOTICEABLE, REGULAR, Sighting, SingularMonitor};
use super::stepper::Stepper;
use crate::compiled::CompiledSystem;
use crate::evaluator::Evaluator;
use crate::hybrid::EventMonitor;
use crate::multiplier::{MultiplierSystem, largest};
use crate::state::State;
use crate::whole_step::{PendingStep, StepBuffers, StepResults};
use bksim_model::{self, Outputs, SolveOptions};

/// A mechanism as y′ = f(t, y).
pub(crate) struct ExplicitMotion<'a> {
    evaluator: Evaluator<'a>,
    pub(crate) multipliers: MultiplierSystem,
    /// The least rank margin of the stages since it was last looked at.
    pub(crate) least_margin: f64,
    holding: Holding,
    layout: Layout,
    lambda: Vec<f64>,
    /// The same at several states at once, where that is asked for.
    lanes: Option<LaneMotion<'a>>,
    /// Whole steps.
    step: Option<StepBuffers>,
    parameters: Vec<f64>,
    /// The results of one that was taken together with those of other runs.
    offered: Option<(StepSpan, Vec<f64>)>,
    last: LastFactors,
}

/// Where the factors of the last state are.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum LastFactors {
    /// With the multiplier system.
    Taken,
    /// With the evaluator.
    OfOne,
    /// With the states in lanes.
    OfLanes,
}

/// The integrator is asked for this part of the tolerance: what it keeps below is the error of a
/// step in the mean over the unknowns, what is asked of it is the error of the run in each. A step
/// of order eight grows only by 1.8 for it.
const SAFETY: f64 = 0.01;

/// The gap that is as good as closed, as a part of the largest coordinate. That which a step leaves is so small that
/// one Newton step with the factors of the last stage closes it to rounding, but for long steps.
const CLOSED: f64 = 1e-11;

impl<'a> ExplicitMotion<'a> {
    /// The motion at one set of parameters, its accelerations from these multiplier systems.
    pub(crate) fn new(
        compiled: &'a CompiledSystem,
        parameters: &[f64],
        multipliers: MultiplierSystem,
    ) -> Self {
        let quantities = &compiled.coordinates;
        let names = quantities.iter().map(|c| c.name.clone());
        let rates = quantities.iter().map(|c| c.rates[0][0].clone());
        let names = names.chain(rates).chain(["work".to_owned()]).collect();
        Self {
            evaluator: compiled.evaluator(parameters),
            multipliers,
            least_margin: 1.0,
            holding: Holding::of_one(),
            layout: Layout::from_groups(&[(2 * compiled.nq() + 1, Index::One)]).with_names(names),
            lambda: vec![0.0; compiled.nc()],
            lanes: None,
            step: None,
            offered: None,
            parameters: parameters.to_vec(),
            last: LastFactors::Taken,
        }
    }

    /// The same motion, at several states at once where the mechanism is so small.
    fn in_lanes(self, parameters: &[f64]) -> Self {
        let compiled = self.evaluator.system();
        let lanes = LaneMotion::new(compiled, parameters);
        Self { lanes, holding: Holding::of_lanes(), ..self }
    }

    /// True where whole steps serve: next to a singular pose, they hardly ever do.
    fn has_whole_steps(&self) -> bool {
        let system = self.evaluator.system();
        system.step.is_some()
            && !self.holding.is_on
            && self.multipliers.is_whole(system.nc())
            && self.multipliers.rank_margin() >= CLOSE
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
        let Self { evaluator, multipliers, holding, least_margin, lambda, last, .. } = self;
        let nq = (y.len() - 1) / 2;
        let (q, v) = y[..2 * nq].split_at(nq);
        let (qdot, rest) = ydot.split_at_mut(nq);
        let (vdot, power) = rest.split_at_mut(nq);
        qdot.copy_from_slice(v);
        *last = LastFactors::OfOne;
        if holding.is_on || !multipliers.line_into(evaluator, t, (q, v), vdot, lambda) {
            *last = LastFactors::Taken;
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

    fn derivative_lanes(&mut self, t: Lanes, y: &[Lanes], ydot: &mut [Lanes]) -> bool {
        let Self { multipliers, lanes: Some(lanes), holding, least_margin, last, .. } = self else {
            return false;
        };
        if holding.is_on || !lanes.derivative(multipliers, t, y, ydot) {
            return false;
        }
        let margin = multipliers.rank_margin();
        holding.observe(margin);
        *least_margin = least_margin.min(margin);
        *last = LastFactors::OfLanes;
        true
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
        let Self {
            evaluator, multipliers, step, parameters, holding, least_margin, offered, ..
        } = self;
        let Some(whole) = &evaluator.system().step else { return false };
        match offered.take() {
            Some((of, numbers)) if of == span => *results = numbers,
            _ if whole.take(step, parameters, span, (y, ydot), results) => (),
            _ => return false,
        }
        let StepResults { factors, pivots, .. } = whole.results(results);
        let observe = |margin: f64| {
            holding.observe(margin);
            *least_margin = least_margin.min(margin);
        };
        if !multipliers.accept_stages(pivots, NOTICEABLE, observe) {
            return false;
        }
        multipliers.take_stage(factors);
        self.last = LastFactors::Taken;
        true
    }

    fn whole_end(&mut self, results: &[f64], y1: &mut [f64], ydot1: &mut [f64]) -> bool {
        let Self { evaluator, multipliers, holding, least_margin, .. } = self;
        let Some(whole) = &evaluator.system().step else { return false };
        let StepResults { residuals: [gap, left], end: [end, slope], end_pivots, .. } =
            whole.results(results);
        if !multipliers.is_projected() {
            return false;
        }
        // As in `project`: a step of Newton's method that was needed, has helped and is enough.
        let [gap, left] = [largest(gap), largest(left)];
        let size =
            y1[..multipliers.n_coordinates()].iter().fold(1.0, |size: f64, q| size.max(q.abs()));
        let is_closed = end_pivots.len() == multipliers.n_coordinates()
            || (left < gap && left <= CLOSED * size);
        let is_finite = end.iter().chain(slope).fold(true, |all, x| all & x.is_finite());
        let observe = |margin: f64| {
            holding.observe(margin);
            *least_margin = least_margin.min(margin);
        };
        if !is_closed || !is_finite || !multipliers.accept_stages(end_pivots, NOTICEABLE, observe) {
            return false;
        }
        y1.copy_from_slice(end);
        ydot1.copy_from_slice(slope);
        true
    }

    fn note(&mut self, attempt: Attempt) {
        self.holding.note(attempt);
    }

    fn project(&mut self, t: f64, y: &mut [f64]) -> Result<(), NotFinite> {
        const MAX_PASSES: usize = 3;
        match (self.last, &self.lanes) {
            (LastFactors::OfOne, _) => self.multipliers.take_factors(&self.evaluator),
            (LastFactors::OfLanes, Some(lanes)) => {
                self.multipliers.take_lane(lanes.factors_near(t));
            }
            _ => (),
        }
        self.last = LastFactors::Taken;
        let nq = (y.len() - 1) / 2;
        let (q, rest) = y.split_at_mut(nq);
        let v = &mut rest[..nq];
        let size = q.iter().fold(1.0, |size: f64, q| size.max(q.abs()));
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

/// Explicit steps of a run.
pub(super) struct ExplicitStepper<'a> {
    solver: ExplicitSolver<ExplicitMotion<'a>>,
    /// Rank margin at the end of the last step, at its start, and the least of its stages.
    margin: f64,
    first_margin: f64,
    least_margin: f64,
    /// Until when steps are explicit only to pass a singular pose.
    passing: Option<f64>,
    /// Whether Radau takes over where the motion turns stiff.
    yields_to_radau: bool,
    method: ExplicitMethod,
    /// True where its attempts are taken together with those of other runs, each when all are.
    is_abreast: bool,
}

/// The explicit method for options that leave the choice, where accelerations can be had in lanes and nothing
/// switches. Extrapolation has dear dense output, so that outputs must be few.
pub fn cheapest_explicit(options: &SolveOptions) -> ExplicitMethod {
    const FEW: f64 = 20.0;
    let n_outputs = match &options.outputs {
        Outputs::Even => (options.t_end - options.t_start).abs() / options.interval(),
        // Whoever holds a run asks for any instant.
        Outputs::Times(times) if !times.is_empty() => times.len() as f64,
        Outputs::Times(_) | Outputs::Steps => f64::INFINITY,
    };
    // Measured on four mechanisms: at looser tolerances steps are so few and long that fewer stages are as cheap, at
    // tighter ones rounding is near.
    let is_fine = (1e-11..=1e-8).contains(&options.rtol);
    if options.method != bksim_model::Method::Auto
        || options.step.is_some()
        || n_outputs > FEW
        || !is_fine
    {
        return ExplicitMethod::DormandPrince;
    }
    ExplicitMethod::Extrapolation { columns: 7 }
}

/// The state that a phase of explicit steps begins with.
pub(super) struct ExplicitStart<'s> {
    pub(super) state: &'s State,
    /// End of the phase, s.
    pub(super) t_end: f64,
    /// Work of loads and drives so far, J.
    pub(super) work: f64,
    pub(super) multipliers: &'s MultiplierSystem,
    /// Until when steps are explicit only to pass a singular pose.
    pub(super) passing: Option<f64>,
}

impl<'a> ExplicitStepper<'a> {
    /// From the start of a phase, or from where it was `saved`, with its monitor of events.
    ///
    /// # Errors
    /// [`SolveError`] when the accelerations have no value there, or what was saved does not fit.
    pub(super) fn new(
        Problem { options, .. }: Problem<'a>,
        start: &ExplicitStart<'_>,
        mechanism: &PhaseMechanism<'a>,
        saved: Option<&Checkpoint>,
        monitor: Option<&mut EventMonitor<'a>>,
    ) -> Result<Self, SolveError> {
        let ExplicitStart { state: State { t, q, v }, t_end, work, multipliers, passing } = *start;
        let (parameters, shape) = (mechanism.parameters(), &mechanism.compiled().shape);
        let motion = ExplicitMotion::new(mechanism.compiled(), parameters, multipliers.clone());
        let y = [q.as_slice(), v, &[work]].concat();
        let from = From { t: *t, ydot: vec![0.0; y.len()], y };
        let mut settings = ExplicitMotion::settings(options, q.len());
        let is_whole = multipliers.active_rows().len() == mechanism.compiled().nc();
        let has_lanes = mechanism.compiled().has_lanes() && is_whole;
        if has_lanes && monitor.is_none() && passing.is_none() {
            settings.explicit = cheapest_explicit(options);
        }
        let method = settings.explicit;
        let motion = match method {
            ExplicitMethod::DormandPrince => motion,
            ExplicitMethod::Extrapolation { .. } => motion.in_lanes(parameters),
        };
        let mut margin = 1.0;
        let solver = match saved {
            None => ExplicitSolver::new(motion, from, t_end, settings)?,
            Some(saved) => {
                let mut loader = Loader::new(saved, Method::Explicit)?;
                let numbers = loader.checkpoint()?;
                let mut solver = ExplicitSolver::resume(motion, &numbers, t_end, settings)?;
                let motion = solver.system_mut();
                motion.multipliers.load(shape, &mut loader)?;
                motion.least_margin = loader.real()?;
                motion.holding.load(&mut loader)?;
                margin = loader.real()?;
                if let Some(monitor) = monitor {
                    monitor.load(&mut loader, &from)?;
                }
                solver
            }
        };
        Ok(Self {
            solver,
            margin,
            first_margin: 1.0,
            least_margin: 1.0,
            passing,
            method,
            is_abreast: false,
            yields_to_radau: options.method == bksim_model::Method::Auto && passing.is_none(),
        })
    }
}

impl Stepper for ExplicitStepper<'_> {
    fn advance(&mut self) -> Result<Advance, SolveError> {
        if self.is_abreast {
            return self.solver.advance_once();
        }
        Ok(if self.solver.advance()? { Advance::Accepted } else { Advance::Ended })
    }

    fn last_step(&mut self) -> Result<Step<'_>, SolveError> {
        self.solver.last_step()
    }

    fn pending(&self) -> Option<PendingStep<'_>> {
        let motion = self.solver.system();
        if self.method != ExplicitMethod::DormandPrince || !motion.has_whole_steps() {
            return None;
        }
        let (span, y, ydot) = self.solver.pending()?;
        Some(PendingStep { parameters: &motion.parameters, span, y, ydot })
    }

    fn offer(&mut self, span: StepSpan, results: Vec<f64>) {
        self.is_abreast = true;
        self.solver.system_mut().offered = Some((span, results));
    }

    /// Never: the accelerations have a limit in a singular pose. Notes the rank margin of the stages,
    /// before dense output adds stages of its own.
    fn is_singular_ahead(&mut self, _: &mut Evaluator<'_>) -> bool {
        let motion = self.solver.system_mut();
        self.first_margin = std::mem::replace(&mut self.margin, motion.multipliers.rank_margin());
        self.least_margin = std::mem::replace(&mut motion.least_margin, self.margin);
        false
    }

    fn crossed_singular_pose(
        &mut self,
        evaluator: &mut Evaluator<'_>,
        monitor: &mut SingularMonitor,
    ) -> Result<Option<Sighting>, SolveError> {
        if self.least_margin >= NOTICEABLE {
            monitor.leave();
            return Ok(None);
        }
        let at_ends = self.first_margin.max(self.margin);
        let is_flat = self.least_margin >= (FLAT * at_ends).max(CLOSE);
        if is_flat && at_ends >= NOTICEABLE {
            monitor.leave();
        }
        if is_flat && monitor.has_begun() {
            return Ok(None);
        }
        // A copy: the search must leave the factors and pivots of the motion alone.
        let mut multipliers = self.solver.system_mut().multipliers.clone();
        let step = self.solver.last_step()?;
        monitor.begin(evaluator, &multipliers, &step);
        if is_flat {
            return Ok(None);
        }
        Ok(monitor.search(evaluator, &mut multipliers, &step))
    }

    fn dense_output(&mut self) -> Result<DenseOutput<'_>, SolveError> {
        let mut dense = DenseOutput::from(self.solver.last_step()?);
        dense.h = dense.t1 - dense.t0;
        dense.has_work = true;
        Ok(dense)
    }

    /// Nothing to do: the solver has projected the state.
    fn correct(&mut self, _: &mut Evaluator<'_>, _: &mut State) -> Result<(), SolveError> {
        Ok(())
    }

    fn succession(&mut self) -> Option<PhaseEnd> {
        let Self { solver, margin, passing, .. } = self;
        let is_past = |until: f64| (solver.t() - until) * solver.h().signum() >= 0.0;
        if *margin > REGULAR && passing.is_some_and(is_past) {
            return Some(PhaseEnd::Regular);
        }
        (self.yields_to_radau && solver.is_stiff()).then_some(PhaseEnd::Stiff)
    }

    fn stability(&self) -> f64 {
        match self.method {
            ExplicitMethod::DormandPrince => self.solver.stability(),
            // Of its longer steps, accuracy leaves less of the stable range.
            ExplicitMethod::Extrapolation { .. } => {
                const FAR: f64 = 0.6;
                self.solver.stability() * LARGE / (FAR * self.method.stable_range())
            }
        }
    }

    fn noise(&self) -> Noise {
        self.solver.noise()
    }

    fn account(&self) -> Standstill {
        self.solver.account()
    }

    fn t(&self) -> f64 {
        self.solver.t()
    }

    fn y(&self) -> &[f64] {
        self.solver.y()
    }

    fn work(&self) -> Option<f64> {
        self.solver.y().last().copied()
    }

    fn stats(&self) -> &Stats {
        self.solver.stats()
    }

    fn multipliers(&mut self) -> &MultiplierSystem {
        &self.solver.system_mut().multipliers
    }

    fn method(&self) -> Method {
        Method::Explicit
    }

    fn save(&mut self, saver: &mut Saver) {
        saver.checkpoint(&self.solver.save());
        let motion = self.solver.system_mut();
        motion.multipliers.save(saver);
        saver.real(motion.least_margin);
        motion.holding.save(saver);
        saver.real(self.margin);
    }
}
