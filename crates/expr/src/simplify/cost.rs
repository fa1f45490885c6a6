//! What an expression costs to evaluate, each shared part once.

use crate::op::{Function, Op};
use crate::pool::{Expr, Pool};

/// An addition or multiplication.
const ARITHMETIC: u64 = 1;
/// A division.
const DIVISION: u64 = 4;
/// A square root or any other function.
const CALL: u64 = 8;
/// A sine, cosine or tangent.
const TRIGONOMETRIC: u64 = 12;

/// What `simplify` minimises. Symbols come first: an expression that does not depend on a symbol
/// should not show it, even where the longer form takes fewer calls. (A chain's inertia does not
/// depend on where it points; only the form without its first angle says so.)
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) struct Cost {
    /// Number of symbols that occur.
    pub(super) n_symbols: usize,
    /// Weighted operations.
    pub(super) work: u64,
}

impl Cost {
    /// More than any expression costs.
    pub(super) const MAX: Self = Self { n_symbols: usize::MAX, work: u64::MAX };
    /// The cost of a number.
    pub(super) const ZERO: Self = Self { n_symbols: 0, work: 0 };
}

/// The cost of `e`.
pub(super) fn cost(pool: &Pool, e: Expr) -> Cost {
    let sweep = pool.sweep(&[e]);
    let count = pool.count_sweep(&sweep);
    let is_trig = |op: Op| matches!(op, Op::Call(Function::Sin | Function::Cos | Function::Tan));
    let n_trig = sweep.steps.iter().filter(|step| is_trig(step.op)).count() as u64;
    let work = ARITHMETIC * (count.multiplications + count.additions)
        + DIVISION * count.divisions
        + CALL * (count.calls - n_trig)
        + TRIGONOMETRIC * n_trig;
    let n_symbols = sweep.steps.iter().filter(|step| step.op == Op::Symbol).count();
    Cost { n_symbols, work }
}
