//! Runs of simulations that share their equations, with their steps taken together.

use super::Simulation;
use crate::run::{self, Failure, Observer, Problem, Summary};
use crate::start::Start;

impl Simulation {
    /// Runs up to [`ensemble_size`](run::ensemble_size) simulations, each from its start and with its observer, as [`Simulation::run`] does one, bit for
    /// bit. Those that share their equations, as clones do, take their steps together, in the lanes of registers.
    ///
    /// # Errors
    /// Of each run its [`Failure`], as of [`Simulation::run`].
    ///
    /// # Panics
    /// When there are more than that.
    pub fn run_together<O: Observer>(
        members: &[(&Self, &Start)],
        observers: &mut [O],
        stop: &dyn Fn() -> bool,
    ) -> Vec<Result<Summary, Box<Failure>>> {
        let fresh: Vec<_> =
            members.iter().map(|(simulation, start)| simulation.beginning(start)).collect();
        // One that does not begin leaves the others by themselves.
        if fresh.iter().any(Result::is_err) {
            let alone = members.iter().zip(observers);
            return alone
                .map(|((simulation, start), observer)| simulation.run(start, observer, stop))
                .collect();
        }
        let starts = fresh.iter().flatten();
        let problems: Vec<Problem<'_>> = members
            .iter()
            .zip(starts)
            .map(|((simulation, _), start)| simulation.problem(start))
            .collect();
        run::run_together(&problems, observers, stop)
    }
}
