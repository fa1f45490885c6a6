//! [`Problem`]: everything that a motion follows from.

use crate::compiled::CompiledSystem;
use crate::formulate::LazyMotionEquations;
use crate::start::Start;
use bksim_model::{Outputs, SolveOptions};

/// Everything that a motion follows from: the mechanism as functions, where it begins, and how to
/// integrate.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// The mechanism as functions of numbers.
    pub compiled: &'a CompiledSystem,
    /// Equations of motion of the problem in the formulation that `options` ask for.
    pub equations: &'a LazyMotionEquations,
    /// The consistent start.
    pub start: &'a Start,
    /// Values of the model's parameters, in their order and without modes.
    pub parameters: &'a [f64],
    /// End, tolerances and method.
    pub options: &'a SolveOptions,
    /// The output times, which are those of `options` unless others are taken.
    pub outputs: &'a Outputs,
}
