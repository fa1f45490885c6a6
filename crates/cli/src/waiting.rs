//! [`waiting`]: a word on a terminal about work that takes long, for as long as it does. Signals end it at once, also where
//! the command watches for them itself.

use std::io::{self, IsTerminal};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::progress::is_watching;
use crate::quiet::is_quiet;

/// Time after which a person wants to know.
const PATIENCE: Duration = Duration::from_secs(1);

/// Time between two looks at the wish to stop.
const LOOK: Duration = Duration::from_millis(50);

/// True while some work is reported: its parts are not reported again.
static IS_SPOKEN_OF: AtomicBool = AtomicBool::new(false);

/// The words of some work about itself while it is done.
pub struct Word<'a> {
    what: &'a str,
    bar: &'a ProgressBar,
    has_answer: AtomicBool,
}

impl Word<'_> {
    /// Says how far the work is: in words, and as a share of it where that is known.
    pub fn reached(&self, words: &str, share: f64) {
        let share = if share > 0.0 { format!(", {:.0} %", 100.0 * share) } else { String::new() };
        self.bar.set_message(format!("{}, {words}{share}", self.what));
    }

    /// From now on the work has an answer when it is stopped: signals are left to it.
    pub fn keeps(&self) {
        self.has_answer.store(true, Ordering::Relaxed);
    }
}

/// Does the work; after a second, a terminal says what is being done, and for how long. Where the command watches for
/// signals, they end the process here: work like this has no part that could be kept.
pub fn waiting<T>(what: &str, work: impl FnOnce() -> T) -> T {
    searching(what, |_| work())
}

/// Does the work as [`waiting`] does; the work says how far it is, and whether it has an answer already when it is stopped.
pub fn searching<T>(what: &str, work: impl FnOnce(&Word<'_>) -> T) -> T {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
    bar.set_message(what.to_owned());
    let word = Word { what, bar: &bar, has_answer: AtomicBool::new(false) };
    let speaks = !is_quiet() && io::stderr().is_terminal();
    if (!speaks && !is_watching()) || IS_SPOKEN_OF.swap(true, Ordering::Relaxed) {
        return work(&word);
    }
    let begin = || {
        if let Ok(style) = ProgressStyle::with_template("  {msg}  {elapsed}") {
            bar.set_style(style);
        }
        if speaks {
            bar.set_draw_target(ProgressDrawTarget::stderr_with_hz(10));
        }
        bar.enable_steady_tick(Duration::from_millis(200));
    };
    let look = || {
        if !word.has_answer.load(Ordering::Relaxed) {
            leave_if_wished();
        }
    };
    let result = watched(PATIENCE, || work(&word), begin, |()| bar.finish_and_clear(), look);
    IS_SPOKEN_OF.store(false, Ordering::Relaxed);
    result
}

/// Ends the process if a signal has asked for it.
fn leave_if_wished() {
    #[cfg(unix)]
    if let Some(status) = crate::progress::wished() {
        let is_termination = status == crate::exit::Status::Terminated;
        let signal =
            if is_termination { signal_hook::consts::SIGTERM } else { signal_hook::consts::SIGINT };
        crate::unfinished::leave(signal);
    }
}

/// Does the work; `begin` is called from another thread after `patience`, and `end` with its result when the work is done,
/// `look` now and then all the while.
fn watched<T, B>(
    patience: Duration,
    work: impl FnOnce() -> T,
    begin: impl FnOnce() -> B + Send,
    end: impl FnOnce(B) + Send,
    look: impl Fn() + Send,
) -> T {
    thread::scope(|scope| {
        // Dropped when the work is done, or has panicked.
        let (done, wait) = channel::<()>();
        scope.spawn(move || {
            let since = Instant::now();
            let (mut begin, mut begun) = (Some(begin), None);
            // Nothing is ever sent.
            while wait.recv_timeout(LOOK.min(patience)) == Err(RecvTimeoutError::Timeout) {
                look();
                if since.elapsed() >= patience
                    && let Some(begin) = begin.take()
                {
                    begun = Some(begin());
                }
            }
            if let Some(begun) = begun {
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
            let [n_calls, n_looks] = [0, 0].map(AtomicUsize::new);
            let call = || n_calls.fetch_add(1, Ordering::Relaxed);
            let work = || thread::sleep(Duration::from_millis(150));
            let look = || {
                n_looks.fetch_add(1, Ordering::Relaxed);
            };
            let end = |_| {
                call();
            };
            watched(patience, work, call, end, look);
            assert!(n_looks.load(Ordering::Relaxed) > 0, "looks at signals while it works");
            assert_eq!(n_calls.load(Ordering::Relaxed), expected, "{patience:?}");
        }
    }
}
