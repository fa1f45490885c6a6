//! [`Watch`]: notices when files change, however an editor saves them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use notify::{Event, EventKind, RecommendedWatcher, RecursiveMode, Watcher};

/// Watches the directories of files: one that is replaced by another of its name is still noticed.
pub(super) struct Watch {
    watcher: RecommendedWatcher,
    files: Arc<Mutex<BTreeSet<PathBuf>>>,
    directories: BTreeSet<PathBuf>,
}

impl Watch {
    /// Watches nothing yet; `on_change` is called on a thread of its own.
    pub(super) fn new(on_change: impl Fn() + Send + 'static) -> notify::Result<Self> {
        let files: Arc<Mutex<BTreeSet<PathBuf>>> = Arc::default();
        let wanted = Arc::clone(&files);
        let watcher = notify::recommended_watcher(move |event: notify::Result<Event>| {
            let Ok(event) = event else { return };
            let wanted = wanted.lock().unwrap_or_else(PoisonError::into_inner);
            if is_change(event.kind) && event.paths.iter().any(|path| wanted.contains(path)) {
                on_change();
            }
        })?;
        Ok(Self { watcher, files, directories: BTreeSet::new() })
    }

    /// Watches these files and no others. What cannot be watched is passed over.
    pub(super) fn set_files(&mut self, files: &[PathBuf]) {
        let places: BTreeSet<PathBuf> = files.iter().flat_map(|file| places(file)).collect();
        let parents = places.iter().filter_map(|place| place.parent()).map(Path::to_owned);
        let parents: BTreeSet<PathBuf> = parents.collect();
        *self.files.lock().unwrap_or_else(PoisonError::into_inner) = places;
        for gone in self.directories.difference(&parents) {
            let _ = self.watcher.unwatch(gone);
        }
        for new in parents.difference(&self.directories) {
            let _ = self.watcher.watch(new, RecursiveMode::NonRecursive);
        }
        self.directories = parents;
    }
}

/// Where a file is: under its own name, and where that leads to if it is a link.
fn places(file: &Path) -> Vec<PathBuf> {
    let directory = match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let named = directory.canonicalize().ok().zip(file.file_name());
    let named = named.map(|(directory, name)| directory.join(name));
    named.into_iter().chain(file.canonicalize()).collect()
}

/// Whether something else may be in the file afterwards; reading it is no change.
fn is_change(kind: EventKind) -> bool {
    matches!(
        kind,
        EventKind::Any | EventKind::Create(_) | EventKind::Modify(_) | EventKind::Remove(_)
    )
}
