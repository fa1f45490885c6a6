//! [`Watch`]: notices changes of files, however an editor saves them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use notify::{Event, EventKind, RecommendedWatcher, RecursiveMode, Watcher};

/// Watches the directories of files, so that a file replaced by another of its name is noticed,
/// too.
#[derive(Debug)]
pub struct Watch {
    watcher: RecommendedWatcher,
    files: Arc<Mutex<BTreeSet<PathBuf>>>,
    directories: BTreeSet<PathBuf>,
}

impl Watch {
    /// A watch without files; `on_change` is called on a thread of its own.
    ///
    /// # Errors
    /// A system that notices no changes.
    pub fn new(on_change: impl Fn() + Send + 'static) -> notify::Result<Self> {
        let files: Arc<Mutex<BTreeSet<PathBuf>>> = Arc::default();
        let watched = Arc::clone(&files);
        let watcher = notify::recommended_watcher(move |event: notify::Result<Event>| {
            let Ok(event) = event else { return };
            let watched = watched.lock().unwrap_or_else(PoisonError::into_inner);
            if is_change(event.kind) && event.paths.iter().any(|path| watched.contains(path)) {
                on_change();
            }
        })?;
        Ok(Self { watcher, files, directories: BTreeSet::new() })
    }

    /// Watches these files and no others. Files that cannot be watched are skipped.
    pub fn set_files(&mut self, files: &[PathBuf]) {
        let paths: BTreeSet<PathBuf> = files.iter().flat_map(|file| absolute_paths(file)).collect();
        let parents = paths.iter().filter_map(|path| path.parent()).map(Path::to_owned);
        let parents: BTreeSet<PathBuf> = parents.collect();
        *self.files.lock().unwrap_or_else(PoisonError::into_inner) = paths;
        for gone in self.directories.difference(&parents) {
            let _ = self.watcher.unwatch(gone);
        }
        for new in parents.difference(&self.directories) {
            let _ = self.watcher.watch(new, RecursiveMode::NonRecursive);
        }
        self.directories = parents;
    }
}

/// Absolute paths of a file: under its own name, and of its target if it is a link.
fn absolute_paths(file: &Path) -> Vec<PathBuf> {
    let directory = match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let named = directory.canonicalize().ok().zip(file.file_name());
    let named = named.map(|(directory, name)| directory.join(name));
    named.into_iter().chain(file.canonicalize()).collect()
}

/// True if the file may have other contents afterwards; reading it is no change.
fn is_change(kind: EventKind) -> bool {
    matches!(
        kind,
        EventKind::Any | EventKind::Create(_) | EventKind::Modify(_) | EventKind::Remove(_)
    )
}
