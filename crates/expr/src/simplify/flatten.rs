//! Long sums and products in one piece.
//!
//! Constructors merge chains up to a limit only, so that building a million terms one by one stays
//! linear. A longer one is a chain of pieces, and which pieces depends on the order of building;
//! here they become one chain in canonical order.

use crate::number::Number;
use crate::op::Op;
use crate::pool::{Expr, Pool};

impl Pool {
    /// `e` with the pieces of a long sum or product as one chain, which is the same in whatever
    /// order it was built; and the number of operands. A chain of more than `limit` stays as it is.
    pub(super) fn flattened(&self, e: Expr, limit: usize) -> (Expr, usize) {
        let (coefficient, monic) = self.split_coefficient(e);
        let op = self.node(monic).op;
        if !matches!(op, Op::Add | Op::Mul) {
            return (e, 0);
        }
        let mut leaves: Vec<(Expr, Number)> = Vec::new();
        let mut pending = vec![(monic, Number::ONE)];
        let mut is_flat = true;
        while let Some((chain, factor)) = pending.pop() {
            for operand in self.chain(chain, op) {
                let (c, inner) = self.split_coefficient(operand);
                if self.node(inner).op == op && (op == Op::Mul || c.magnitude().is_one()) {
                    is_flat = false;
                    pending.push((inner, c.times(&factor)));
                } else {
                    leaves.push((inner, c.times(&factor)));
                }
            }
            if leaves.len() > limit {
                return (e, leaves.len());
            }
        }
        let n_leaves = leaves.len();
        if is_flat {
            return (e, n_leaves);
        }
        let flat = if op == Op::Add {
            self.sum_of(leaves)
        } else {
            let scale = leaves.iter().fold(Number::ONE, |scale, leaf| scale.times(&leaf.1));
            let bases = leaves.into_iter().map(|leaf| self.split_power(leaf.0)).collect();
            self.scaled_product(scale, bases)
        };
        (self.mul(self.number(coefficient), flat), n_leaves)
    }
}
