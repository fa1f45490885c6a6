//! Steps of Radau IIA: the equations of motion as they are formulated.

use bksim_dae::{
    Advance, Checkpoint, Loader, Method, Noise, Saver, Settings, SolveError, Solver, Standstill,
    Start as From, Stats, Step, StepControl,
};

use super::dense::DenseOutput;
use super::ending::PhaseEnd;
use super::mechanism::PhaseMechanism;
use super::problem::Problem;
use super::singular::{Sighting, SingularMonitor, is_ahead};
use super::stepper::Stepper;
use crate::evaluator::Evaluator;
use crate::formulate::{MotionEquations, MotionSystem};
use crate::hybrid::EventMonitor;
use crate::multiplier::MultiplierSystem;
use crate::state::{Acceleration, State};
use bksim_model::{Formulation, SolveOptions};

/// The integrator's settings for a model's options.
pub(crate) fn settings(options: &SolveOptions, equations: &MotionEquations) -> Settings {
    Settings {
        rtol: options.rtol,
        atol: equations.tolerances(options.atol),
        step: match options.step {
            None => StepControl::Adaptive,
            Some(h) => StepControl::Fixed { h, newton_tolerance: options.newton_tolerance },
        },
        ..Settings::default()
    }
}

/// Radau's steps of a run.
pub(super) struct RadauStepper<'a> {
    solver: Solver<MotionSystem<'a>>,
    equations: &'a MotionEquations,
    multipliers: MultiplierSystem,
    /// Constant steps go on as long as they can.
    looks_ahead: bool,
    drifts: bool,
}

/// The state that a phase of Radau's begins with.
pub(super) struct RadauStart<'s> {
    pub(super) state: &'s State,
    /// End of the phase, s.
    pub(super) t_end: f64,
    /// Takes note of the pivots at the state.
    pub(super) multipliers: &'s mut MultiplierSystem,
}

impl<'a> RadauStepper<'a> {
    /// From the start of a phase, or from where it was `saved`, with its monitor of events.
    ///
    /// # Errors
    /// [`SolveError`] when the state does not fit, or what was saved.
    pub(super) fn new(
        Problem { equations, options, .. }: Problem<'a>,
        start: RadauStart<'_>,
        mechanism: &mut PhaseMechanism<'a>,
        saved: Option<&Checkpoint>,
        monitor: Option<&mut EventMonitor<'_>>,
    ) -> Result<Self, SolveError> {
        let equations: &MotionEquations = equations;
        let RadauStart { state, t_end, multipliers } = start;
        let State { t, q, v } = state;
        let motion = equations.at(mechanism.parameters(), &mechanism.inactive);
        let settings = settings(options, equations);
        let solver = match saved {
            None => {
                let nc = mechanism.compiled().nc();
                let mut begin = Acceleration::zeros(q.len(), nc);
                let Acceleration { a, lambda } = &mut begin;
                // Numbers that are not finite are found, and named, by the first step.
                let evaluator = &mut mechanism.evaluator;
                let _ = multipliers.accelerations_into(evaluator, *t, (q, v), a, lambda);
                let from = equations.unknowns(state.as_ref(), begin.as_ref());
                Solver::new(motion, from, t_end, settings)?
            }
            Some(saved) => {
                let mut loader = Loader::new(saved, Method::Radau)?;
                let solver = Solver::resume(motion, &loader.checkpoint()?, t_end, settings)?;
                if let Some(monitor) = monitor {
                    let (y, ydot) = (solver.y().to_vec(), solver.ydot().to_vec());
                    monitor.load(&mut loader, &From { t: *t, y, ydot })?;
                }
                solver
            }
        };
        Ok(Self {
            solver,
            equations,
            multipliers: multipliers.clone(),
            looks_ahead: options.step.is_none(),
            drifts: matches!(options.formulation, Formulation::Index1 | Formulation::Index2),
        })
    }
}

impl Stepper for RadauStepper<'_> {
    fn advance(&mut self) -> Result<Advance, SolveError> {
        Ok(if self.solver.step()?.is_some() { Advance::Accepted } else { Advance::Ended })
    }

    fn last_step(&mut self) -> Result<Step<'_>, SolveError> {
        Ok(self.solver.last_step())
    }

    fn is_singular_ahead(&mut self, evaluator: &mut Evaluator<'_>) -> bool {
        self.looks_ahead && is_ahead(evaluator, &mut self.multipliers, &self.solver.last_step())
    }

    /// Never: the phase ends before it.
    fn crossed_singular_pose(
        &mut self,
        _: &mut Evaluator<'_>,
        _: &mut SingularMonitor,
    ) -> Result<Option<Sighting>, SolveError> {
        Ok(None)
    }

    fn dense_output(&mut self) -> Result<DenseOutput<'_>, SolveError> {
        Ok(self.solver.last_step().into())
    }

    /// Projects the end of a step of index 1 or 2, whose equations know nothing of g, or of its rate
    /// either.
    fn correct(
        &mut self,
        evaluator: &mut Evaluator<'_>,
        reached: &mut State,
    ) -> Result<(), SolveError> {
        const CORRECTIONS: usize = 2;
        if !self.drifts {
            return Ok(());
        }
        let State { t, q, v } = reached;
        let nc = evaluator.shape().nc;
        let mut end = Acceleration::zeros(q.len(), nc);
        let Acceleration { a, lambda } = &mut end;
        let multipliers = &mut self.multipliers;
        // The factors are of the state before the projection. Numbers that are not finite show in the
        // next step.
        if !multipliers.factored_line_into(evaluator, *t, (q, v), a, lambda) {
            let _ = multipliers.factor(&evaluator.dynamics(*t, q, v));
        }
        multipliers.project(evaluator, *t, (&mut *q, &mut *v), CORRECTIONS);
        if !multipliers.factored_line_into(evaluator, *t, (q, v), a, lambda) {
            let _ = multipliers.accelerations_into(evaluator, *t, (q, v), a, lambda);
        }
        let From { y, ydot, .. } = self.equations.unknowns(reached.as_ref(), end.as_ref());
        self.solver.correct_state(&y, &ydot)
    }

    /// No succession: implicit steps are never the wrong ones, only slower than need be.
    fn succession(&mut self) -> Option<PhaseEnd> {
        None
    }

    fn stability(&self) -> f64 {
        0.0
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
        None
    }

    fn stats(&self) -> &Stats {
        self.solver.stats()
    }

    fn multipliers(&mut self) -> &MultiplierSystem {
        &self.multipliers
    }

    fn method(&self) -> Method {
        Method::Radau
    }

    fn save(&mut self, saver: &mut Saver) {
        saver.checkpoint(&self.solver.save());
    }
}
