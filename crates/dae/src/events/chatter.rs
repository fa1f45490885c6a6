//! Do events accumulate?

use super::search::is_same_instant;
use super::{Chatter, Crossing, Event};
use crate::SolveError;
use crate::checkpoint::{Loader, Saver};

/// The last restarts, whichever functions made them: two switches may throw each other.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Recent {
    count: usize,
    interval: f64,
    last: Option<Event>,
    /// Times between the last restarts, latest first.
    gaps: [f64; 3],
    /// Short intervals in sequence.
    n_short: usize,
    /// Another function that restarted during them.
    other: Option<usize>,
}

impl Recent {
    pub(super) fn new(count: usize, interval: f64) -> Self {
        let gaps = [f64::INFINITY; 3];
        Self { count, interval, last: None, gaps, n_short: 0, other: None }
    }

    /// Whether `event` is one too many.
    pub(super) fn observe(&self, event: &Event) -> Option<Chatter> {
        let last = self.last.filter(|last| !is_together(last, event))?;
        let gap = (event.t - last.t).abs();
        if gap > self.interval || self.n_short + 1 < self.count {
            return None;
        }
        let with = if last.i == event.i { self.other } else { Some(last.i) };
        let rest = rest_of_series([gap, self.gaps[0], self.gaps[1]]);
        let limit = rest.map(|rest| event.t + rest.copysign(event.t - last.t));
        Some(Chatter { i: event.i, with: with.filter(|&i| i != event.i), interval: gap, limit })
    }

    /// Takes note of an event that restarts the run.
    pub(super) fn note(&mut self, event: &Event) {
        let Some(last) = self.last else {
            self.last = Some(*event);
            return;
        };
        // Functions that fire together, as contacts do, make one restart.
        if is_together(&last, event) {
            return;
        }
        let gap = (event.t - last.t).abs();
        self.n_short = if gap <= self.interval { self.n_short + 1 } else { 0 };
        self.other = match self.n_short {
            0 => None,
            _ if last.i != event.i => Some(last.i),
            _ => self.other,
        };
        self.gaps = [gap, self.gaps[0], self.gaps[1]];
        self.last = Some(*event);
    }

    pub(super) fn save(&self, saver: &mut Saver) {
        saver.count(self.count);
        saver.real(self.interval);
        saver.flag(self.last.is_some());
        let last = self.last.unwrap_or(Event { i: 0, t: 0.0, crossing: Crossing::Rising });
        saver.count(last.i);
        saver.real(last.t);
        saver.flag(last.crossing == Crossing::Rising);
        self.gaps.iter().for_each(|&gap| saver.real(gap));
        saver.count(self.n_short);
        saver.flag(self.other.is_some());
        saver.count(self.other.unwrap_or(0));
    }

    pub(super) fn load(loader: &mut Loader<'_>) -> Result<Self, SolveError> {
        let (count, interval, is_some) = (loader.count()?, loader.real()?, loader.flag()?);
        let (i, t, is_rising) = (loader.count()?, loader.real()?, loader.flag()?);
        let crossing = if is_rising { Crossing::Rising } else { Crossing::Falling };
        let gaps = [loader.real()?, loader.real()?, loader.real()?];
        let (n_short, has_other, other) = (loader.count()?, loader.flag()?, loader.count()?);
        let last = is_some.then_some(Event { i, t, crossing });
        Ok(Self { count, interval, last, gaps, n_short, other: has_other.then_some(other) })
    }
}

/// Whether two events are two functions at one instant.
fn is_together(a: &Event, b: &Event) -> bool {
    a.i != b.i && is_same_instant(a.t, b.t)
}

/// What is left of a series of gaps, latest first, that shrink by a constant factor from one to the
/// next but one, as they do when two functions take turns; `None` when they do not shrink.
///
/// ```text
/// g_{k+2} = r g_k:   Σ = (g_k + g_{k−1}) r/(1 − r)
/// ```
fn rest_of_series([last, before, first]: [f64; 3]) -> Option<f64> {
    let ratio = if first.is_finite() { last / first } else { (last / before).powi(2) };
    (ratio < 0.98).then(|| (last + before) * ratio / (1.0 - ratio))
}
