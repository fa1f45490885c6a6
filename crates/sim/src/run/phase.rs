//! A phase of a run: steps of one method in one set of modes.

use bksim_dae::{Checkpoint, Saver};

use super::ending::PhaseEnd;
use super::stepper::Stepper;
use crate::hybrid::{Crossed, EventMonitor};

/// A phase in progress.
pub(super) struct Phase<'a> {
    pub(super) stepper: Box<dyn Stepper + 'a>,
    /// Events that end it; `None` when nothing ever switches.
    pub(super) monitor: Option<EventMonitor<'a>>,
}

impl Phase<'_> {
    /// Phase as numbers, for a run that goes on from here.
    pub(super) fn save(&mut self) -> Checkpoint {
        let mut saver = Saver::default();
        self.stepper.save(&mut saver);
        if let Some(monitor) = &self.monitor {
            monitor.save(&mut saver);
        }
        saver.finish(self.stepper.method())
    }
}

/// Result of an attempt at a step.
pub(super) enum Attempt {
    /// A step, nothing of which has been handed out; it ends at the event, if it met one.
    Step(Option<Crossed>),
    /// No step, but another is to be tried.
    Rejected,
    /// No step: the phase ends where the step before it did.
    End(PhaseEnd),
}
