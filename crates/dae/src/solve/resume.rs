//! Radau's run as a checkpoint, and back.

use super::Solver;
use crate::checkpoint::{Checkpoint, Loader, Method, Saver};
use crate::error::SolveError;
use crate::run::Start;
use crate::settings::Settings;
use crate::step::max_iterations;
use crate::system::System;

impl<S: System> Solver<S> {
    /// The state of the run, between two steps.
    pub fn save(&self) -> Checkpoint {
        let mut saver = Saver::default();
        saver.real(self.t);
        saver.slice(&self.y);
        saver.slice(&self.ydot);
        saver.real(self.h);
        saver.real(self.grid.0);
        saver.count(self.grid.1);
        saver.flag(self.has_last);
        self.last.save(&mut saver);
        saver.count(self.n_failed);
        saver.stats(&self.stats);
        self.order.save(&mut saver);
        self.controller.save(&mut saver);
        self.stepper.save(&mut saver);
        saver.finish(Method::Radau)
    }

    /// Continues a saved run, with the same system, settings and end as before, bit for bit.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] when it was saved by another kind of run, and those of
    /// [`Solver::new`].
    pub fn resume(
        system: S,
        checkpoint: &Checkpoint,
        t_end: f64,
        settings: Settings,
    ) -> Result<Self, SolveError> {
        Self::load(system, &mut Loader::new(checkpoint, Method::Radau)?, t_end, settings)
    }

    /// Takes the numbers of the run out of a checkpoint that may hold more.
    pub(crate) fn load(
        system: S,
        loader: &mut Loader<'_>,
        t_end: f64,
        settings: Settings,
    ) -> Result<Self, SolveError> {
        let t = loader.real()?;
        let (y, ydot) = (loader.slice()?.to_vec(), loader.slice()?.to_vec());
        let mut solver = Self::new(system, Start { t, y, ydot }, t_end, settings)?;
        solver.h = loader.real()?;
        solver.grid = (loader.real()?, loader.count()?);
        solver.has_last = loader.flag()?;
        solver.last.load(loader)?;
        solver.n_failed = loader.count()?;
        solver.stats = loader.stats()?;
        solver.order.load(loader)?;
        let Self { stepper, controller, settings, system, .. } = &mut solver;
        controller.load(loader)?;
        stepper.load(loader, system, settings)?;
        let s = stepper.tableau().s;
        controller.set_exponent(s, max_iterations(settings, s));
        Ok(solver)
    }
}
