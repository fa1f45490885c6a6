//! Progress of a run, on stderr and only on a terminal; and the wish to stop it.

use std::io::{self, IsTerminal};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::exit::Status;
use crate::quiet::is_quiet;

/// How a run was asked to end.
const INTERRUPT: usize = 1;
const TERMINATE: usize = 2;

/// The wish of this process, from when it first watches for signals.
static WISH: OnceLock<StopWish> = OnceLock::new();

/// True where this process watches for signals.
pub(crate) fn is_watching() -> bool {
    WISH.get().is_some()
}

/// The status to end with, if this process watches for signals and one has come.
#[cfg(unix)]
pub(crate) fn wished() -> Option<Status> {
    WISH.get().and_then(StopWish::status)
}

/// The wish to stop: an interrupt or a termination signal, remembered until the next sample.
#[derive(Clone, Debug, Default)]
pub struct StopWish(Arc<AtomicUsize>);

impl StopWish {
    /// Takes over both signals for the rest of the process; where a file may not grow further, writing
    /// fails instead of the process.
    ///
    /// # Errors
    /// The system does not let signals be handled.
    pub fn watch() -> io::Result<Self> {
        #[cfg(unix)]
        crate::unfinished::leave_to_command();
        let wish = Self::default();
        flag::register_usize(SIGINT, Arc::clone(&wish.0), INTERRUPT)?;
        flag::register_usize(SIGTERM, Arc::clone(&wish.0), TERMINATE)?;
        #[cfg(unix)]
        flag::register(signal_hook::consts::SIGXFSZ, Arc::default())?;
        // A later one hears of the same signals.
        WISH.get_or_init(|| wish.clone());
        Ok(wish)
    }

    /// The status to end with, if a signal has come.
    pub fn status(&self) -> Option<Status> {
        match self.0.load(Ordering::Relaxed) {
            0 => None,
            TERMINATE => Some(Status::Terminated),
            _ => Some(Status::Interrupted),
        }
    }
}

/// A bar over simulated time.
pub struct Progress {
    bar: ProgressBar,
    t_start: f64,
    t_end: f64,
}

/// Parts of the bar.
const PARTS: f64 = 10_000.0;

impl Progress {
    /// A bar for solving from `t_start` to `t_end`, hidden unless stderr is a terminal.
    pub fn new(t_start: f64, t_end: f64) -> Self {
        Self::of("solving", t_start, t_end)
    }

    /// A bar for work of this name.
    pub fn of(work: &str, t_start: f64, t_end: f64) -> Self {
        let bar = ProgressBar::new(10_000);
        let template = format!("  {work}  {{bar:40}}  {{msg}}  {{eta}} left");
        let style = ProgressStyle::with_template(&template);
        if let Ok(style) = style {
            bar.set_style(style);
        }
        bar.set_draw_target(if io::stderr().is_terminal() && !is_quiet() {
            ProgressDrawTarget::stderr_with_hz(10)
        } else {
            ProgressDrawTarget::hidden()
        });
        Self { bar, t_start, t_end }
    }

    /// Shows that `t` is reached.
    pub fn reached(&self, t: f64) {
        if self.bar.is_hidden() {
            return;
        }
        let part = ((t - self.t_start) / (self.t_end - self.t_start)).clamp(0.0, 1.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0..=10000")]
        self.bar.set_position((part * PARTS) as u64);
        self.bar.set_message(format!("t = {t:.4} s"));
    }

    /// Shows that so many of all cases have ended.
    #[expect(clippy::cast_precision_loss, reason = "fewer than 2^53 cases")]
    pub fn ended(&self, n_ended: u64, n_cases: u64) {
        if self.bar.is_hidden() {
            return;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0..=10000")]
        self.bar.set_position((n_ended as f64 / n_cases as f64 * PARTS) as u64);
        self.bar.set_message(format!("{n_ended} of {n_cases} cases"));
    }

    /// Does something that prints, with the bar out of the way.
    pub fn aside(&self, print: impl FnOnce()) {
        self.bar.suspend(print);
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
