//! Polynomials over atoms with exact coefficients, plain or with trigonometric products as sums.
//!
//! An atom is anything that is no sum, product or small integer power. In *Fourier form* every
//! term has at most one sine or cosine, because products are rewritten by the rows of [`PRODUCTS`].
//! The angles are linear forms with canonical sign, so equal expressions get equal terms: therefore
//! cos a cos b − sin a sin b, sin² a + cos² a and their relatives collapse by themselves.

use super::rules::{PRODUCTS, Product};
use crate::handle::{ExprMap, HandleHash};
use crate::number::Number;
use crate::op::{Function, Op};
use crate::pool::{CanonicalOrder, Expr, ONE, Pool, fact};
use std::cmp::Ordering;
use std::collections::HashMap;

/// Powers of atoms in canonical order. Negative powers occur for sines and cosines, which cancel
/// since their zeros are isolated, and for exponentials and hyperbolic cosines, which have none; any
/// other divisor is an atom of its own that does not cancel.
pub(super) type Monomial = Vec<(Expr, i32)>;

/// One term of a polynomial.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Term {
    pub(super) monomial: Monomial,
    pub(super) coefficient: Number,
}

/// Terms with distinct monomials in canonical order; none is zero.
pub(super) type Poly = Vec<Term>;

/// The way in which an expression becomes a polynomial.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Reading {
    /// Products of sines and cosines become sums.
    pub(super) is_fourier: bool,
    /// Sums without any sine or cosine are atoms.
    pub(super) keeps_plain_sums: bool,
    /// Tangents become quotients.
    pub(super) splits_tangents: bool,
}

/// Largest power of a sum that is multiplied out.
const MAX_EXPANDED_POWER: i64 = 12;

/// Work of a product of two coefficients of which one is long, by that of two short ones: measured on robots whose
/// frames have all digits.
const LONG_WORK: usize = 32;

/// Polynomial arithmetic within a budget.
pub(super) struct Algebra<'p> {
    pub(super) pool: &'p Pool,
    /// Multiplications of terms left to spend.
    pub(super) budget: usize,
    products: HashMap<(Expr, Expr), Vec<(Number, Expr)>, HandleHash>,
}

/// Whether `e` is a sine or cosine.
pub(super) fn is_trigonometric(pool: &Pool, e: Expr) -> bool {
    matches!(pool.node(e).op, Op::Call(Function::Sin | Function::Cos))
}

/// True if powers of an atom cancel.
fn can_cancel(pool: &Pool, e: Expr) -> bool {
    is_trigonometric(pool, e) || matches!(pool.node(e).op, Op::Call(Function::Exp | Function::Cosh))
}

/// Order of monomials that depends on names and structure alone.
pub(super) fn compare_monomials(order: &CanonicalOrder, a: &Monomial, b: &Monomial) -> Ordering {
    for (x, y) in a.iter().zip(b) {
        let ordering = order.compare(x.0, y.0).then(x.1.cmp(&y.1));
        if ordering != Ordering::Equal {
            return ordering;
        }
    }
    a.len().cmp(&b.len())
}

/// Sorts terms and merges those with equal monomials.
pub(super) fn collect(pool: &Pool, mut terms: Vec<Term>) -> Poly {
    if terms.len() > 1 {
        let order = pool.ordering();
        terms.sort_by(|a, b| compare_monomials(&order, &a.monomial, &b.monomial));
    }
    terms.dedup_by(|next, kept| {
        let is_like = next.monomial == kept.monomial;
        if is_like {
            kept.coefficient = kept.coefficient.plus(&next.coefficient);
        }
        is_like
    });
    terms.retain(|term| !term.coefficient.is_zero());
    terms
}

/// The product of two monomials.
pub(super) fn multiply_monomials(pool: &Pool, a: &[(Expr, i32)], b: &[(Expr, i32)]) -> Monomial {
    let mut product = Monomial::with_capacity(a.len() + b.len());
    let (mut i, mut j) = (0, 0);
    let order = pool.ordering();
    while i < a.len() && j < b.len() {
        match order.compare(a[i].0, b[j].0) {
            Ordering::Less => {
                product.push(a[i]);
                i += 1;
            }
            Ordering::Greater => {
                product.push(b[j]);
                j += 1;
            }
            Ordering::Equal => {
                let exponent = a[i].1.saturating_add(b[j].1);
                if exponent != 0 {
                    product.push((a[i].0, exponent));
                }
                i += 1;
                j += 1;
            }
        }
    }
    product.extend_from_slice(&a[i..]);
    product.extend_from_slice(&b[j..]);
    product
}

impl<'p> Algebra<'p> {
    pub(super) fn new(pool: &'p Pool, budget: usize) -> Self {
        Self { pool, budget, products: HashMap::default() }
    }

    /// The polynomial of `e`; `None` when it takes more than the budget.
    pub(super) fn read(&mut self, e: Expr, reading: Reading) -> Option<Poly> {
        let region = self.region(e, reading)?;
        let mut polys: ExprMap<Poly> = ExprMap::default();
        polys.reserve(region.len());
        for node in region {
            let poly = self.read_node(node, e, reading, &polys)?;
            polys.insert(node, poly);
        }
        polys.remove(&e)
    }

    /// The nodes between `e` and its atoms, operands first.
    fn region(&mut self, e: Expr, reading: Reading) -> Option<Vec<Expr>> {
        let mut found = vec![e];
        self.pool.clear_positions();
        self.pool.visit(e);
        let mut next = 0;
        while next < found.len() {
            let node = found[next];
            next += 1;
            let operands = self.inner_operands(node, e, reading);
            self.spend(1 + operands.len())?;
            found.extend(operands.into_iter().filter(|&o| self.pool.visit(o)));
        }
        // A node is interned after its operands.
        found.sort_unstable();
        Some(found)
    }

    /// Operands of a node that the polynomial looks into; none for an atom.
    fn inner_operands(&self, node: Expr, root: Expr, reading: Reading) -> Vec<Expr> {
        let pool = self.pool;
        let is_plain_sum = || !pool.has_fact(node, fact::TRIGONOMETRIC) && node != root;
        match pool.node(node).op {
            Op::Add if reading.keeps_plain_sums && is_plain_sum() => Vec::new(),
            Op::Add | Op::Mul => pool.operands_of(node),
            Op::Pow => match pool.split_power(node) {
                (base, n)
                    if base != node && (-MAX_EXPANDED_POWER..=MAX_EXPANDED_POWER).contains(&n) =>
                {
                    let is_sum = pool.node(base).op == Op::Add;
                    // Divisors are never multiplied out, but tangents in them may fold.
                    let is_open = reading.splits_tangents && pool.has_fact(base, fact::TANGENT);
                    if n < 0 && is_sum && !is_open { Vec::new() } else { vec![base] }
                }
                _ => Vec::new(),
            },
            _ => Vec::new(),
        }
    }

    fn read_node(
        &mut self,
        node: Expr,
        root: Expr,
        reading: Reading,
        polys: &ExprMap<Poly>,
    ) -> Option<Poly> {
        let pool = self.pool;
        let operands = self.inner_operands(node, root, reading);
        if operands.is_empty() {
            return Some(self.atom(node, reading));
        }
        match pool.node(node).op {
            Op::Add => {
                let terms = operands.iter().flat_map(|o| polys[o].iter().cloned());
                let terms: Vec<Term> = terms.collect();
                self.spend(terms.len())?;
                Some(collect(pool, terms))
            }
            Op::Mul => {
                let mut product = polys[&operands[0]].clone();
                for factor in &operands[1..] {
                    product = self.multiply(&product, &polys[factor], reading.is_fourier)?;
                }
                Some(product)
            }
            _ => {
                let (base, n) = pool.split_power(node);
                if n < 0 {
                    let is_sum = pool.node(base).op == Op::Add;
                    let folded =
                        if is_sum { Some(self.over_cosines(&polys[&base])?) } else { None };
                    let base_poly = folded.as_ref().unwrap_or(&polys[&base]);
                    return Some(self.divisor(node, base, n, base_poly));
                }
                let mut power = polys[&base].clone();
                for _ in 1..n {
                    power = self.multiply(&power, &polys[&base], reading.is_fourier)?;
                }
                Some(power)
            }
        }
    }

    /// The polynomial, over its common cosines where it is a single term then: 1 + tan² a is
    /// 1/cos² a. `None` when it takes more than the budget.
    fn over_cosines(&mut self, poly: &Poly) -> Option<Poly> {
        let divisors = common_divisors(self.pool, poly);
        if divisors.is_empty() {
            return Some(poly.clone());
        }
        let inverse = divisors.iter().map(|&(atom, n)| (atom, -n)).collect();
        let one = |monomial| vec![Term { monomial, coefficient: Number::ONE }];
        let above = self.multiply(poly, &one(inverse), true)?;
        if above.len() != 1 {
            return Some(poly.clone());
        }
        self.multiply(&above, &one(divisors), false)
    }

    /// `base^n` for a negative n: sines and cosines can cancel, any other base stays an atom.
    fn divisor(&self, node: Expr, base: Expr, n: i64, base_poly: &Poly) -> Poly {
        #[expect(clippy::cast_possible_truncation, reason = "at most the largest expanded power")]
        let n = n as i32;
        let monomial = match base_poly.as_slice() {
            [Term { monomial, coefficient }]
                if let Some(coefficient) = coefficient.power(i64::from(n))
                    && !monomial.is_empty()
                    && monomial.iter().all(|atom| can_cancel(self.pool, atom.0)) =>
            {
                let monomial = monomial.iter().map(|&(atom, m)| (atom, m * n)).collect();
                return vec![Term { monomial, coefficient }];
            }
            _ if n == -1 => vec![(node, 1)],
            _ => vec![(self.pool.powi(base, -1), -n)],
        };
        vec![Term { monomial, coefficient: Number::ONE }]
    }

    /// An atom, or a number, as a polynomial.
    fn atom(&self, node: Expr, reading: Reading) -> Poly {
        let pool = self.pool;
        if let Some(number) = pool.as_number(node) {
            return collect(pool, vec![Term { monomial: Vec::new(), coefficient: number }]);
        }
        let inner = pool.node(node).left;
        if reading.splits_tangents && pool.node(node).op == Op::Call(Function::Tan) {
            let (sine, cosine) = ((pool.sin(inner), 1), (pool.cos(inner), -1));
            let monomial = multiply_monomials(pool, &[sine], &[cosine]);
            return vec![Term { monomial, coefficient: Number::ONE }];
        }
        vec![Term { monomial: vec![(node, 1)], coefficient: Number::ONE }]
    }

    fn spend(&mut self, amount: usize) -> Option<()> {
        self.budget = self.budget.checked_sub(amount)?;
        Some(())
    }

    /// The product; `None` when it takes more than the budget.
    pub(super) fn multiply(&mut self, a: &Poly, b: &Poly, is_fourier: bool) -> Option<Poly> {
        let n_long = |poly: &Poly| poly.iter().filter(|term| term.coefficient.is_long()).count();
        // Pairs in which one is long, or both.
        let n_short = (a.len() - n_long(a)).checked_mul(b.len() - n_long(b))?;
        let n_pairs = a.len().checked_mul(b.len())?;
        self.spend(n_short.checked_add((n_pairs - n_short).checked_mul(LONG_WORK)?)?)?;
        let mut terms = Vec::with_capacity(a.len() * b.len());
        for x in a {
            for y in b {
                let term = Term {
                    monomial: multiply_monomials(self.pool, &x.monomial, &y.monomial),
                    coefficient: x.coefficient.times(&y.coefficient),
                };
                if is_fourier { self.push_fourier(term, &mut terms) } else { terms.push(term) }
            }
        }
        Some(collect(self.pool, terms))
    }

    /// Rewrites products of sines and cosines until each term has at most one.
    fn push_fourier(&mut self, term: Term, terms: &mut Vec<Term>) {
        let mut pending = vec![term];
        while let Some(mut term) = pending.pop() {
            let Some((first, second)) = self.take_two(&mut term.monomial) else {
                terms.push(term);
                continue;
            };
            for (coefficient, atom) in self.product_to_sum(first, second) {
                let factor = [(atom, 1)];
                let factor = if atom == ONE { &[][..] } else { &factor[..] };
                pending.push(Term {
                    monomial: multiply_monomials(self.pool, &term.monomial, factor),
                    coefficient: term.coefficient.times(coefficient),
                });
            }
        }
    }

    /// Takes two sines or cosines out of a monomial, if it has as many.
    fn take_two(&self, monomial: &mut Monomial) -> Option<(Expr, Expr)> {
        let is_positive = |&&(atom, n): &&(Expr, i32)| n > 0 && is_trigonometric(self.pool, atom);
        let count: i32 = monomial.iter().filter(is_positive).map(|factor| factor.1.min(2)).sum();
        if count < 2 {
            return None;
        }
        let first = monomial.iter().find(is_positive)?.0;
        take_one(monomial, first);
        let second = monomial.iter().find(is_positive)?.0;
        take_one(monomial, second);
        Some((first, second))
    }

    /// The product of two sines or cosines as a sum.
    fn product_to_sum(&mut self, first: Expr, second: Expr) -> Vec<(Number, Expr)> {
        if let Some(known) = self.products.get(&(first, second)) {
            return known.clone();
        }
        let pool = self.pool;
        let (f, g) = (pool.node(first), pool.node(second));
        let is_row = |row: &&Product| (Op::Call(row.first), Op::Call(row.second)) == (f.op, g.op);
        let row = PRODUCTS.iter().find(is_row).expect("a row for each pair of calls");
        let call = |angle: Expr| pool.call_one(row.call, angle);
        let (x, y) = (call(pool.sub(f.left, g.left)), call(pool.add(f.left, g.left)));
        let weights = [row.of_difference, row.of_sum].map(|n| Number::rational(n, 2));
        let mut terms = Vec::with_capacity(2);
        for (call, weight) in [x, y].into_iter().zip(weights) {
            let (coefficient, atom) = pool.split_coefficient(call);
            if !coefficient.is_zero() {
                terms.push((coefficient.times(weight), atom));
            }
        }
        self.products.insert((first, second), terms.clone());
        terms
    }
}

/// The most negative power of each atom that has one in some term.
fn common_divisors(pool: &Pool, poly: &Poly) -> Monomial {
    let mut divisors = Monomial::new();
    for &(atom, n) in poly.iter().flat_map(|term| &term.monomial).filter(|factor| factor.1 < 0) {
        match divisors.iter_mut().find(|known| known.0 == atom) {
            Some(known) => known.1 = known.1.min(n),
            None => divisors.push((atom, n)),
        }
    }
    divisors.sort_by(|a, b| pool.canonical_order(a.0, b.0));
    divisors
}

/// Lowers the power of an atom by one.
pub(super) fn take_one(monomial: &mut Monomial, atom: Expr) {
    if let Some(index) = monomial.iter().position(|factor| factor.0 == atom) {
        monomial[index].1 -= 1;
        if monomial[index].1 == 0 {
            monomial.remove(index);
        }
    }
}

/// The terms as expressions, without any factoring.
pub(super) fn term_expr(pool: &Pool, term: &Term) -> Expr {
    let powers = term.monomial.iter().map(|&(atom, n)| pool.powi(atom, i64::from(n)));
    pool.product(powers.chain([pool.number(term.coefficient.clone())]))
}

/// The polynomial as a plain sum.
pub(super) fn sum_expr(pool: &Pool, poly: &Poly) -> Expr {
    pool.sum(poly.iter().map(|term| term_expr(pool, term)))
}
