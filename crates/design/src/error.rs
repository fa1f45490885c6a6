//! [`DesignError`]: why a question of design has no answer.

use bksim::Rejected;
use bksim::analysis::AnalysisError;
use bksim::model::diagnostic::{Code, Diagnostic};
use bksim_sweep::SweepError;

/// Why a question of design has no answer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DesignError {
    /// The model or the question is refused.
    #[error(transparent)]
    Rejected(#[from] Rejected),
    /// Threads could not be started.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// Stopped before there was anything to keep.
    #[error("stopped before there was a result")]
    Stopped,
}

impl DesignError {
    /// The faults of a model or question; none of the rest.
    pub fn diagnostics(&self) -> Vec<Diagnostic> {
        match self {
            Self::Rejected(Rejected(faults)) => faults.clone(),
            _ => Vec::new(),
        }
    }

    /// One fault with its cure.
    pub(crate) fn fault(code: Code, message: impl Into<String>, help: impl Into<String>) -> Self {
        Diagnostic::error(code, message).help(help).into()
    }
}

impl From<Diagnostic> for DesignError {
    fn from(fault: Diagnostic) -> Self {
        Self::Rejected(Rejected(vec![fault]))
    }
}

impl From<AnalysisError> for DesignError {
    fn from(error: AnalysisError) -> Self {
        Self::Rejected(Rejected(error.diagnostics()))
    }
}
