//! Files that take the place of others once they are whole.

use std::fmt::Display;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::fault::Fault;

/// Writes a file next to its path, and renames it; what is not whole is taken away.
pub(crate) fn replace(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let mut temporary = path.as_os_str().to_owned();
    temporary.push(".part");
    let temporary = PathBuf::from(temporary);
    let file = File::create(&temporary).map_err(|e| unwritten(path, &e))?;
    let mut out = BufWriter::new(file);
    let written = write(&mut out).and_then(|()| out.flush().map_err(|e| unwritten(path, &e)));
    // Some systems move no file that is open.
    drop(out);
    let whole =
        written.and_then(|()| fs::rename(&temporary, path).map_err(|e| unwritten(path, &e)));
    if whole.is_err() {
        // What is left of it is of no use to anybody.
        let _ = fs::remove_file(&temporary);
    }
    whole
}

/// A file that cannot be written.
pub(crate) fn unwritten(path: &Path, why: &dyn Display) -> Fault {
    Fault::File(format!("cannot write {}: {why}", path.display()))
}
