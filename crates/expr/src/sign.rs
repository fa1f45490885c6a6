//! Of an expression and its negative, the one that reads better: the canonical form moves signs out of it.

use crate::build::MERGE_LIMIT;
use crate::op::Op;
use crate::pool::{Expr, Node, ONE, Pool};

impl Pool {
    /// True where `e` reads better negated: a negative coefficient, or a sum with more negative than
    /// positive terms; the constant, then the first symbol by name, decides a tie.
    pub(crate) fn looks_negative(&self, e: Expr) -> bool {
        let (coefficient, monic) = self.split_coefficient(e);
        let node = self.node(monic);
        if node.op != Op::Add || node.data > MERGE_LIMIT {
            return coefficient.is_negative();
        }
        let (n_terms, n_negative) = self.count_negative_terms(node);
        let is_negative = match (2 * n_negative).cmp(&n_terms) {
            std::cmp::Ordering::Less => false,
            std::cmp::Ordering::Greater => true,
            std::cmp::Ordering::Equal => {
                let terms = self.terms_of(monic);
                let leading = terms.iter().min_by(|a, b| {
                    let key = |term: Expr| (term != ONE, self.reading_name(term));
                    key(a.0).cmp(&key(b.0)).then_with(|| self.canonical_order(a.0, b.0))
                });
                leading.is_some_and(|term| term.1.is_negative())
            }
        };
        is_negative != coefficient.is_negative()
    }

    /// The number of terms of a sum, and of those with a negative coefficient.
    fn count_negative_terms(&self, mut sum: Node) -> (u32, u32) {
        let is_negative = |term: Expr| {
            let node = self.node(term);
            let number = if node.op == Op::Mul { node.left } else { term };
            u32::from(self.is_negative_number(number))
        };
        let n_terms = sum.data;
        let mut n_negative = 0;
        for _ in 2..n_terms {
            n_negative += is_negative(sum.right);
            sum = self.node(sum.left);
        }
        (n_terms, n_negative + is_negative(sum.right) + is_negative(sum.left))
    }

    /// A name to order short expressions by: the first symbol on the way down.
    fn reading_name(&self, mut e: Expr) -> String {
        for _ in 0..MERGE_LIMIT {
            let node = self.node(e);
            e = match node.op {
                Op::Symbol => return self.symbol_name(crate::pool::SymbolId(node.data)),
                Op::Number | Op::Pi => break,
                Op::Add | Op::Mul if self.as_number(node.left).is_some() => node.right,
                _ => node.left,
            };
        }
        String::new()
    }
}
