//! [`PageError`]: reasons that there is no page.

use bksim::analysis::AnalysisError;
use bksim::expr::{CodegenError, TapeError};
use bksim::sim::run::Unreplayed;

/// Error of [`page`](crate::page).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PageError {
    /// Node.js was not there when bksim was built.
    #[error("this build of bksim has no page: Node.js was not there when it was built")]
    NotBundled,
    /// File that is no module of a live page.
    #[error("the module of live pages is no WebAssembly")]
    NoModule,
    /// The motion is not that of the mechanism.
    #[error(transparent)]
    Unreplayed(#[from] Unreplayed),
    /// A curve that the mechanism has not, or assemblies that were not found.
    #[error(transparent)]
    Curves(#[from] AnalysisError),
    /// The poses cannot be compiled.
    #[error(transparent)]
    Tape(#[from] TapeError),
    /// The tape of the poses cannot be written as JSON.
    #[error(transparent)]
    Codegen(#[from] CodegenError),
    /// A part of the page cannot be written as JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
}
