//! [`ExplicitStepper`]: explicit steps, by the method of Dormand and Prince.

use bksim_dae::{
    Advance, Checkpoint, ExplicitSolver, Loader, Method, Noise, Saver, SolveError, Standstill,
    Start as From, Stats, Step, StepSpan,
};

use super::dense::DenseOutput;
use super::ending::PhaseEnd;
use super::mechanism::PhaseMechanism;
use super::motion::ExplicitMotion;
use super::problem::Problem;
use super::race::{DECAYING, LARGE, PURE, TIGHT};
use super::singular::{CLOSE, FLAT, NOTICEABLE, REGULAR, Sighting, SingularMonitor};
use super::stepper::Stepper;
use crate::evaluator::Evaluator;
use crate::hybrid::EventMonitor;
use crate::multiplier::MultiplierSystem;
use crate::state::State;
use crate::whole_step::PendingStep;
use bksim_model;

/// Explicit steps of a run.
pub(super) struct ExplicitStepper<'a> {
    solver: ExplicitSolver<ExplicitMotion<'a>>,
    /// Rank margin at the end of the last step, at its start, and the least of its stages.
    margin: f64,
    first_margin: f64,
    least_margin: f64,
    /// Until when steps are explicit only to pass a singular pose.
    passing: Option<f64>,
    /// True if Radau takes over where the motion turns stiff.
    yields_to_radau: bool,
    /// True if a fast decay may limit steps far within their stable range.
    is_tight: bool,
    /// True where its attempts are taken together with those of other runs, each when all are.
    is_abreast: bool,
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
        let settings = ExplicitMotion::settings(options, q.len());
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
            is_abreast: false,
            yields_to_radau: options.method == bksim_model::Method::Auto && passing.is_none(),
            is_tight: options.rtol <= TIGHT,
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
        if !motion.has_whole_steps() {
            return None;
        }
        let (span, y, ydot) = self.solver.pending()?;
        Some(PendingStep { parameters: &motion.parameters, span, y, ydot })
    }

    fn room_for(&mut self, span: StepSpan) -> Option<&mut Vec<f64>> {
        self.is_abreast = true;
        Some(self.solver.system_mut().room_for(span))
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
        let (h_rho, decay) = (self.solver.stability(), self.solver.decay());
        if self.is_tight && decay > PURE { h_rho * LARGE / DECAYING } else { h_rho }
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

    fn work_error(&self) -> f64 {
        self.solver.error_of(self.solver.y().len() - 1).abs()
    }

    fn power(&self) -> f64 {
        self.solver.ydot().last().copied().unwrap_or(0.0)
    }

    fn set_work(&mut self, work: f64) {
        self.solver.replace(self.solver.y().len() - 1, work);
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
