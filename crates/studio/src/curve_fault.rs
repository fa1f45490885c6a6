//! Faults of curves that are to be laid over a picture.

use std::path::Path;

use bksim::analysis::AnalysisError;
use bksim_cli::exit::Failure;
use bksim_cli::source::Text;

/// Why there is no curve of the motion in a file.
pub(crate) fn no_curve(path: &Path, error: &AnalysisError) -> Failure {
    Text::new(path.to_owned(), String::new()).rejected(error.diagnostics()).into()
}
