//! The cost of evaluating an expression, each shared part once.

use super::budget::Meter;
use crate::handle::ExprSet;
use crate::number::Number;
use crate::op::{Function, Op};
use crate::pool::{Expr, Pool};

/// An addition or multiplication.
const ARITHMETIC: u64 = 1;
/// A division.
const DIVISION: u64 = 4;
/// A square root or any other function.
pub(super) const CALL: u64 = 8;
/// A sine, cosine or tangent.
pub(super) const TRIGONOMETRIC: u64 = 12;

/// The cost that `simplify` minimises. Symbols come first: an expression that does not depend on a
/// symbol should not show it, even where the longer form takes fewer calls. (A chain's inertia does
/// not depend on where it points; only the form without its first angle says so.)
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

/// Compares the forms of one expression by their cost.
pub(super) struct CostModel<'p> {
    pub(super) pool: &'p Pool,
    pub(super) meter: Meter,
    /// Atoms too large to look into again and again. Every form of an expression has the same
    /// atoms, so what is inside does not decide which form is cheaper.
    opaque: ExprSet,
}

impl<'p> CostModel<'p> {
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
        self.cost_of_all(&[e])
    }

    /// The cost of several expressions together, what they share once.
    pub(super) fn cost_of_all(&self, roots: &[Expr]) -> Cost {
        let pool = self.pool;
        let mut cost = Cost::ZERO;

        // Every reachable node once. Negative powers are divisions of their own unless all their
        // users are products.
        pool.clear_positions();
        let (mut pending, mut lone_divisors) = (Vec::new(), roots.to_vec());
        pending.extend(roots.iter().copied().filter(|&root| pool.visit(root)));
        let mut n_visited = 0;
        while let Some(e) = pending.pop() {
            n_visited += 1;
            if !self.opaque.is_empty() && self.opaque.contains(&e) {
                cost.n_symbols += 1;
                cost.work += CALL;
                continue;
            }
            let (op, operands) = (pool.node(e).op, pool.operands_of(e));
            cost.n_symbols += usize::from(op == Op::Symbol);
            cost.work += self.own_work(e, &operands);
            n_visited += if op == Op::Mul { operands.len() } else { 0 };
            for operand in operands {
                if op != Op::Mul && pool.split_power(operand).1 < 0 {
                    lone_divisors.push(operand);
                }
                if pool.visit(operand) {
                    pending.push(operand);
                }
            }
        }

        // Divisions outside of products.
        lone_divisors.sort_unstable();
        lone_divisors.dedup();
        let n_divisions = lone_divisors.iter().filter(|&&e| pool.split_power(e).1 < 0).count();
        cost.work += DIVISION * n_divisions as u64;
        self.meter.spend(n_visited);
        cost
    }

    /// Work of the node itself on its operands, divisions outside of products left out.
    fn own_work(&self, e: Expr, operands: &[Expr]) -> u64 {
        match self.pool.node(e).op {
            Op::Number | Op::Pi | Op::Symbol | Op::Pair => 0,
            Op::Add => ARITHMETIC * (operands.len() as u64 - 1),
            Op::Mul => self.product_work(operands),
            Op::Pow => match self.pool.split_power(e) {
                (base, n) if base != e => ARITHMETIC * (n.unsigned_abs() - 1),
                _ => CALL,
            },
            Op::Call(Function::Sin | Function::Cos | Function::Tan) => TRIGONOMETRIC,
            Op::Call(_) | Op::Named => CALL,
        }
    }

    /// Work of one product. All divisors together are one division; signs are free.
    fn product_work(&self, factors: &[Expr]) -> u64 {
        let pool = self.pool;
        let (mut n_factors, mut n_divisors) = (0u64, 0u64);
        for &factor in factors {
            if pool.split_power(factor).1 < 0 {
                n_divisors += 1;
            } else if pool.as_number(factor) != Some(Number::MINUS_ONE) {
                n_factors += 1;
            }
        }
        let n_products = n_factors.saturating_sub(1) + n_divisors.saturating_sub(1);
        let division = if n_divisors > 0 { DIVISION } else { 0 };
        ARITHMETIC * n_products + division
    }
}

#[cfg(test)]
mod tests {
    use super::super::budget::BUDGET;
    use super::*;

    #[test]
    fn cost_counts_shared_parts_once_and_signs_not_at_all() {
        let pool = Pool::new();
        for (text, expected) in [
            ("sin(q)^2 + cos(q)^2", 27),
            ("-sin(q1 + q2)", 13),
            ("a*cos(q1 + q2)/(b + d)", 19),
            ("l1^2 + l2^2 + 2*l1*l2*cos(q2)", 19),
            ("1 + tan(q)^2", 14),
            ("sqrt(a^2 + b^2)", 11),
            ("a/(b*c)", 5),
        ] {
            let model = CostModel::new(&pool, Meter::new(BUDGET, 1));
            assert_eq!(model.cost(pool.parse(text).expect(text)).work, expected, "{text}");
        }
    }
}
