//! Legs of Radau's: the equations of motion as they are formulated.

use bksim_dae::{
    Checkpoint, Loader, Method, Saver, Settings, SolveError, Solver, Start as From, Step,
    StepControl, System,
};

use super::legs::{LegEnd, Run, State, sum};
use super::recorder::Stretch;
use super::singular::is_ahead;
use crate::formulate::{Motion, MotionEquations};
use crate::hybrid::EventMonitor;
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

impl Run<'_, '_> {
    /// Integrates with Radau IIA.
    pub(super) fn radau_leg(&mut self, equations: &MotionEquations) -> LegEnd {
        let is_watching = self.options.step.is_none();
        let mut lookout = self.lookout();
        let mut solver = match self.radau_solver(equations, lookout.as_mut()) {
            Ok(solver) => solver,
            Err(error) => return LegEnd::Failed(Some(error)),
        };
        loop {
            let step = match solver.step() {
                Ok(Some(step)) => step,
                Ok(None) => return LegEnd::Reached,
                Err(error) => return self.failed(error),
            };
            if let Some(lookout) = &mut lookout
                && let Some(end) = self.until_event(lookout, &step, false)
            {
                return end;
            }
            let evaluator = &mut self.recorder.evaluator;
            if is_watching && is_ahead(evaluator, &mut self.multipliers, &step) {
                self.recorder.summary.stats = sum(&self.before, step.stats());
                return LegEnd::SingularAhead(step.t1());
            }
            if self.is_off_branch(step.t1(), step.y1()) {
                return LegEnd::Failed(None);
            }
            let is_stopping = self.pass_radau_step(&step);
            if self.options.formulation == Formulation::Index1
                && let Err(error) = self.project(&mut solver, equations)
            {
                return self.failed(error);
            }
            if is_stopping {
                self.leg = Some(keep(&solver, lookout.as_ref()));
                return LegEnd::Stopped;
            }
        }
    }

    /// The solver of a leg, from its start or from where it was stopped.
    fn radau_solver<'e>(
        &mut self,
        equations: &'e MotionEquations,
        lookout: Option<&mut EventMonitor<'_>>,
    ) -> Result<Solver<Motion<'e>>, SolveError> {
        let State { t, q, v } = &self.reached;
        let motion = equations.at(&self.recorder.switching.parameters, &self.dependent);
        let (settings, t_end) = (settings(self.options, equations), self.options.t_end);
        if let Some(leg) = self.leg.take() {
            let mut loader = Loader::new(&leg, Method::Radau)?;
            let solver = Solver::resume(motion, &loader.checkpoint()?, t_end, settings)?;
            if let Some(lookout) = lookout {
                let (y, ydot) = (solver.y().to_vec(), solver.ydot().to_vec());
                lookout.load(&mut loader, &From { t: *t, y, ydot })?;
            }
            return Ok(solver);
        }
        let (mut a, mut lambda) =
            (vec![0.0; q.len()], vec![0.0; self.recorder.sample.lambda.len()]);
        let at = self.recorder.evaluator.dynamics(*t, q, v);
        // What is not finite here is found, and named, by the first step.
        let _ = self.multipliers.accelerations_into(&at, &mut a, &mut lambda);
        let (y, ydot) = equations.state(q, v, &a, &lambda);
        Solver::new(motion, From { t: *t, y, ydot }, t_end, settings)
    }

    fn pass_radau_step(&mut self, step: &Step<'_>) -> bool {
        let n = step.y1().len();
        let at = |t: f64, y: &mut [f64]| step.at(t, &mut y[..n]);
        let stats = sum(&self.before, step.stats());
        let stretch = Stretch {
            t0: step.t0(),
            t1: step.t1(),
            at: &at,
            degree: step.degree(),
            has_work: false,
            h: step.h(),
            stats,
        };
        let control = self.recorder.pass(&stretch, self.observer);
        self.recorder.summary.stats = stats;
        self.reached.take(step.t1(), step.y1());
        self.or_stop(control)
    }

    /// Puts the end of a step of index 1 back onto the constraints, from which it drifts.
    fn project<S: System>(
        &mut self,
        solver: &mut Solver<S>,
        equations: &MotionEquations,
    ) -> Result<(), SolveError> {
        const CORRECTIONS: usize = 2;
        let State { t, q, v } = &mut self.reached;
        let evaluator = &mut self.recorder.evaluator;
        let (mut a, mut lambda) =
            (vec![0.0; q.len()], vec![0.0; self.recorder.sample.lambda.len()]);
        // The factors of the state before the projection; what is not finite shows in the next step.
        let _ = self.multipliers.factor(&evaluator.dynamics(*t, q, v));
        self.multipliers.project(evaluator, *t, (&mut *q, &mut *v), CORRECTIONS);
        let at = evaluator.dynamics(*t, q, v);
        let _ = self.multipliers.accelerations_into(&at, &mut a, &mut lambda);
        let (y, ydot) = equations.state(q, v, &a, &lambda);
        solver.correct_state(&y, &ydot)
    }
}

/// A leg in progress, for a run that goes on from here.
fn keep<S: System>(solver: &Solver<S>, lookout: Option<&EventMonitor<'_>>) -> Checkpoint {
    let mut saver = Saver::default();
    saver.checkpoint(&solver.save());
    if let Some(lookout) = lookout {
        lookout.save(&mut saver);
    }
    saver.finish(Method::Radau)
}
