//! What an expression costs to evaluate, each shared part once.

use super::budget::Meter;
use crate::number::Number;
use crate::op::{Function, Op};
use crate::pool::{Expr, ExprSet, Pool};

/// An addition or multiplication.
const ARITHMETIC: u64 = 1;
/// A division.
const DIVISION: u64 = 4;
/// A square root or any other function.
pub(super) const CALL: u64 = 8;
/// A sine, cosine or tangent.
pub(super) const TRIGONOMETRIC: u64 = 12;

/// What `simplify` minimises. Symbols come first: an expression that does not depend on a symbol
/// should not show it, even where the longer form takes fewer calls. (A chain's inertia does not
/// depend on where it points; only the form without its first angle says so.)
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) struct Cost {
    /// Number of symbols that occur; a large atom counts as one symbol.
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

/// Weighs forms of one expression against each other.
pub(super) struct Judge<'p> {
    pub(super) pool: &'p Pool,
    pub(super) meter: Meter,
    /// Atoms too large to look into again and again. Every form of an expression has the same
    /// atoms, so what is inside does not decide which form is cheaper.
    opaque: ExprSet,
}

impl<'p> Judge<'p> {
    pub(super) fn new(pool: &'p Pool, meter: Meter) -> Self {
        Self { pool, meter, opaque: ExprSet::default() }
    }

    /// From now on `e` counts as one call.
    pub(super) fn make_opaque(&mut self, e: Expr) {
        let (_, monic) = self.pool.split_coefficient(e);
        self.opaque.extend(self.pool.chain(monic, Op::Mul));
    }

    /// The cost of `e`.
    pub(super) fn cost(&self, e: Expr) -> Cost {
        let pool = self.pool;
        pool.clear_positions();
        let mut cost = Cost::ZERO;
        // Negative powers are divisions of their own unless all their users are products.
        let mut lone_divisors: Vec<Expr> = Vec::new();
        let mut pending = vec![e];
        pool.visit(e);
        lone_divisors.push(e);
        let mut n_visited = 0;
        while let Some(e) = pending.pop() {
            n_visited += 1;
            if !self.opaque.is_empty() && self.opaque.contains(&e) {
                cost.n_symbols += 1;
                cost.work += CALL;
                continue;
            }
            let node = pool.node(e);
            match node.op {
                Op::Number | Op::Pi => continue,
                Op::Symbol => {
                    cost.n_symbols += 1;
                    continue;
                }
                Op::Mul => {
                    let product = self.product(e);
                    cost.work += product.0;
                    n_visited += product.1;
                }
                Op::Add => cost.work += ARITHMETIC * u64::from(node.data - 1),
                Op::Pow => match pool.split_power(e) {
                    (base, n) if base != e => cost.work += ARITHMETIC * (n.unsigned_abs() - 1),
                    _ => cost.work += CALL,
                },
                Op::Pair => (),
                Op::Call(Function::Sin | Function::Cos | Function::Tan) => {
                    cost.work += TRIGONOMETRIC;
                }
                Op::Call(_) => cost.work += CALL,
            }
            for operand in pool.operands_of(e) {
                if node.op != Op::Mul && pool.split_power(operand).1 < 0 {
                    lone_divisors.push(operand);
                }
                if pool.visit(operand) {
                    pending.push(operand);
                }
            }
        }
        lone_divisors.sort_unstable();
        lone_divisors.dedup();
        let n_divisions = lone_divisors.iter().filter(|&&e| pool.split_power(e).1 < 0).count();
        cost.work += DIVISION * n_divisions as u64;
        self.meter.spend(n_visited);
        cost
    }

    /// Work of one product, and its number of factors. All divisors together are one division;
    /// signs are free.
    fn product(&self, e: Expr) -> (u64, usize) {
        let pool = self.pool;
        let (mut n_factors, mut n_divisors) = (0u64, 0u64);
        let factors = pool.chain(e, Op::Mul);
        for &factor in &factors {
            if pool.split_power(factor).1 < 0 {
                n_divisors += 1;
            } else if pool.as_number(factor) != Some(Number::MINUS_ONE) {
                n_factors += 1;
            }
        }
        let n_products = n_factors.saturating_sub(1) + n_divisors.saturating_sub(1);
        let division = if n_divisors > 0 { DIVISION } else { 0 };
        (ARITHMETIC * n_products + division, factors.len())
    }
}
