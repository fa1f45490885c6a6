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
    Checkpoint, Control, ExplicitSolver, Index, Layout, Loader, Method, NotFinite, Ode, Saver,
    Settings, SolveError, Start as From, StepControl, Tolerance,
};

use super::legs::{LegEnd, Run, State, sum};
use super::recorder::Stretch;
use super::singular::{NOTICEABLE, REGULAR, Sighting};
use crate::compiled::CompiledSystem;
use crate::evaluator::Evaluator;
use crate::hybrid::EventMonitor;
use crate::multiplier::MultiplierSystem;
use bksim_model::{self, SolveOptions};

/// A mechanism as y′ = f(t, y).
pub(crate) struct ExplicitMotion<'a> {
    evaluator: Evaluator<'a>,
    pub(crate) multipliers: MultiplierSystem,
    /// The least weakness of the stages since it was last looked at.
    pub(crate) weakest: f64,
    layout: Layout,
    lambda: Vec<f64>,
}

/// The integrator is asked for this part of the tolerance: what it keeps below is the error of a
/// step in the mean over the unknowns, what is asked of it is the error of the run in each. A step
/// of order eight grows only by 1.8 for it.
const SAFETY: f64 = 0.01;

impl<'a> ExplicitMotion<'a> {
    /// The motion at one set of parameters, its accelerations from these multiplier systems.
    pub(crate) fn new(
        compiled: &'a CompiledSystem,
        parameters: &[f64],
        multipliers: MultiplierSystem,
    ) -> Self {
        let quantities = &compiled.coordinates;
        let names = quantities.iter().map(|c| c.name.clone());
        let rates = quantities.iter().map(|c| format!("{}_dot", c.name));
        let names = names.chain(rates).chain(["work".to_owned()]).collect();
        Self {
            evaluator: compiled.evaluator(parameters),
            multipliers,
            weakest: 1.0,
            layout: Layout::from_groups(&[(2 * compiled.nq() + 1, Index::One)]).with_names(names),
            lambda: vec![0.0; compiled.nc()],
        }
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
        let Self { evaluator, multipliers, weakest, lambda, .. } = self;
        let nq = (y.len() - 1) / 2;
        let (q, v) = y[..2 * nq].split_at(nq);
        let (qdot, rest) = ydot.split_at_mut(nq);
        let (vdot, power) = rest.split_at_mut(nq);
        qdot.copy_from_slice(v);
        let solved = multipliers.limit_into(evaluator, t, (q, v), vdot, lambda);
        solved.map_err(|NotFinite { row }| NotFinite { row: nq + row.min(nq) })?;
        *weakest = weakest.min(multipliers.rank_margin());
        power[0] = evaluator.power(t, q, v, lambda);
        Ok(())
    }

    fn project(&mut self, t: f64, y: &mut [f64]) -> Result<(), NotFinite> {
        // What a step leaves open is so small that one Newton step with the factors of the last
        // stage closes it to rounding, but for long steps.
        const CLOSED: f64 = 1e-11;
        const MAX_PASSES: usize = 3;
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

impl<'a> Run<'a, '_> {
    /// Integrates with explicit steps.
    pub(super) fn explicit_leg(&mut self, compiled: &'a CompiledSystem) -> LegEnd {
        let mut lookout = self.lookout();
        let mut solver = match self.explicit_solver(compiled, lookout.as_mut()) {
            Ok(solver) => solver,
            Err(error) => return LegEnd::Failed(Some(error)),
        };
        let may_switch = self.options.method == bksim_model::Method::Auto && self.passing.is_none();
        let end = loop {
            match solver.advance() {
                Ok(true) => (),
                Ok(false) => break LegEnd::Reached,
                Err(error) => break self.failed(error),
            }
            if let Some(lookout) = &mut lookout {
                let step = match solver.last_step() {
                    Ok(step) => step,
                    Err(error) => break self.failed(error),
                };
                if let Some(end) = self.until_event(lookout, &step, true) {
                    break end;
                }
            }
            let motion = solver.system_mut();
            let weakness = motion.multipliers.rank_margin();
            let weakest = std::mem::replace(&mut motion.weakest, weakness);
            if self.is_off_branch(solver.t(), solver.y()) {
                break LegEnd::Failed(None);
            }
            if weakest >= NOTICEABLE {
                self.watch.leave();
            } else if let Err(error) = self.search_singular_pose(&mut solver) {
                break self.failed(error);
            }
            let is_stopping = match self.pass_explicit_step(&mut solver) {
                Ok(is_stopping) => is_stopping,
                Err(error) => break self.failed(error),
            };
            let is_past = |until: f64| (solver.t() - until) * solver.h().signum() >= 0.0;
            if weakness > REGULAR && self.passing.is_some_and(is_past) {
                break LegEnd::Regular;
            }
            if may_switch && solver.is_stiff() {
                break LegEnd::Stiff;
            }
            if is_stopping {
                self.leg = Some(keep(&mut solver, lookout.as_ref()));
                break LegEnd::Stopped;
            }
        };
        self.multipliers.clone_from(&solver.system_mut().multipliers);
        end
    }

    /// The solver of a leg, from its start or from where it was stopped.
    fn explicit_solver(
        &mut self,
        compiled: &'a CompiledSystem,
        lookout: Option<&mut EventMonitor<'_>>,
    ) -> Result<ExplicitSolver<ExplicitMotion<'a>>, SolveError> {
        let State { t, q, v } = &self.reached;
        let parameters = &self.recorder.switching.parameters;
        let motion = ExplicitMotion::new(compiled, parameters, self.multipliers.clone());
        let y = [q.as_slice(), v, &[self.recorder.summary.energy.work]].concat();
        let from = From { t: *t, ydot: vec![0.0; y.len()], y };
        let settings = ExplicitMotion::settings(self.options, q.len());
        let t_end = self.options.t_end;
        let Some(leg) = self.leg.take() else {
            self.watch.leave();
            return ExplicitSolver::new(motion, from, t_end, settings);
        };
        let mut loader = Loader::new(&leg, Method::Explicit)?;
        let mut solver = ExplicitSolver::resume(motion, &loader.checkpoint()?, t_end, settings)?;
        let motion = solver.system_mut();
        let shape = motion.evaluator.shape();
        motion.multipliers.load(shape, &mut loader)?;
        motion.weakest = loader.real()?;
        if let Some(lookout) = lookout {
            lookout.load(&mut loader, &from)?;
        }
        Ok(solver)
    }

    /// Outputs of an explicit step; its dense output is made only when it is needed.
    fn pass_explicit_step(
        &mut self,
        solver: &mut ExplicitSolver<ExplicitMotion<'_>>,
    ) -> Result<bool, SolveError> {
        let (t0, t1, nq) = (self.reached.t, solver.t(), self.reached.q.len());
        let mut control = Control::Continue;
        if self.recorder.due(t1).is_some() || self.observer.wants_segments() {
            let step = solver.last_step()?;
            let n = step.y1().len();
            let at = |t: f64, y: &mut [f64]| step.at(t, &mut y[..n]);
            let stats = sum(&self.before, step.stats());
            let stretch = Stretch {
                t0,
                t1,
                at: &at,
                degree: step.degree(),
                has_work: true,
                h: t1 - t0,
                stats,
            };
            control = self.recorder.pass(&stretch, self.observer);
        }
        self.recorder.summary.energy.work = solver.y()[2 * nq];
        self.recorder.summary.stats = sum(&self.before, solver.stats());
        self.reached.take(t1, solver.y());
        Ok(self.or_stop(control))
    }

    /// Looks for a singular pose in a step with a weak stage.
    fn search_singular_pose(
        &mut self,
        solver: &mut ExplicitSolver<ExplicitMotion<'_>>,
    ) -> Result<(), SolveError> {
        self.multipliers.clone_from(&solver.system_mut().multipliers);
        let step = solver.last_step()?;
        let evaluator = &mut self.recorder.evaluator;
        let poses = &mut self.recorder.summary.singular_poses;
        match self.watch.search(evaluator, &mut self.multipliers, &step) {
            Some(Sighting::New(pose)) => poses.push(pose),
            Some(Sighting::Better(pose)) => {
                poses.pop();
                poses.push(pose);
            }
            None => (),
        }
        Ok(())
    }
}

/// A leg in progress, for a run that goes on from here.
fn keep(
    solver: &mut ExplicitSolver<ExplicitMotion<'_>>,
    lookout: Option<&EventMonitor<'_>>,
) -> Checkpoint {
    let mut saver = Saver::default();
    saver.checkpoint(&solver.save());
    let motion = solver.system_mut();
    motion.multipliers.save(&mut saver);
    saver.real(motion.weakest);
    if let Some(lookout) = lookout {
        lookout.save(&mut saver);
    }
    saver.finish(Method::Explicit)
}
