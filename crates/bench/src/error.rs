//! What can end a benchmark early. A missing peer does not: it is noted in the report.

use std::path::{Path, PathBuf};

use bksim_expr::{EvalError, ParseError, TapeError};

/// Why a benchmark has no result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum BenchError {
    /// A file could not be read or written.
    #[error("cannot use `{}`: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
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
    /// An expression of the suite was refused.
    #[error(transparent)]
    Parse(#[from] ParseError),
    /// Outputs could not be compiled.
    #[error(transparent)]
    Tape(#[from] TapeError),
    /// An expression has no value.
    #[error(transparent)]
    Eval(#[from] EvalError),
    /// A data file of the suite is not what was expected.
    #[error("benchmark data: {0}")]
    Data(&'static str),
    /// A problem that does not exist was asked for.
    #[error("there is no problem `{0}`")]
    UnknownProblem(String),
    /// Two programs disagree on numbers that should be equal.
    #[error("`{who}` computes {found} where {expected} is expected ({what})")]
    Disagreement {
        /// Who is wrong.
        who: String,
        /// Which number.
        what: String,
        /// What it computed.
        found: f64,
        /// What we computed.
        expected: f64,
    },
}

impl BenchError {
    /// A fault of the file at `path`.
    pub(crate) fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Io { path: path.to_owned(), source }
    }
}
