//! The work that a simplification may take, and the meter that counts it.

use std::cell::Cell;
use std::time::{Duration, Instant};

/// Limits on one call of [`Pool::simplify_within`](crate::Pool::simplify_within).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Budget {
    /// Nodes visited and terms multiplied for each expression asked for. Default 4 million, which
    /// takes a fraction of a second; nothing but very large expressions comes near it.
    pub nodes: u64,
    /// Time for the whole call. Default none: with a limit of nodes alone the same input gives the
    /// same output on every machine.
    pub time: Option<Duration>,
}

impl Default for Budget {
    fn default() -> Self {
        Self { nodes: 4_000_000, time: None }
    }
}

/// The limit of a [`Budget`] that ended a simplification.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Limit {
    /// [`Budget::nodes`]
    Nodes,
    /// [`Budget::time`]
    Time,
}

/// Multiplications of terms spent on one normal form of one part of an expression.
pub(super) const FORM_BUDGET: usize = 60_000;

/// Work between two looks at the clock.
const CLOCK_INTERVAL: u64 = 4_096;

/// Counts work against a budget; once spent it stays spent.
pub(super) struct Meter {
    granted: u64,
    left: Cell<u64>,
    deadline: Option<Instant>,
    next_look: Cell<u64>,
    ended_by: Cell<Option<Limit>>,
}

impl Meter {
    pub(super) fn new(budget: &Budget, n_roots: usize) -> Self {
        let granted = budget.nodes.saturating_mul(n_roots as u64);
        Self {
            granted,
            left: Cell::new(granted),
            // A time too long to be represented is no limit.
            deadline: budget.time.and_then(|time| Instant::now().checked_add(time)),
            next_look: Cell::new(granted),
            ended_by: Cell::new(None),
        }
    }

    /// Counts some work.
    pub(super) fn spend(&self, work: usize) {
        let Some(left) = self.left.get().checked_sub(work as u64) else {
            self.left.set(0);
            self.end(Limit::Nodes);
            return;
        };
        self.left.set(left);
        if let Some(deadline) = self.deadline
            && left <= self.next_look.get()
        {
            self.next_look.set(left.saturating_sub(CLOCK_INTERVAL));
            if Instant::now() >= deadline {
                self.end(Limit::Time);
            }
        }
    }

    fn end(&self, limit: Limit) {
        self.ended_by.set(self.ended_by.get().or(Some(limit)));
    }

    /// Which limit was reached, if one was.
    pub(super) fn ended_by(&self) -> Option<Limit> {
        self.ended_by.get()
    }

    pub(super) fn has_ended(&self) -> bool {
        self.ended_by.get().is_some()
    }

    /// Work left, as a bound for a single form.
    pub(super) fn left(&self) -> usize {
        usize::try_from(self.left.get()).unwrap_or(usize::MAX)
    }

    /// Work spent.
    pub(super) fn spent(&self) -> u64 {
        self.granted - self.left.get()
    }
}
