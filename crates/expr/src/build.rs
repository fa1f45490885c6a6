//! Constructors: every expression is put into canonical form as it is built.
//!
//! Local folding only: numbers are computed, like terms and equal factors are collected, integer
//! powers distribute over products, signs move out of odd and even functions, angles are linear
//! forms. A quotient is a product with a negative power, a difference a sum with a negative
//! coefficient. Nothing here shrinks the domain, and factors that may be zero do not cancel.
//!
//! The form does not depend on the order of building, with two exceptions that keep it short and
//! building fast: a number times a sum stays one term, so that `(a + b) + (a + b) + c` may be
//! `2 a + 2 b + c` or `2 (a + b) + c`; and chains beyond [`MERGE_LIMIT`] are built of pieces.
//! `simplify` removes both.

use crate::number::Number;
use crate::op::{Function, Op};
use crate::pool::{Expr, MINUS_ONE, ONE, PI, Pool, ZERO, fact};

/// Terms or factors up to which a chain is merged into another one. Longer chains enter as one
/// operand, which keeps building a chain of a million terms linear.
pub(crate) const MERGE_LIMIT: u32 = 32;

/// A sum as pairs of coefficient-free term and coefficient; that of [`ONE`] is the constant.
pub(crate) type Terms = Vec<(Expr, Number)>;

// Numbers.
impl Pool {
    /// The number 0.
    pub fn zero(&self) -> Expr {
        ZERO
    }

    /// The number 1.
    pub fn one(&self) -> Expr {
        ONE
    }

    /// The constant π, kept symbolic.
    pub fn pi(&self) -> Expr {
        PI
    }

    /// An integer.
    pub fn int(&self, value: i64) -> Expr {
        self.number(Number::from(value))
    }

    /// The fraction `numerator / denominator`.
    pub fn rational(&self, numerator: i64, denominator: i64) -> Expr {
        self.number(Number::rational(numerator, denominator))
    }

    /// A float; integral values become exact.
    pub fn float(&self, value: f64) -> Expr {
        self.number(Number::float(value))
    }

    /// True if `e` is the number 0.
    pub fn is_zero(&self, e: Expr) -> bool {
        e == ZERO || self.as_number(e).is_some_and(|n| n.is_zero())
    }

    /// True if `e` is the number 1.
    pub fn is_one(&self, e: Expr) -> bool {
        e == ONE
    }
}

// Sums.
impl Pool {
    /// `a + b`
    pub fn add(&self, a: Expr, b: Expr) -> Expr {
        if a == ZERO {
            return b;
        }
        if b == ZERO {
            return a;
        }
        self.sum([a, b])
    }

    /// `a − b`
    pub fn sub(&self, a: Expr, b: Expr) -> Expr {
        if a == b && !self.has_fact(a, fact::POISONED) {
            return ZERO;
        }
        self.add(a, self.neg(b))
    }

    /// `−a`
    pub fn neg(&self, a: Expr) -> Expr {
        self.mul(MINUS_ONE, a)
    }

    /// The sum of all terms; like terms are collected.
    pub fn sum(&self, terms: impl IntoIterator<Item = Expr>) -> Expr {
        let mut collected = Terms::new();
        for term in terms {
            self.push_terms(term, &mut collected);
        }
        self.sum_of(collected)
    }

    /// Splits `e` into its numeric coefficient and the rest.
    pub(crate) fn split_coefficient(&self, e: Expr) -> (Number, Expr) {
        if let Some(number) = self.as_number(e) {
            return (number, ONE);
        }
        let node = self.node(e);
        match self.as_number(node.left) {
            Some(coefficient) if node.op == Op::Mul => (coefficient, node.right),
            _ => (Number::ONE, e),
        }
    }

    /// `coefficient · monic` for a `monic` without a coefficient of its own.
    pub(crate) fn scaled(&self, coefficient: Number, monic: Expr) -> Expr {
        if monic == ONE {
            return self.number(coefficient);
        }
        if coefficient.is_one() {
            return monic;
        }
        if coefficient.is_zero() {
            if !self.has_fact(monic, fact::POISONED) {
                return ZERO;
            }
            // Only factors without a value are kept: 0 · x · (1/0) is 0 · (1/0).
            let node = self.node(monic);
            if node.op == Op::Mul && node.data <= MERGE_LIMIT {
                let factors = self.chain(monic, Op::Mul).into_iter();
                let poisoned = factors.filter(|&f| self.has_fact(f, fact::POISONED));
                let poisoned: Vec<_> = poisoned.collect();
                if poisoned.len() < node.data as usize {
                    return self.product(poisoned.into_iter().chain([self.number(coefficient)]));
                }
            }
        }
        let is_short_sum = self.node(monic).op == Op::Add && self.node(monic).data <= MERGE_LIMIT;
        // −(a − b) is b − a, whichever was built first.
        if coefficient == Number::MINUS_ONE && is_short_sum {
            return self.negated_sum(monic);
        }
        if is_short_sum && self.looks_negative(monic) {
            let flipped = self.negated_sum(monic);
            return self.intern(Op::Mul, self.number(coefficient.negated()), flipped, 2);
        }
        self.intern(Op::Mul, self.number(coefficient), monic, 2)
    }

    fn negated_sum(&self, sum: Expr) -> Expr {
        let mut terms = self.terms_of(sum);
        for term in &mut terms {
            term.1 = term.1.negated();
        }
        self.chain_of_terms(&terms)
    }

    /// Appends `e` term by term, looking into sums that are short enough.
    fn push_terms(&self, e: Expr, terms: &mut Terms) {
        let (scale, monic) = self.split_coefficient(e);
        let node = self.node(monic);
        let is_unit = scale.magnitude().is_one();
        if node.op == Op::Add && node.data <= MERGE_LIMIT && is_unit {
            let inner = self.terms_of(monic);
            terms.extend(inner.into_iter().map(|(m, c)| (m, c.times(&scale))));
        } else {
            terms.push((monic, scale));
        }
    }

    /// The terms of a sum of any length in canonical order; any other expression is one term.
    pub(crate) fn terms_of(&self, e: Expr) -> Terms {
        self.chain(e, Op::Add)
            .into_iter()
            .map(|term| {
                let (coefficient, monic) = self.split_coefficient(term);
                (monic, coefficient)
            })
            .collect()
    }

    /// The operands of a chain of `op`; any other expression is its only operand.
    pub(crate) fn chain(&self, e: Expr, op: Op) -> Vec<Expr> {
        let mut node = self.node(e);
        if node.op != op {
            return vec![e];
        }
        let mut operands = Vec::with_capacity(node.data as usize);
        for _ in 2..node.data {
            operands.push(node.right);
            node = self.node(node.left);
        }
        operands.push(node.right);
        operands.push(node.left);
        operands.reverse();
        operands
    }

    /// Collects like terms and builds the sum.
    pub(crate) fn sum_of(&self, terms: Terms) -> Expr {
        self.chain_of_terms(&self.merged_terms(terms))
    }

    /// Puts terms into canonical order and adds the coefficients of like terms.
    fn merged_terms(&self, mut terms: Terms) -> Terms {
        if terms.len() > 1 {
            let order = self.ordering();
            terms.sort_by(|a, b| order.compare(a.0, b.0));
        }
        terms.dedup_by(|next, kept| {
            let is_like = next.0 == kept.0;
            if is_like {
                kept.1 = kept.1.plus(&next.1);
            }
            is_like
        });
        terms.retain(|&(monic, ref c)| !c.is_zero() || self.has_fact(monic, fact::POISONED));
        terms
    }

    /// Builds the left-leaning chain of terms already in canonical order.
    fn chain_of_terms(&self, terms: &[(Expr, Number)]) -> Expr {
        let mut terms = terms.iter().map(|(monic, c)| self.scaled(c.clone(), *monic));
        let Some(first) = terms.next() else { return ZERO };
        let (mut sum, mut count) = (first, 1);
        for term in terms {
            count += 1;
            sum = self.intern(Op::Add, sum, term, count);
        }
        sum
    }
}

// Products and powers.
impl Pool {
    /// `a · b`
    pub fn mul(&self, a: Expr, b: Expr) -> Expr {
        if a == ONE {
            return b;
        }
        if b == ONE {
            return a;
        }
        self.product([a, b])
    }

    /// `a / b`
    pub fn div(&self, a: Expr, b: Expr) -> Expr {
        self.mul(a, self.powi(b, -1))
    }

    /// The product of all factors; equal bases are collected.
    pub fn product(&self, factors: impl IntoIterator<Item = Expr>) -> Expr {
        let mut coefficient = Number::ONE;
        let mut bases: Vec<(Expr, i64)> = Vec::new();
        for factor in factors {
            let (c, monic) = self.split_coefficient(factor);
            coefficient = coefficient.times(c);
            let node = self.node(monic);
            if node.op == Op::Mul && node.data <= MERGE_LIMIT {
                let inner = self.chain(monic, Op::Mul);
                bases.extend(inner.into_iter().map(|f| self.split_power(f)));
            } else if monic != ONE {
                bases.push(self.split_power(monic));
            }
        }
        // Zero swallows all that has a value: 0 · x · (1/0) is 0/0.
        if coefficient.is_zero() {
            bases.retain(|&(base, _)| base == ZERO || self.has_fact(base, fact::POISONED));
        }
        // The sign of each sum moves into the coefficient, so that (a − b) c and (b − a) c are
        // alike.
        if bases.len() > 1 || !coefficient.magnitude().is_one() {
            for base in &mut bases {
                if self.node(base.0).op == Op::Add && self.looks_negative(base.0) {
                    base.0 = self.neg(base.0);
                    coefficient = if base.1 % 2 == 0 { coefficient } else { coefficient.negated() };
                }
            }
        }
        self.scaled_product(coefficient, bases)
    }

    /// Collects powers of equal bases and builds the product.
    pub(crate) fn scaled_product(&self, mut coefficient: Number, bases: Vec<(Expr, i64)>) -> Expr {
        let mut merged = self.merged_powers(bases);
        let mut factors = Vec::with_capacity(merged.len());
        // A power may fold to a product again, |a|³ = a² |a|, and its factors join the others.
        loop {
            let mut has_folded = false;
            let mut folded = Vec::new();
            factors.clear();
            for &(base, exponent) in &merged {
                let power = self.powi(base, exponent);
                if self.split_power(power) == (base, exponent) {
                    factors.push(power);
                    folded.push((base, exponent));
                    continue;
                }
                has_folded = true;
                let (c, monic) = self.split_coefficient(power);
                coefficient = coefficient.times(c);
                // A long product stays one factor, or products of products go quadratic.
                let node = self.node(monic);
                if node.op == Op::Mul && node.data <= MERGE_LIMIT {
                    let inner = self.chain(monic, Op::Mul);
                    folded.extend(inner.into_iter().map(|f| self.split_power(f)));
                } else if monic != ONE {
                    folded.push(self.split_power(monic));
                }
            }
            if !has_folded {
                break;
            }
            merged = self.merged_powers(folded);
        }

        // The left-leaning chain in canonical order.
        factors.sort_by(|a, b| self.canonical_order(*a, *b));
        let mut factors = factors.into_iter();
        let Some(first) = factors.next() else { return self.number(coefficient) };
        let (mut product, mut count) = (first, 1);
        for factor in factors {
            count += 1;
            product = self.intern(Op::Mul, product, factor, count);
        }
        self.scaled(coefficient, product)
    }

    /// Adds the exponents of equal bases. Positive and negative powers stay apart: x/x has no
    /// value at zero. Those of π, which is none, cancel.
    fn merged_powers(&self, mut bases: Vec<(Expr, i64)>) -> Vec<(Expr, i64)> {
        if bases.len() > 1 {
            let order = self.ordering();
            bases.sort_by(|a, b| order.compare(a.0, b.0).then((a.1 < 0).cmp(&(b.1 < 0))));
        }
        bases.dedup_by(|next, kept| {
            let is_alike = (next.1 < 0) == (kept.1 < 0) || self.node(next.0).op == Op::Pi;
            let is_like = next.0 == kept.0 && is_alike;
            if is_like {
                kept.1 = kept.1.saturating_add(next.1);
            }
            is_like
        });
        bases.retain(|&(_, exponent)| exponent != 0);
        bases
    }

    /// Splits `base^n` for an integer `n`; anything else is its own first power.
    pub(crate) fn split_power(&self, e: Expr) -> (Expr, i64) {
        let node = self.node(e);
        let exponent = || self.as_number(node.right).and_then(|n| n.as_integer());
        match node.op {
            Op::Pow => exponent().map_or((e, 1), |n| (node.left, n)),
            _ => (e, 1),
        }
    }

    /// `a^b`
    pub fn pow(&self, a: Expr, b: Expr) -> Expr {
        let Some(exponent) = self.as_number(b) else {
            return if a == ONE { ONE } else { self.intern(Op::Pow, a, b, 0) };
        };
        if let Some(n) = exponent.as_integer() {
            return self.powi(a, n);
        }
        if exponent == Number::rational(1, 2) {
            return self.sqrt(a);
        }
        if a == ZERO && !exponent.is_negative() && exponent.is_exact() {
            return ZERO;
        }
        if let Some(base) = self.as_number(a) {
            let value = crate::op::power(base.to_f64(), exponent.to_f64());
            let is_inexact = !base.is_exact() || !exponent.is_exact();
            if base.is_one() || (is_inexact && value.is_finite()) {
                return self.float(value);
            }
        }
        self.intern(Op::Pow, a, b, 0)
    }

    /// `a^n` for an integer `n`.
    pub fn powi(&self, a: Expr, n: i64) -> Expr {
        if n == 0 {
            return ONE;
        }
        if n == 1 {
            return a;
        }
        // All negative powers of zero are one infinity.
        let n = if a == ZERO && n < 0 { -1 } else { n };
        let plain = || self.intern(Op::Pow, a, self.int(n), 0);

        // Numbers are computed, other powers folded by their base.
        if let Some(number) = self.as_number(a) {
            let value = number.power(n).filter(|value| value.is_finite() && number.is_finite());
            return value.map_or_else(plain, |value| self.number(value));
        }
        let node = self.node(a);
        match node.op {
            Op::Pow => match self.split_power(a) {
                (base, m) if base != a => match m.checked_mul(n) {
                    Some(exponent) => self.powi(base, exponent),
                    None => plain(),
                },
                _ => plain(),
            },
            Op::Mul => self.power_of_product(a, n).unwrap_or_else(plain),
            Op::Add if self.looks_negative(a) && node.data <= MERGE_LIMIT => {
                let power = self.intern(Op::Pow, self.neg(a), self.int(n), 0);
                if n % 2 == 0 { power } else { self.neg(power) }
            }
            // |x|² is x².
            Op::Call(Function::Abs) => self.powi_by_square(a, self.powi(node.left, 2), n),
            // sqrt(x)² is x where x cannot be negative.
            Op::Call(Function::Sqrt) if self.is_never_negative(node.left) => {
                self.powi_by_square(a, node.left, n)
            }
            _ => plain(),
        }
    }

    /// `a^n` for an `a` with a known square: that to the power n/2, times one `a` if n is odd.
    fn powi_by_square(&self, a: Expr, square: Expr, n: i64) -> Expr {
        let even = self.powi(square, n / 2);
        match n % 2 {
            0 => even,
            // Nothing to fold in 1/a.
            odd if n == odd => self.intern(Op::Pow, a, self.int(n), 0),
            odd => self.mul(even, self.powi(a, odd)),
        }
    }

    /// (c a b)^n = c^n a^n b^n for an integer n and a chain that is short enough.
    fn power_of_product(&self, a: Expr, n: i64) -> Option<Expr> {
        let (coefficient, monic) = self.split_coefficient(a);
        let scale = coefficient.power(n).filter(Number::is_finite)?;
        if self.node(monic).data > MERGE_LIMIT {
            return None;
        }
        let powers = self.chain(monic, Op::Mul).into_iter().map(|f| self.powi(f, n));
        Some(self.product(powers.chain([self.number(scale)])))
    }

    /// True if the value can be shown never to be below zero.
    pub(crate) fn is_never_negative(&self, e: Expr) -> bool {
        self.has_fact(e, fact::NOT_NEGATIVE)
    }
}
