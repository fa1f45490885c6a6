//! The loss of the display server while a window is open, which the library for windows answers by a panic.

use std::panic::{self, AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::WindowError;

/// The library for windows, as paths of its source have it.
const LIBRARY: &str = "winit-";

/// Does the work of a window; a panic in the library for windows is an error, and any other goes on.
///
/// # Errors
/// [`WindowError::Lost`].
pub(super) fn guarded<T>(work: impl FnOnce() -> T) -> Result<T, WindowError> {
    let is_lost = Arc::new(AtomicBool::new(false));
    let noted = Arc::clone(&is_lost);
    let before: Arc<dyn Fn(&panic::PanicHookInfo<'_>) + Send + Sync> =
        Arc::from(panic::take_hook());
    let usual = Arc::clone(&before);
    panic::set_hook(Box::new(move |panic| {
        if panic.location().is_some_and(|place| place.file().contains(LIBRARY)) {
            noted.store(true, Ordering::Relaxed);
        } else {
            usual(panic);
        }
    }));
    let result = catch_unwind(AssertUnwindSafe(work));
    panic::set_hook(Box::new(move |panic| before(panic)));
    match result {
        Ok(done) => Ok(done),
        Err(_) if is_lost.load(Ordering::Relaxed) => Err(WindowError::Lost),
        Err(panic) => resume_unwind(panic),
    }
}
