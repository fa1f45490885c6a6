//! [`BenchError`]: faults that end a benchmark early. A missing peer is none: the report notes it.

use std::path::{Path, PathBuf};

/// Error of a benchmark.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum BenchError {
    /// A file could not be read or written.
    #[error("cannot use `{}`: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// A model of the suite was refused.
    #[error("the model `{name}` was refused: {message}")]
    Model {
        /// Name of the model.
        name: String,
        /// First diagnostic.
        message: String,
    },
    /// A data file of the suite has unexpected contents.
    #[error("benchmark data: {0}")]
    Data(&'static str),
    /// A problem that does not exist was requested.
    #[error("there is no problem `{0}`")]
    UnknownProblem(String),
    /// Two programs disagree on numbers that should be equal.
    #[error("`{who}` computes {found} where {expected} is expected ({what})")]
    Disagreement {
        /// The other program.
        who: String,
        /// Description of the number.
        what: String,
        /// Number found.
        found: f64,
        /// Our number.
        expected: f64,
    },
}

impl BenchError {
    /// A fault of the file at `path`.
    pub(crate) fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Io { path: path.to_owned(), source }
    }
}
