//! Work under Python that goes on for long: now and then Python is asked whether it may, so that Ctrl-C
//! ends it, and the person who waits sees how far it is.

use std::cell::{Cell, RefCell};
use std::time::{Duration, Instant};

use pyo3::prelude::*;

/// How often Python is asked whether to go on: Ctrl-C is to work within a fifth of a second.
pub(crate) const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Asks Python whether work may go on, and keeps what it raises.
pub(crate) struct Interruption<'a> {
    /// Told how far the work is.
    notify: Option<&'a Py<PyAny>>,
    pace: Pace,
    raised: RefCell<Option<PyErr>>,
}

/// Tells when [`LOOK_EVERY`] has gone by. It is asked at every step, which may take less than to ask
/// the clock: as long as many calls fit, most go by without.
struct Pace {
    /// When the clock was asked last.
    asked: Cell<Instant>,
    /// When it was time last.
    due: Cell<Instant>,
    /// Calls between two questions, and those that are left.
    stride: Cell<u32>,
    left: Cell<u32>,
}

impl<'a> Interruption<'a> {
    /// Nothing is raised yet; `notify` is told how far the work is.
    pub(crate) fn new(notify: Option<&'a Py<PyAny>>) -> Self {
        Self { notify, pace: Pace::begin(), raised: RefCell::new(None) }
    }

    /// True when work that has got to `reached` is to stop.
    pub(crate) fn is_wished(&self, reached: f64) -> bool {
        if !self.pace.is_due() {
            return false;
        }
        let heard = Python::attach(|py| {
            py.check_signals()?;
            self.notify.map_or(Ok(()), |notify| notify.call1(py, (reached,)).map(drop))
        });
        let is_wished = heard.is_err();
        if let Err(error) = heard {
            self.raised.replace(Some(error));
        }
        is_wished
    }

    /// The exception that has stopped the work, if one has.
    pub(crate) fn raised(&self) -> Option<PyErr> {
        self.raised.take()
    }
}

impl Pace {
    /// Limit by which steps that suddenly are slow cost no more than as many.
    const LONGEST: u32 = 32;

    fn begin() -> Self {
        let now = Instant::now();
        let [asked, due] = [now; 2].map(Cell::new);
        Self { asked, due, stride: Cell::new(1), left: Cell::new(0) }
    }

    fn is_due(&self) -> bool {
        if let Some(left) = self.left.get().checked_sub(1) {
            self.left.set(left);
            return false;
        }
        let now = Instant::now();
        let taken = now.duration_since(self.asked.replace(now));
        let stride = self.stride.get();
        let stride = if taken < LOOK_EVERY / 16 { stride * 2 } else { stride / 4 };
        self.stride.set(stride.clamp(1, Self::LONGEST));
        self.left.set(self.stride.get() - 1);
        let is_due = now.duration_since(self.due.get()) >= LOOK_EVERY;
        if is_due {
            self.due.set(now);
        }
        is_due
    }
}
