//! The printed answer of a command in a file in place of standard output: `-o FILE` of commands that answer in text.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::exit::Failure;
use crate::output::{capture, report};
use crate::output_file::OutputFile;

/// Whether the file is this process's own, to be replaced when the command is done again.
static IS_OWN: AtomicBool = AtomicBool::new(false);

/// Runs a command whose text goes into a file; `inputs` are the files that it reads.
///
/// # Errors
/// Those of the command, and a file that cannot be written.
pub(crate) fn into_file(
    (path, force): (&Path, bool),
    inputs: &[PathBuf],
    run: impl FnOnce() -> Result<u8, Failure>,
) -> Result<u8, Failure> {
    let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
    let may_be_replaced = force || IS_OWN.load(Ordering::Relaxed);
    let file = OutputFile::plan(path, ("input", &inputs), may_be_replaced, "nothing was written")?;
    let (status, content) = capture(run);
    let status = status?;
    let mut out = file.create()?;
    out.write_all(content.as_bytes()).map_err(|e| Failure::writing(path, &e))?;
    out.finish()?;
    IS_OWN.store(true, Ordering::Relaxed);
    report(&format!("wrote {}", path.display()))?;
    Ok(status)
}
