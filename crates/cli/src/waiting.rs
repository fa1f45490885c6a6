//! [`waiting`]: a word on a terminal about work that takes long, for as long as it does.

use std::io::{self, IsTerminal};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::quiet::is_quiet;

/// Time after which a person wants to know.
const PATIENCE: Duration = Duration::from_secs(1);

/// Does the work; after a second, a terminal says what is being done, and for how long.
pub fn waiting<T>(what: &str, work: impl FnOnce() -> T) -> T {
    if is_quiet() || !io::stderr().is_terminal() {
        return work();
    }
    let bar = || {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
        if let Ok(style) = ProgressStyle::with_template("  {msg}  {elapsed}") {
            bar.set_style(style);
        }
        bar.set_message(what.to_owned());
        bar.with_elapsed(PATIENCE)
    };
    watched(
        PATIENCE,
        work,
        || {
            let bar = bar();
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        },
        |bar| bar.finish_and_clear(),
    )
}

/// Does the work; `begin` is called from another thread after `patience`, and `end` with its result when the work is done.
fn watched<T, B>(
    patience: Duration,
    work: impl FnOnce() -> T,
    begin: impl FnOnce() -> B + Send,
    end: impl FnOnce(B) + Send,
) -> T {
    thread::scope(|scope| {
        // Dropped when the work is done, or has panicked.
        let (done, wait) = channel::<()>();
        scope.spawn(move || {
            if wait.recv_timeout(patience) == Err(RecvTimeoutError::Timeout) {
                let begun = begin();
                // Nothing is ever sent.
                let _ = wait.recv();
                end(begun);
            }
        });
        let result = work();
        drop(done);
        result
    })
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[test]
    fn only_work_that_takes_long_is_spoken_of_and_only_while_it_does() {
        for (patience, expected) in [(Duration::from_mins(1), 0), (Duration::ZERO, 2)] {
            let n_calls = AtomicUsize::new(0);
            let call = || n_calls.fetch_add(1, Ordering::Relaxed);
            let work = || thread::sleep(Duration::from_millis(50));
            watched(patience, work, call, |_| {
                call();
            });
            assert_eq!(n_calls.load(Ordering::Relaxed), expected, "{patience:?}");
        }
    }
}
