//! Files that take the place of others once they are whole.

use std::fmt::Display;
use std::io::{BufWriter, Write};
use std::path::Path;

use bksim_studio::output_file::Written;

use crate::fault::Fault;

/// Writes a file next to its path, and renames it; what is not whole is taken away.
pub(crate) fn replace(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<Written>) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let mut out = BufWriter::new(Written::replacing(path).map_err(|e| unwritten(path, &e))?);
    write(&mut out)?;
    out.flush().map_err(|e| unwritten(path, &e))?;
    let written = out.into_inner().map_err(|e| unwritten(path, e.error()))?;
    written.persist().map_err(|e| unwritten(path, &e))
}

/// A file that cannot be written.
pub(crate) fn unwritten(path: &Path, why: &dyn Display) -> Fault {
    Fault::File(format!("cannot write {}: {why}", path.display()))
}
