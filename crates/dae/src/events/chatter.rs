//! Do events accumulate?

use super::{Chatter, Event};

/// The last restarts.
#[derive(Clone, Debug)]
pub(super) struct Recent {
    count: usize,
    interval: f64,
    last: Option<Event>,
    /// Time between the last two restarts by the same function.
    gap: f64,
    /// Short intervals in sequence.
    n_short: usize,
}

impl Recent {
    pub(super) fn new(count: usize, interval: f64) -> Self {
        Self { count, interval, last: None, gap: f64::INFINITY, n_short: 0 }
    }

    /// Whether `event` is one too many.
    pub(super) fn observe(&self, event: &Event) -> Option<Chatter> {
        let last = self.last.filter(|last| last.i == event.i)?;
        let gap = (event.t - last.t).abs();
        if gap > self.interval || self.n_short + 1 < self.count {
            return None;
        }
        // Sum of the geometric series that the last intervals begin.
        let ratio = gap / self.gap;
        let limit = (ratio < 0.99).then(|| event.t + (event.t - last.t) * ratio / (1.0 - ratio));
        Some(Chatter { i: event.i, interval: gap, limit })
    }

    /// Takes note of an event that restarts the run.
    pub(super) fn note(&mut self, event: &Event) {
        let gap = match self.last {
            Some(last) if last.i == event.i => (event.t - last.t).abs(),
            _ => f64::INFINITY,
        };
        self.n_short = if gap <= self.interval { self.n_short + 1 } else { 0 };
        self.gap = gap;
        self.last = Some(*event);
    }
}
