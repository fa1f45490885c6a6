//! Files that a killed command has left: `.press.mcap.Xy12.part` next to `press.mcap`.
//!
//! A command holds a lock on what it writes under such a name. A file of that name without a lock is nobody's any more: it
//! is named by the next command that writes in its place, and stays, as it may be all that is left of a long run.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

use crate::render;

/// The ending of files that are not whole yet.
pub(crate) const PART: &str = ".part";
/// Most entries of a folder that are looked at, and most files that are named.
const MOST_ENTRIES: usize = 10_000;
const MOST_NAMED: usize = 3;

/// The beginning of the names of files that become `path`.
pub(crate) fn prefix_of(path: &Path) -> String {
    format!(".{}.", path.file_name().unwrap_or_default().to_string_lossy())
}

/// Locks a file that is being written; where files have no locks, it goes without.
pub(crate) fn lock(file: &File) {
    let _ = file.try_lock();
}

/// Names what killed commands have left of `path`, on stderr.
pub(crate) fn name_all(folder: &Path, path: &Path) {
    let found = found(folder, path);
    for left in found.iter().take(MOST_NAMED) {
        let size = fs::metadata(left).map_or(0, |known| known.len());
        let name = left.display();
        let is_log = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"));
        let way_out = if is_log {
            format!("`bksim solve --resume {name}` may go on from it; else delete it")
        } else {
            "delete it".to_owned()
        };
        render::warning(&format!(
            "`{name}` ({size} bytes) is what a command left that was killed: {way_out}"
        ));
    }
    if found.len() > MOST_NAMED {
        let n = found.len() - MOST_NAMED;
        render::warning(&format!("{n} more files end in `{PART}` and are left like that"));
    }
}

/// The files that were left, by name.
fn found(folder: &Path, path: &Path) -> Vec<PathBuf> {
    let prefix = prefix_of(path);
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let names = entries.take(MOST_ENTRIES).filter_map(|entry| Some(entry.ok()?.file_name()));
    let mut found: Vec<PathBuf> = names
        .filter(|name| {
            let name = name.to_string_lossy();
            name.starts_with(&prefix) && name.ends_with(PART)
        })
        .map(|name| if folder == Path::new(".") { name.into() } else { folder.join(name) })
        .filter(|left| is_abandoned(left))
        .collect();
    found.sort_unstable();
    found
}

/// True of a file that nobody writes any more.
fn is_abandoned(path: &Path) -> bool {
    // Opened for writing: some systems lock nothing else. A pipe would wait for a reader.
    let is_file = fs::symlink_metadata(path).is_ok_and(|known| known.is_file());
    let Ok(file) = File::options().append(true).open(path) else { return false };
    is_file && !matches!(file.try_lock(), Err(TryLockError::WouldBlock | TryLockError::Error(_)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_nobody_holds_is_left_and_what_is_being_written_is_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("run.mcap");
        for name in [".run.mcap.a.part", ".run.mcap.b.part", ".other.mcap.c.part", "run.mcap.part"]
        {
            fs::write(folder.path().join(name), "some").expect("written");
        }
        let held = folder.path().join(".run.mcap.b.part");
        let held = File::options().append(true).open(held).expect("a file");
        lock(&held);
        assert_eq!(found(folder.path(), &path), [folder.path().join(".run.mcap.a.part")]);
        drop(held);
        assert_eq!(found(folder.path(), &path).len(), 2);
    }
}
