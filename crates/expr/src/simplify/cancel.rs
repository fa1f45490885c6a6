//! Cancellation: common factors of quotients, and functions undone by their inverses, under conditions
//! that are stated.
//!
//! ```text
//! (a² − b²)/(a − b) = a + b     where a − b is not zero
//! exp(ln x) = x                 where x is not negative
//! ```
//!
//! `simplify` keeps the value wherever there is one, and no value where there is none; what is
//! cancelled here has a value in more places or in fewer. As of the solution of linear equations,
//! the conditions are expressions that must not be zero, or not negative.

use super::budget::{BUDGET, FORM_BUDGET, Meter};
use super::cost::CostModel;
use super::driver::parts;
use super::factor::{Preference, factored};
use super::fraction::Fraction;
use super::inverse::Condition;
use super::poly::Algebra;
use crate::op::{Function, Op};
use crate::pool::{Expr, Pool};

/// Expressions in which what is common to numerators and denominators is cancelled.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Cancelled {
    /// One expression for each one given.
    pub roots: Vec<Expr>,
    /// Expressions that must not be zero for the values to be the same.
    pub nonzero: Vec<Expr>,
    /// Expressions that must not be negative for the values to be the same.
    pub not_negative: Vec<Expr>,
}

impl Pool {
    /// Simplifies expressions as [`Pool::simplify_all`], and cancels what they have in common with
    /// their divisors: the greatest common divisor of numerator and denominator. Functions undone by
    /// their inverses fold. The result states the conditions under which the values are the same.
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let e = pool.parse("(a^2 - b^2)/(a - b) + exp(ln(x))").expect("valid");
    /// let cancelled = pool.cancel(&[e]);
    /// assert_eq!(pool.to_text(cancelled.roots[0]), "a + b + x");
    /// assert_eq!(pool.to_text(cancelled.nonzero[0]), "a - b");
    /// assert_eq!(pool.to_text(cancelled.not_negative[0]), "x");
    /// ```
    pub fn cancel(&self, roots: &[Expr]) -> Cancelled {
        let simple = self.simplify_all(roots);
        let mut canceller = Canceller {
            pool: self,
            model: CostModel::new(self, Meter::new(BUDGET, roots.len())),
            algebra: Algebra::new(self, 0),
            conditions: Vec::new(),
        };
        let cancelled = canceller.run(&simple);
        let mut result = Cancelled {
            roots: self.simplify_all(&cancelled),
            nonzero: Vec::new(),
            not_negative: Vec::new(),
        };
        for condition in canceller.conditions {
            let (list, e) = match condition {
                Condition::NotZero(e) if self.is_never_zero(e) => continue,
                Condition::NotNegative(e) if self.is_never_negative(e) => continue,
                Condition::NotZero(e) => (&mut result.nonzero, e),
                Condition::NotNegative(e) => (&mut result.not_negative, e),
            };
            if !list.contains(&e) {
                list.push(e);
            }
        }
        result
    }
}

struct Canceller<'p> {
    pool: &'p Pool,
    model: CostModel<'p>,
    algebra: Algebra<'p>,
    conditions: Vec<Condition>,
}

impl Canceller<'_> {
    fn run(&mut self, roots: &[Expr]) -> Vec<Expr> {
        let pool = self.pool;
        let sweep = pool.sweep(roots);
        let is_part = parts(pool, &sweep);
        let mut images: Vec<Expr> = Vec::with_capacity(sweep.steps.len());
        for (position, step) in sweep.steps.iter().enumerate() {
            let operands: Vec<Expr> = sweep.operands(step).map(|o| images[o]).collect();
            let is_unchanged = sweep.operands(step).all(|o| images[o] == sweep.steps[o].expr);
            let mut image = if is_unchanged { step.expr } else { pool.rebuild(step, &operands) };
            if let Some((folded, condition)) = pool.fold_under_condition(image) {
                self.conditions.push(condition);
                image = folded;
            }
            // A quotient among the terms of a sum cancels by itself.
            let factors = if step.op == Op::Mul { pool.operands_of(image) } else { Vec::new() };
            let is_quotient = factors.iter().any(|&factor| pool.split_power(factor).1 < 0);
            if step.op != Op::Pair && (is_part[position] || is_quotient) {
                image = self.reduced(image);
            }
            images.push(image);
        }
        sweep.roots.iter().map(|&root| images[root]).collect()
    }

    /// One expression as a fraction in lowest terms, where that is cheaper.
    fn reduced(&mut self, e: Expr) -> Expr {
        let pool = self.pool;
        let is_chain = matches!(pool.node(e).op, Op::Add | Op::Mul | Op::Pow);
        if !is_chain || pool.is_singular(e) || self.model.meter.has_ended() {
            return e;
        }
        let granted = FORM_BUDGET.min(self.model.meter.left());
        self.algebra.budget = granted;
        let fraction = Fraction::read(&mut self.algebra, e);
        self.model.meter.spend(granted - self.algebra.budget);
        let Some(fraction) = fraction.filter(|fraction| !fraction.is_polynomial()) else {
            return e;
        };
        let Some((lowest, common)) = fraction.in_lowest_terms(pool) else { return e };
        let written = |poly| factored(pool, poly, Preference::Frequent);
        let quotient = pool.div(written(&lowest.numerator), written(&lowest.denominator));
        if self.model.cost(quotient) >= self.model.cost(e) {
            return e;
        }
        // Each factor of what was cancelled is a condition of its own.
        for (mut factor, _) in pool.factors(written(&common)) {
            // A root or magnitude is zero where its argument is.
            while let Op::Call(Function::Sqrt | Function::Abs) = pool.node(factor).op {
                factor = pool.node(factor).left;
            }
            if pool.looks_negative(factor) {
                factor = pool.neg(factor);
            }
            if pool.as_number(factor).is_none() {
                self.conditions.push(Condition::NotZero(factor));
            }
        }
        quotient
    }
}
