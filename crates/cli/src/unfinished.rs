//! Files that are not whole yet: a signal that ends the command removes them.
//!
//! A command that watches for signals itself, as [`StopWish`](crate::progress::StopWish) does, ends by itself,
//! and cleans up on its way.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, Once, PoisonError};
use std::{fs, io};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use signal_hook::low_level::emulate_default_handler;
use tempfile::NamedTempFile;

/// The files.
static FILES: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());
/// Whether the command watches for signals itself.
static IS_WATCHED: AtomicBool = AtomicBool::new(false);

/// Leaves signals to the command from now on.
pub(crate) fn leave_to_command() {
    IS_WATCHED.store(true, Ordering::Relaxed);
}

/// Makes a file that is removed when a signal ends the command, however soon that comes; where signals cannot
/// be handled, it stays.
///
/// # Errors
/// Those of `create`.
pub(crate) fn guarded(
    create: impl FnOnce() -> io::Result<NamedTempFile>,
) -> io::Result<NamedTempFile> {
    static LISTENING: Once = Once::new();
    LISTENING.call_once(|| {
        if !IS_WATCHED.load(Ordering::Relaxed)
            && let Ok(mut signals) = Signals::new([SIGHUP, SIGINT, SIGTERM])
        {
            std::thread::spawn(move || signals.forever().for_each(end));
        }
    });
    // Held while the file is made: a signal waits for its name.
    let mut files = FILES.lock().unwrap_or_else(PoisonError::into_inner);
    let file = create()?;
    files.push(file.path().to_owned());
    Ok(file)
}

/// Takes back [`guarded`]: the file has its name.
pub(crate) fn release(path: &Path) {
    FILES.lock().unwrap_or_else(PoisonError::into_inner).retain(|known| known != path);
}

/// Removes the files and ends as the signal would have.
fn end(signal: i32) {
    if !IS_WATCHED.load(Ordering::Relaxed) {
        leave(signal);
    }
}

/// Removes the files and ends the process as the signal would.
pub(crate) fn leave(signal: i32) {
    for path in FILES.lock().unwrap_or_else(PoisonError::into_inner).iter() {
        // What is gone already is no fault.
        let _ = fs::remove_file(path);
    }
    let _ = emulate_default_handler(signal);
}
