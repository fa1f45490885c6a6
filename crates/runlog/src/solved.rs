//! [`solve`]: the motion of a mechanism in memory, without a log.

use std::cell::Cell;

use bksim_dae::Control;
use bksim_log::Header;
use bksim_model::diagnostic::{Diagnostic, Rejected};
use bksim_sim::Mechanism;
use bksim_sim::run::{Observer, Sample, Segment};
use bksim_sim::sensitivity::StateSensitivity;

use crate::playback::{Playback, PlaybackError, RunLog};
use crate::record::VERSION;

/// A motion in memory.
#[derive(Debug)]
pub struct Solved {
    /// The motion, as far as it went.
    pub playback: Playback,
    /// The fault that stopped it, if it did not reach its end.
    pub fault: Option<Diagnostic>,
}

/// Solves a mechanism and keeps its motion; `text` is the model's, `go_on` gets every instant that
/// is reached, s, and returns whether to continue.
///
/// # Errors
/// [`PlaybackError`] when there is no consistent start, or not even one step.
pub fn solve(
    mechanism: Mechanism,
    text: &str,
    go_on: &dyn Fn(f64) -> bool,
) -> Result<Solved, PlaybackError> {
    let simulation = mechanism.simulation()?;
    let start = simulation.start()?;
    let reached = Cell::new(start.t);
    let mut segments = Segments { segments: Vec::new(), reached: &reached };
    let stop = || !go_on(reached.get());
    let ran = simulation.run(&start, &mut segments, &stop);
    let fault = ran.err().map(|failure| simulation.diagnose(&failure));
    if let (Some(fault), true) = (&fault, segments.segments.is_empty()) {
        return Err(Rejected(vec![fault.clone()]).into());
    }
    let mut header = Header::new(&mechanism.model.name, "toml", text, VERSION);
    header.t_start = start.t;
    let log = RunLog::unlogged(header, segments.segments);
    Ok(Solved { playback: Playback::new(log, mechanism)?, fault })
}

/// Observer that keeps the motion between samples.
struct Segments<'a> {
    segments: Vec<Segment>,
    /// The end of the last segment, s.
    reached: &'a Cell<f64>,
}

impl Observer for Segments<'_> {
    fn sample(&mut self, _: &Sample, _: &[StateSensitivity]) -> Control {
        Control::Continue
    }

    fn wants_segments(&self) -> bool {
        true
    }

    fn segment(&mut self, segment: &Segment) {
        self.reached.set(segment.t1);
        self.segments.push(segment.clone());
    }
}
