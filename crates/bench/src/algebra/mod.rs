//! The algebra against its peers.

mod andrews;
mod chain;
mod counts;
mod derivation;
mod evaluation;
mod folding;
mod generated;
mod gradient;
mod systems;
mod work;

use clap::ValueEnum;

use crate::context::Context;
use crate::error::BenchError;
use crate::report::Report;

/// The suites, in the order they are run.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum, Debug)]
pub(crate) enum AlgebraSuite {
    /// Trigonometric identities: cost and time of simplification.
    Folding,
    /// Operation counts of equations of motion.
    Counts,
    /// Time to derive the equations of a chain.
    Derivation,
    /// Reverse mode on a large expression.
    Gradient,
    /// Time of residual and Jacobian at one point.
    Evaluation,
    /// Functions of `bksim code` as C: size, and time of a call.
    Generated,
}

/// The chosen suites; all of them if none is.
pub(crate) fn chosen(suites: &[AlgebraSuite]) -> &[AlgebraSuite] {
    if suites.is_empty() { AlgebraSuite::value_variants() } else { suites }
}

impl AlgebraSuite {
    /// Measures one suite.
    pub(crate) fn run(self, context: &Context) -> Result<Report, BenchError> {
        match self {
            Self::Folding => folding::run(context),
            Self::Counts => counts::run(context),
            Self::Derivation => derivation::run(context),
            Self::Gradient => gradient::run(context),
            Self::Evaluation => evaluation::run(context),
            Self::Generated => generated::run(context),
        }
    }
}
