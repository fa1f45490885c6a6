//! [`Logging`]: the observer of a run that writes its log, with states from which the run goes on.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use bksim::dae::Control;
use bksim::log::{Level, LogError};
use bksim::record::Recorder;
use bksim::sim::redundancy::UniquenessChange;
use bksim::sim::run::{Observer, RunCheckpoint, Sample, Segment, Slowness};
use bksim::sim::sensitivity::StateSensitivity;

use super::{Prepared, in_log};
use crate::progress::{Progress, StopWish};
use crate::render;

/// Writes a run to its log as it goes on.
pub(super) struct Logging<'a, W: Write> {
    pub(super) log: Recorder<W>,
    pub(super) progress: Progress,
    prepared: &'a Prepared,
    /// True if warnings are printed as they arise.
    is_told: bool,
    stop: &'a StopWish,
    /// When the run is to be saved next.
    next_save: Instant,
    /// Time of the last sample that was written, s.
    pub(super) reached: f64,
    /// Why the log cannot be written any more, and the last time in it.
    pub(super) fault: Option<(f64, LogError)>,
    size: Size,
    /// Time spent here.
    pub(super) taken: Duration,
}

/// The size of a log as it grows.
pub(super) struct Size {
    /// Bytes that have been written.
    pub(super) n_bytes: Arc<AtomicU64>,
    /// Bytes at which the run stops.
    pub(super) limit: u64,
}

impl Size {
    /// True if the log has reached its limit.
    pub(super) fn is_reached(&self) -> bool {
        self.n_bytes.load(Ordering::Relaxed) >= self.limit
    }
}

/// Time between two states in the log from which a run that was killed goes on.
const SAVE_INTERVAL: Duration = Duration::from_millis(125);
/// Bytes of such states in a second: more would make the log larger than the samples do.
const SAVE_RATE: u32 = 4 << 20;

impl<'a, W: Write> Logging<'a, W> {
    pub(super) fn new(
        (log, progress): (Recorder<W>, Progress),
        reached: f64,
        (prepared, is_told): (&'a Prepared, bool),
        (stop, size): (&'a StopWish, Size),
    ) -> Self {
        let next_save = Instant::now() + SAVE_INTERVAL;
        let (fault, taken) = (None, Duration::ZERO);
        Self { log, progress, prepared, is_told, stop, next_save, reached, fault, size, taken }
    }

    fn write(&mut self, write: impl FnOnce(&mut Recorder<W>) -> Result<(), LogError>) {
        let begun = Instant::now();
        if self.fault.is_none()
            && let Err(error) = write(&mut self.log)
        {
            self.fault = Some((self.reached, error));
        }
        self.taken += begun.elapsed();
    }
}

impl<W: Write> Observer for Logging<'_, W> {
    fn sample(&mut self, sample: &Sample, by: &[StateSensitivity]) -> Control {
        self.write(|log| log.write(sample).and_then(|()| log.write_sensitivities(sample.t, by)));
        if self.fault.is_some() {
            return Control::Stop;
        }
        self.reached = sample.t;
        self.progress.reached(sample.t);
        // A step may hold more samples than anybody waits for.
        let is_over = self.stop.status().is_some() || self.size.is_reached();
        if is_over { Control::Stop } else { Control::Continue }
    }

    fn wants_segments(&self) -> bool {
        true
    }

    fn segment(&mut self, segment: &Segment) {
        // A fault stops the run at its next sample.
        self.write(|log| log.segment(segment));
    }

    fn uniqueness(&mut self, change: &UniquenessChange) {
        self.write(|log| log.uniqueness(change));
    }

    fn slow(&mut self, slowness: &Slowness) {
        let Prepared { simulation, source, .. } = self.prepared;
        let warning = simulation.diagnose_slowness(slowness);
        if self.is_told {
            self.progress.aside(|| render::print_all(source, std::slice::from_ref(&warning)));
        }
        self.write(|log| log.note(Level::Warning, slowness.t, &in_log(&warning)));
    }

    fn wants_checkpoint(&mut self) -> bool {
        let is_due = self.fault.is_none() && Instant::now() >= self.next_save;
        if !is_due {
            self.write(Recorder::flush_if_due);
        }
        is_due
    }

    fn checkpoint(&mut self, checkpoint: &RunCheckpoint) {
        let bytes = checkpoint.to_bytes();
        self.write(|log| match log.checkpoint(&bytes) {
            // The log is worth more than that.
            Err(LogError::TooLarge { .. }) => log.flush_if_due(),
            written => written,
        });
        let n_bytes = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
        let pause = Duration::from_secs(1) * n_bytes / SAVE_RATE;
        self.next_save = Instant::now() + pause.max(SAVE_INTERVAL);
    }
}
