//! Why a sweep could not be done.

use std::io;
use std::path::{Path, PathBuf};

use bksim::Rejected;
use bksim::model::diagnostic::Diagnostic;

/// Why a sweep could not be done; faults of single cases are rows instead.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// The model, or what is asked of it, makes no sense.
    #[error(transparent)]
    Rejected(#[from] Rejected),
    /// A file cannot be read or written.
    #[error("`{}`: {error}", .path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
    /// A table cannot be read or written.
    #[error("`{}`: {error}", .path.display())]
    Table {
        /// Which.
        path: PathBuf,
        /// Why.
        error: parquet::errors::ParquetError,
    },
    /// No threads could be started.
    #[error("no threads could be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

impl SweepError {
    pub(crate) fn file(path: &Path) -> impl Fn(io::Error) -> Self {
        move |error| Self::File { path: path.to_owned(), error }
    }

    pub(crate) fn table(path: &Path) -> impl Fn(parquet::errors::ParquetError) -> Self {
        move |error| Self::Table { path: path.to_owned(), error }
    }
}

impl From<Diagnostic> for SweepError {
    fn from(fault: Diagnostic) -> Self {
        Self::Rejected(Rejected(vec![fault]))
    }
}
