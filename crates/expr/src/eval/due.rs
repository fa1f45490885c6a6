//! [`Jit`] and [`Due`]: machine code that is made when it pays.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The time at which a tape is compiled to machine code.
///
/// Results do not depend on it: interpreter and machine code agree bit for bit.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Jit {
    /// Once interpreting has cost about what compiling costs, so that the two together never take
    /// twice as long as the better of them would have.
    #[default]
    Auto,
    /// At the first evaluation.
    On,
    /// Never.
    Off,
}

/// Machine code, once enough evaluations have been interpreted; threads share it.
#[derive(Debug)]
pub(super) struct Due<C> {
    n_interpreted: AtomicUsize,
    /// `None` where the tape cannot be compiled.
    compiled: OnceLock<Option<C>>,
}

impl<C> Default for Due<C> {
    fn default() -> Self {
        Self { n_interpreted: AtomicUsize::new(0), compiled: OnceLock::new() }
    }
}

impl<C> Due<C> {
    /// True once there is code.
    pub(super) fn is_compiled(&self) -> bool {
        matches!(self.compiled.get(), Some(Some(_)))
    }

    /// The code, made now if it was not.
    pub(super) fn made(&self, make: impl FnOnce() -> Option<C>) -> Option<&C> {
        self.compiled.get_or_init(make).as_ref()
    }

    /// The code if it is there or due now, after `n_paid` evaluations where that is left to choose.
    pub(super) fn code(
        &self,
        jit: Jit,
        n_paid: usize,
        make: impl FnOnce() -> Option<C>,
    ) -> Option<&C> {
        if let Some(compiled) = self.compiled.get() {
            return compiled.as_ref();
        }
        let n_paid = match jit {
            Jit::Off => return None,
            Jit::On => 0,
            // Evaluations are counted, not time: runs can be repeated exactly.
            Jit::Auto => n_paid,
        };
        // Exactly one evaluation reaches the count: other threads go on interpreting meanwhile.
        if self.n_interpreted.fetch_add(1, Relaxed) != n_paid {
            return None;
        }
        self.made(make)
    }
}
