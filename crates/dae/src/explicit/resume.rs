//! Checkpoints of explicit runs.

use super::ExplicitSolver;
use crate::checkpoint::{Checkpoint, Loader, Method, Saver};
use crate::error::SolveError;
use crate::noise::Noise;
use crate::run::Start;
use crate::settings::Settings;
use crate::system::Ode;

impl<S: Ode> ExplicitSolver<S> {
    /// The state of the run, between two steps. The dense output of the last step is not part of
    /// it.
    pub fn save(&self) -> Checkpoint {
        let mut saver = Saver::default();
        saver.real(self.t);
        saver.slice(&self.y);
        saver.slice(&self.ydot);
        saver.real(self.h);
        saver.real(self.grid.0);
        saver.count(self.grid.1);
        saver.real(self.controller.last_error());
        saver.flag(self.controller.is_retry);
        self.controller.noise.save(&mut saver);
        saver.count(self.stiffness.n_beyond);
        saver.count(self.stiffness.n_within);
        saver.stats(&self.stats);
        saver.finish(Method::Explicit)
    }

    /// Continues a saved run, with the same system, settings and end as before, bit for bit.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] when it was saved by another kind of run, and those of
    /// [`ExplicitSolver::new`].
    pub fn resume(
        system: S,
        checkpoint: &Checkpoint,
        t_end: f64,
        settings: Settings,
    ) -> Result<Self, SolveError> {
        let mut loader = Loader::new(checkpoint, Method::Explicit)?;
        let (t, y) = (loader.real()?, loader.slice()?.to_vec());
        let start = Start { t, ydot: vec![0.0; y.len()], y };
        let mut solver = Self::new(system, start, t_end, settings)?;
        loader.fill(&mut solver.ydot)?;
        solver.h = loader.real()?;
        solver.grid = (loader.real()?, loader.count()?);
        solver.controller.remember(loader.real()?);
        solver.controller.is_retry = loader.flag()?;
        solver.controller.noise = Noise::load(&mut loader)?;
        solver.stiffness.n_beyond = loader.count()?;
        solver.stiffness.n_within = loader.count()?;
        solver.stats = loader.stats()?;
        Ok(solver)
    }
}
