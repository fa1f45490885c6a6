//! [`Watch`]: long questions that are followed, and stopped where they take too long.

use bksim_sim::start::Start;
use bksim_sim::{Motion, Simulation};

use crate::error::AnalysisError;

/// Follower of runs.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Is told the name of a run and the time that it has reached, s; the time of its start first.
    pub reached: &'a dyn Fn(&'static str, f64),
    /// True where the run is to be stopped where it is.
    pub stop: &'a dyn Fn() -> bool,
}

impl std::fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Watch").finish_non_exhaustive()
    }
}

impl Watch<'_> {
    /// Runs that nobody follows or stops.
    pub const NONE: Watch<'static> = Watch { reached: &|_, _| (), stop: &|| false };

    /// A run from a start, called `name`, as far as it is let.
    pub(crate) fn run(
        &self,
        name: &'static str,
        simulation: &Simulation,
        start: Start,
    ) -> Result<Motion, AnalysisError> {
        (self.reached)(name, start.t);
        Ok(simulation.solve_watched(start, &mut |t| (self.reached)(name, t), self.stop)?)
    }
}
