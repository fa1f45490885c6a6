//! The work that a simplification may take, and the meter that counts it.

use std::cell::Cell;

/// Nodes visited and terms multiplied for each expression asked for: a fraction of a second. Only very large
/// expressions come near it.
pub(super) const BUDGET: u64 = 4_000_000;

/// Multiplications of terms spent on one normal form of one part of an expression.
pub(super) const FORM_BUDGET: usize = 60_000;

/// Counts work against a budget; once spent it stays spent.
pub(super) struct Meter {
    left: Cell<u64>,
    has_ended: Cell<bool>,
}

impl Meter {
    /// A budget for each of `n_roots` expressions.
    pub(super) fn new(budget: u64, n_roots: usize) -> Self {
        let granted = budget.saturating_mul(n_roots as u64);
        Self { left: Cell::new(granted), has_ended: Cell::new(false) }
    }

    /// Counts some work.
    pub(super) fn spend(&self, work: usize) {
        let left = self.left.get().checked_sub(work as u64);
        self.has_ended.set(self.has_ended.get() || left.is_none());
        self.left.set(left.unwrap_or(0));
    }

    pub(super) fn has_ended(&self) -> bool {
        self.has_ended.get()
    }

    /// Work left, as a bound for a single form.
    pub(super) fn left(&self) -> usize {
        usize::try_from(self.left.get()).unwrap_or(usize::MAX)
    }
}
