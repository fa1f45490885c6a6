//! Expressions as text a person reads: ordered terms and factors, then a notation.
//!
//! The canonical order of the pool is blind to names; here terms and factors are put into the
//! order a person would write: numbers, symbols by name, sums, calls.

mod count;
mod latex;
mod text;

pub use count::OperationCount;

use crate::number::Number;
use crate::op::Op;
use crate::pool::{Expr, ONE, Pool, SymbolId};
use std::cmp::Ordering;
use std::collections::HashMap;

/// How tightly the surroundings of an expression bind; anything looser needs parentheses.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum Strength {
    Sum,
    Product,
    Power,
    Atom,
}

/// A piece of output still to be written.
enum Piece {
    Text(String),
    Expr(Expr, Strength),
}

impl From<&str> for Piece {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

/// A term as it is written: a sign, and numerator and denominator.
struct Term {
    is_negative: bool,
    coefficient: Number,
    numerator: Vec<Expr>,
    denominator: Vec<Expr>,
}

/// The reading order of the expressions below some roots.
struct Reader<'p> {
    pool: &'p Pool,
    /// Rank of the first symbol (by name) in each expression; [`NO_SYMBOL`] without one.
    ranks: HashMap<Expr, u32>,
}

const NO_SYMBOL: u32 = u32::MAX;

/// Place of a factor within a product or of a term within a sum.
type Key = (u8, u32);

impl<'p> Reader<'p> {
    fn new(pool: &'p Pool, roots: &[Expr]) -> Self {
        let sweep = pool.sweep(roots);
        let mut names: Vec<(String, SymbolId)> = sweep
            .steps
            .iter()
            .filter_map(crate::sweep::Step::symbol)
            .map(|symbol| (pool.symbol_name(symbol), symbol))
            .collect();
        names.sort_by(|a, b| natural_order(&a.0, &b.0));
        let by_symbol: HashMap<SymbolId, u32> =
            names.into_iter().map(|(_, symbol)| symbol).zip(0..).collect();
        let mut ranks: Vec<u32> = Vec::with_capacity(sweep.steps.len());
        for step in &sweep.steps {
            let rank = match step.symbol() {
                Some(symbol) => by_symbol[&symbol],
                None => sweep.operands(step).map(|o| ranks[o]).min().unwrap_or(NO_SYMBOL),
            };
            ranks.push(rank);
        }
        let ranks = sweep.steps.iter().map(|step| step.expr).zip(ranks).collect();
        Self { pool, ranks }
    }

    fn rank(&self, e: Expr) -> u32 {
        self.ranks.get(&e).copied().unwrap_or(NO_SYMBOL)
    }

    /// Symbols and their powers come first, then sums, then calls.
    fn factor_key(&self, e: Expr) -> Key {
        let (base, _) = self.pool.split_power(e);
        let class = match self.pool.node(base).op {
            Op::Number | Op::Pi | Op::Symbol => 0,
            Op::Add => 1,
            _ => 2,
        };
        (class, self.rank(e))
    }

    /// Splits a term into sign, coefficient, and ordered numerator and denominator.
    fn term(&self, e: Expr) -> Term {
        let (coefficient, monic) = self.pool.split_coefficient(e);
        let (mut numerator, mut denominator) = (Vec::new(), Vec::new());
        for factor in self.pool.chain(monic, Op::Mul) {
            match self.pool.split_power(factor) {
                (base, n) if n < 0 && n != i64::MIN => {
                    denominator.push(self.pool.powi(base, -n));
                }
                _ if factor == ONE => (),
                _ => numerator.push(factor),
            }
        }
        for factors in [&mut numerator, &mut denominator] {
            factors.sort_by(|&a, &b| {
                self.factor_key(a)
                    .cmp(&self.factor_key(b))
                    .then_with(|| self.pool.canonical_order(a, b))
            });
        }
        let is_negative = coefficient.is_negative();
        Term { is_negative, coefficient: coefficient.magnitude(), numerator, denominator }
    }

    /// The given terms with the terms of a sum among them in its place: it needs no parentheses.
    fn in_line(&self, terms: &[Expr]) -> Vec<Expr> {
        let is_sum = |e| self.pool.node(e).op == Op::Add;
        let opened =
            |&term: &Expr| if is_sum(term) { self.ordered_terms(term) } else { vec![term] };
        terms.iter().flat_map(opened).collect()
    }

    /// The terms of a sum in reading order; a positive one leads if there is any.
    fn ordered_terms(&self, sum: Expr) -> Vec<Expr> {
        let pool = self.pool;
        let mut keyed: Vec<(Vec<Key>, Expr)> = pool
            .chain(sum, Op::Add)
            .into_iter()
            .map(|term| {
                let Term { numerator, denominator, .. } = self.term(term);
                let factors = numerator.into_iter().chain(denominator);
                (factors.map(|f| self.factor_key(f)).collect(), term)
            })
            .collect();
        // The constant has no factors and comes last.
        let order = |a: &(Vec<Key>, Expr), b: &(Vec<Key>, Expr)| {
            (a.0.is_empty(), &a.0)
                .cmp(&(b.0.is_empty(), &b.0))
                .then_with(|| pool.canonical_order(a.1, b.1))
        };
        keyed.sort_by(order);
        let mut terms: Vec<Expr> = keyed.into_iter().map(|(_, term)| term).collect();
        let is_negative = |&term: &Expr| pool.split_coefficient(term).0.is_negative();
        if let Some(positive) = terms.iter().position(|term| !is_negative(term)) {
            terms[..=positive].rotate_right(1);
        }
        terms
    }
}

/// Writes pieces in order, each expression expanded by `expand`; no recursion.
fn write(pieces: Vec<Piece>, mut expand: impl FnMut(Expr, Strength) -> Vec<Piece>) -> String {
    let mut pending = pieces;
    pending.reverse();
    let mut text = String::new();
    while let Some(piece) = pending.pop() {
        match piece {
            Piece::Text(part) => text.push_str(&part),
            Piece::Expr(e, strength) => pending.extend(expand(e, strength).into_iter().rev()),
        }
    }
    text
}

/// Order of names in which `q2` comes before `q10`.
fn natural_order(a: &str, b: &str) -> Ordering {
    let (mut x, mut y) = (a, b);
    while let (Some(p), Some(q)) = (x.chars().next(), y.chars().next()) {
        let digits = |s: &str| s.len() - s.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let (m, n) = (digits(x), digits(y));
        let (order, m, n) = if m > 0 && n > 0 {
            let number = |s: &str| s.trim_start_matches('0').to_owned();
            let (u, v) = (number(&x[..m]), number(&y[..n]));
            (u.len().cmp(&v.len()).then_with(|| u.cmp(&v)), m, n)
        } else {
            (p.cmp(&q), p.len_utf8(), q.len_utf8())
        };
        if order.is_ne() {
            return order;
        }
        (x, y) = (&x[m..], &y[n..]);
    }
    x.len().cmp(&y.len()).then_with(|| a.cmp(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_order_by_the_numbers_inside() {
        assert_eq!(natural_order("q2", "q10"), Ordering::Less);
        assert_eq!(natural_order("q2_dot", "q2"), Ordering::Greater);
        assert_eq!(natural_order("a", "b"), Ordering::Less);
        assert_eq!(natural_order("x01", "x1"), Ordering::Less);
    }
}
