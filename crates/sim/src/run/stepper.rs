//! [`Stepper`]: a method of integration, as the loop over the steps of a run uses it.

use bksim_dae::{Advance, Method, Noise, Saver, SolveError, Standstill, Stats, Step, StepSpan};

use super::dense::DenseOutput;
use super::ending::PhaseEnd;
use super::singular::{Sighting, SingularMonitor};
use crate::evaluator::Evaluator;
use crate::multiplier::MultiplierSystem;
use crate::state::State;
use crate::whole_step::PendingStep;

/// A method that integrates the mechanism in one set of modes.
///
/// The loop calls the methods below in their order, for every step. Explicit steps and those of
/// Radau IIA differ in which of the questions they have an answer to.
pub(super) trait Stepper: Send + Sync {
    /// Takes one accepted step, or, where attempts are taken together with those of other runs, tries one.
    ///
    /// # Errors
    /// [`SolveError`] when the integrator cannot go on.
    fn advance(&mut self) -> Result<Advance, SolveError>;

    /// The step that [`Stepper::advance`] tries next, where it may be taken together with those of other runs.
    fn pending(&self) -> Option<PendingStep<'_>> {
        None
    }

    /// Room for the results of the step that was [pending](Stepper::pending).
    fn room_for(&mut self, _span: StepSpan) -> Option<&mut Vec<f64>> {
        None
    }

    /// The step just taken, with its dense output.
    ///
    /// # Errors
    /// [`SolveError`] when the dense output, made only here, meets a state without a value.
    fn last_step(&mut self) -> Result<Step<'_>, SolveError>;

    /// Looks at the step just taken; true when it meets a singular pose that this method cannot
    /// cross.
    fn is_singular_ahead(&mut self, evaluator: &mut Evaluator<'_>) -> bool;

    /// Searches the step just taken for a singular pose that it has crossed.
    ///
    /// # Errors
    /// [`SolveError`] as [`Stepper::last_step`].
    fn crossed_singular_pose(
        &mut self,
        evaluator: &mut Evaluator<'_>,
        monitor: &mut SingularMonitor,
    ) -> Result<Option<Sighting>, SolveError>;

    /// The motion over the step just taken.
    ///
    /// # Errors
    /// [`SolveError`] as [`Stepper::last_step`].
    fn dense_output(&mut self) -> Result<DenseOutput<'_>, SolveError>;

    /// Puts the end of the step back onto the constraints where the method drifts away from them.
    ///
    /// # Errors
    /// [`SolveError`] when the corrected state is not finite.
    fn correct(
        &mut self,
        evaluator: &mut Evaluator<'_>,
        reached: &mut State,
    ) -> Result<(), SolveError>;

    /// Why another method had better go on from the end of the step.
    fn succession(&mut self) -> Option<PhaseEnd>;

    /// `h ρ` of the step just taken, which stability limits to about six, or zero where it limits nothing.
    fn stability(&self) -> f64;

    /// Repeated steps whose error has not fallen with their size, in this phase.
    fn noise(&self) -> Noise;

    /// Where it stands, with the unknowns whose errors keep its steps small.
    fn account(&self) -> Standstill;

    /// Time reached, s.
    fn t(&self) -> f64;

    /// The unknowns there, q and v before all others.
    fn y(&self) -> &[f64];

    /// Work of loads and drives up to there, J, where it is one of the unknowns; otherwise it takes
    /// the dense output of every step to follow it.
    fn work(&self) -> Option<f64>;

    /// Estimated error of the work over the step just taken, J.
    fn work_error(&self) -> f64 {
        0.0
    }

    /// Power at the end of it, W, where the work is one of the unknowns.
    fn power(&self) -> f64 {
        0.0
    }

    /// Replaces the work, where it is one of the unknowns, by a closer value.
    fn set_work(&mut self, _work: f64) {}

    /// Counters of this phase.
    fn stats(&self) -> &Stats;

    /// The multiplier system, with the pivots that it has met.
    fn multipliers(&mut self) -> &MultiplierSystem;

    /// The solver, as checkpoints name it.
    fn method(&self) -> Method;

    /// Saves what a stepper goes on from; monitors of events are saved elsewhere.
    fn save(&mut self, saver: &mut Saver);
}
