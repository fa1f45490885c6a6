//! The order in which a person writes terms and factors: numbers, symbols by name, sums, calls.

use crate::number::Number;
use crate::op::{Function, Op};
use crate::pool::{Expr, ONE, Pool, SymbolId};
use crate::sweep::{Step, Sweep};
use std::cmp::Ordering;
use std::collections::{HashMap, HashSet};

/// A term as it is written: a sign, and numerator and denominator.
pub(super) struct WrittenTerm {
    pub(super) is_negative: bool,
    pub(super) coefficient: Number,
    pub(super) numerator: Vec<Expr>,
    pub(super) denominator: Vec<Expr>,
}

/// The reading order of the expressions below some roots.
pub(super) struct Reader<'p> {
    pub(super) pool: &'p Pool,
    /// Rank of the first symbol (by name) in each expression; [`NO_SYMBOL`] without one.
    ranks: HashMap<Expr, u32>,
    /// Number of operations in each expression written out: the shorter of two calls comes first.
    sizes: HashMap<Expr, u32>,
    /// Expressions that are higher than a line when fractions are.
    tall: HashMap<Expr, bool>,
    /// Symbols of the motion, and those of them that come last with their positions.
    moving: HashSet<Expr>,
    trailing: HashMap<Expr, u32>,
}

const NO_SYMBOL: u32 = u32::MAX;

/// Sort key of a factor within a product or of a term within a sum: class, first symbol, size.
type ReadingKey = (u8, u32, u32);

impl<'p> Reader<'p> {
    pub(super) fn new(
        pool: &'p Pool,
        roots: &[Expr],
        [moving, trailing]: [&[SymbolId]; 2],
    ) -> Self {
        let sweep = pool.sweep(roots);
        let mut names: Vec<(String, SymbolId)> = sweep
            .steps
            .iter()
            .filter_map(Step::symbol)
            .map(|symbol| (pool.symbol_name(symbol), symbol))
            .collect();
        names.sort_by(|a, b| natural_order(&a.0, &b.0));
        let by_symbol: HashMap<SymbolId, u32> =
            names.into_iter().map(|(_, symbol)| symbol).zip(0..).collect();
        let mut ranks: Vec<u32> = Vec::with_capacity(sweep.steps.len());
        let mut sizes: Vec<u32> = Vec::with_capacity(sweep.steps.len());
        let mut tall: Vec<bool> = Vec::with_capacity(sweep.steps.len());
        for step in &sweep.steps {
            let rank = match step.symbol() {
                Some(symbol) => by_symbol[&symbol],
                None => sweep.operands(step).map(|o| ranks[o]).min().unwrap_or(NO_SYMBOL),
            };
            ranks.push(rank);
            sizes.push(sweep.operands(step).fold(1, |sum, o| sizes[o].saturating_add(sum)));
            let is_tall = is_tall(pool, &sweep, step, &tall);
            tall.push(is_tall);
        }
        let exprs = || sweep.steps.iter().map(|step| step.expr);
        let exprs_of = |symbols: &'_ [SymbolId]| {
            symbols.iter().map(|&symbol| pool.symbol_expr(symbol)).collect::<Vec<_>>()
        };
        Self {
            pool,
            ranks: exprs().zip(ranks).collect(),
            sizes: exprs().zip(sizes).collect(),
            tall: exprs().zip(tall).collect(),
            moving: exprs_of(moving).into_iter().collect(),
            trailing: exprs_of(trailing).into_iter().zip(0..).collect(),
        }
    }

    /// True if parentheses around `e` must grow.
    pub(super) fn is_tall(&self, e: Expr) -> bool {
        self.tall.get(&e).copied().unwrap_or(false)
    }

    fn rank(&self, e: Expr) -> u32 {
        self.ranks.get(&e).copied().unwrap_or(NO_SYMBOL)
    }

    /// Symbols and their powers come first, those of the motion after the others, then sums, then calls,
    /// then the trailing symbols.
    fn factor_key(&self, e: Expr) -> ReadingKey {
        let (base, _) = self.pool.split_power(e);
        if let Some(&position) = self.trailing.get(&base) {
            return (4, position, 0);
        }
        let class = match self.pool.node(base).op {
            Op::Number | Op::Pi | Op::Symbol => u8::from(self.moving.contains(&base)),
            Op::Add => 2,
            _ => return (3, self.rank(e), self.sizes.get(&base).copied().unwrap_or(0)),
        };
        (class, self.rank(e), 0)
    }

    /// The key of a factor by which terms are sorted: symbols of the motion are as any others there.
    fn term_key(&self, e: Expr) -> ReadingKey {
        match self.factor_key(e) {
            (1, rank, size) => (0, rank, size),
            key => key,
        }
    }

    /// Splits a term into sign, coefficient, and ordered numerator and denominator.
    pub(super) fn term(&self, e: Expr) -> WrittenTerm {
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
        WrittenTerm { is_negative, coefficient: coefficient.magnitude(), numerator, denominator }
    }

    /// The given terms, with a sum among them replaced by its terms: it needs no parentheses.
    pub(super) fn in_line(&self, terms: &[Expr]) -> Vec<Expr> {
        let is_sum = |e| self.pool.node(e).op == Op::Add;
        let opened =
            |&term: &Expr| if is_sum(term) { self.ordered_terms(term) } else { vec![term] };
        terms.iter().flat_map(opened).collect()
    }

    /// The terms of a sum in reading order; a positive one leads if there is any.
    pub(super) fn ordered_terms(&self, sum: Expr) -> Vec<Expr> {
        let pool = self.pool;
        let mut keyed: Vec<(Vec<ReadingKey>, Expr)> = pool
            .chain(sum, Op::Add)
            .into_iter()
            .map(|term| {
                let WrittenTerm { numerator, denominator, .. } = self.term(term);
                let factors = numerator.into_iter().chain(denominator);
                (factors.map(|f| self.term_key(f)).collect(), term)
            })
            .collect();
        // The constant has no factors and comes last.
        let order = |a: &(Vec<ReadingKey>, Expr), b: &(Vec<ReadingKey>, Expr)| {
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

/// Fractions, cases and roots are higher than a line, and so are expressions that contain them.
fn is_tall(pool: &Pool, sweep: &Sweep, step: &Step, tall: &[bool]) -> bool {
    let is_below = || sweep.operands(step).any(|o| tall[o]);
    match step.op {
        Op::Number => pool.as_number(step.expr).is_some_and(|n| as_fraction(&n).is_some()),
        Op::Pow => {
            let (base, n) = pool.split_power(step.expr);
            (n < 0 && base != step.expr) || is_below()
        }
        Op::Call(Function::If | Function::Sqrt) => true,
        _ => is_below(),
    }
}

/// Parts below this are set as fractions, so that 1/3, 73/2400 and 1/12000 are exact.
const LARGEST_PART: i64 = 1_000_000;

/// Numerator and denominator of a positive number that is better read as a fraction: 1/2 and 1/3,
/// but 9.81 and 0.35.
pub(super) fn as_fraction(n: &Number) -> Option<(i64, i64)> {
    let (numerator, denominator) = n.short_parts()?;
    let is_decimal = !n.to_string().contains('/');
    let is_usual = if is_decimal { matches!(denominator, 2 | 4 | 8) } else { true };
    let is_short = denominator < LARGEST_PART && numerator.abs() < LARGEST_PART;
    (denominator != 1 && is_usual && is_short && (!is_decimal || numerator.abs() < 10))
        .then_some((numerator, denominator))
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

    #[test]
    fn usual_fractions_are_fractions_and_decimals_stay() {
        let fraction = |n, d| as_fraction(&Number::rational(n, d));
        assert_eq!(fraction(1, 2), Some((1, 2)));
        assert_eq!(fraction(4, 15), Some((4, 15)));
        assert_eq!(fraction(3541, 96_000), Some((3541, 96_000)));
        assert_eq!(fraction(981, 100), None);
        assert_eq!(fraction(7, 20), None);
        assert_eq!(fraction(3, 1), None);
    }
}
