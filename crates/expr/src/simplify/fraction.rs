//! Expressions as quotients of two polynomials, and these in lowest terms.

use super::gcd::{IntegerPoly, gcd};
use super::poly::{Algebra, Monomial, Poly, Term, collect};
use crate::handle::ExprMap;
use crate::number::Number;
use crate::op::Op;
use crate::pool::{Expr, Pool};
use num_bigint::BigInt;
use num_traits::{One, Zero};

/// Largest magnitude of a power that is multiplied out.
const MAX_POWER: u64 = 12;
/// Variables of a common divisor.
const MAX_VARIABLES: usize = 12;
/// Terms of either polynomial.
const MAX_TERMS: usize = 400;

/// A quotient of polynomials over atoms; no power is negative.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Fraction {
    pub(super) numerator: Poly,
    pub(super) denominator: Poly,
}

fn number(value: Number) -> Poly {
    vec![Term { monomial: Monomial::new(), coefficient: value }]
}

impl Fraction {
    /// The fraction of `e`; `None` when it takes more than the budget.
    pub(super) fn read(algebra: &mut Algebra<'_>, e: Expr) -> Option<Self> {
        let pool = algebra.pool;
        let sweep = pool.sweep(&[e]);
        // Atoms hide what is below them.
        let mut is_needed = vec![false; sweep.steps.len()];
        is_needed[sweep.roots[0]] = true;
        for (position, step) in sweep.steps.iter().enumerate().rev() {
            if is_needed[position] && is_open(pool, step.expr) {
                let exponent = usize::from(step.op == Op::Pow);
                let n_operands = sweep.operands(step).len();
                sweep.operands(step).take(n_operands - exponent).for_each(|o| is_needed[o] = true);
            }
        }

        let mut fractions: ExprMap<Self> = ExprMap::default();
        for (position, step) in sweep.steps.iter().enumerate() {
            if !is_needed[position] {
                continue;
            }
            let operands = sweep.operands(step).filter_map(|o| fractions.get(&sweep.steps[o].expr));
            let operands: Vec<Self> = operands.cloned().collect();
            let fraction = match step.op {
                _ if !is_open(pool, step.expr) => Self::atom(pool, step.expr),
                Op::Add => Self::sum(algebra, operands)?,
                Op::Mul => Self::product(algebra, operands)?,
                _ => {
                    let n = pool.split_power(step.expr).1;
                    let base = operands.into_iter().next()?;
                    let base = if n < 0 { base.inverse() } else { base };
                    let factors = usize::try_from(n.unsigned_abs()).ok()?;
                    Self::product(algebra, vec![base; factors])?
                }
            };
            fractions.insert(step.expr, fraction);
        }
        fractions.remove(&e)
    }

    fn atom(pool: &Pool, e: Expr) -> Self {
        let numerator = match pool.as_number(e) {
            Some(value) if value.is_zero() => Poly::new(),
            Some(value) => number(value),
            None => vec![Term { monomial: vec![(e, 1)], coefficient: Number::ONE }],
        };
        Self { numerator, denominator: number(Number::ONE) }
    }

    fn inverse(self) -> Self {
        Self { numerator: self.denominator, denominator: self.numerator }
    }

    fn product(algebra: &mut Algebra<'_>, factors: Vec<Self>) -> Option<Self> {
        let one = || number(Number::ONE);
        let mut product = Self { numerator: one(), denominator: one() };
        for factor in factors {
            product.numerator = algebra.multiply(&product.numerator, &factor.numerator, false)?;
            product.denominator =
                algebra.multiply(&product.denominator, &factor.denominator, false)?;
        }
        Some(product)
    }

    /// The sum over a common denominator; terms of one denominator come together first.
    fn sum(algebra: &mut Algebra<'_>, terms: Vec<Self>) -> Option<Self> {
        let pool = algebra.pool;
        let mut groups: Vec<Self> = Vec::new();
        for term in terms {
            match groups.iter_mut().find(|group| group.denominator == term.denominator) {
                Some(group) => group.numerator.extend(term.numerator),
                None => groups.push(term),
            }
        }
        let mut groups = groups.into_iter();
        let mut sum = groups.next()?;
        for group in groups {
            let left = algebra.multiply(&sum.numerator, &group.denominator, false)?;
            let right = algebra.multiply(&group.numerator, &sum.denominator, false)?;
            sum.numerator = left.into_iter().chain(right).collect();
            sum.denominator = algebra.multiply(&sum.denominator, &group.denominator, false)?;
        }
        sum.numerator = collect(pool, sum.numerator);
        Some(sum)
    }

    /// True if the denominator is a number.
    pub(super) fn is_polynomial(&self) -> bool {
        self.denominator.iter().all(|term| term.monomial.is_empty())
    }

    /// Fraction without the greatest common divisor of both, and that; `None` where it is not found.
    pub(super) fn in_lowest_terms(&self, pool: &Pool) -> Option<(Self, Poly)> {
        if self.denominator.is_empty() {
            return None;
        }
        if self.numerator.is_empty() {
            let zero = Self { numerator: Poly::new(), denominator: number(Number::ONE) };
            return Some((zero, self.denominator.clone()));
        }
        let both = [&self.numerator, &self.denominator];
        let mut atoms: Vec<Expr> = both
            .iter()
            .flat_map(|poly| poly.iter())
            .flat_map(|t| &t.monomial)
            .map(|f| f.0)
            .collect();
        atoms.sort_by(|&a, &b| pool.canonical_order(a, b));
        atoms.dedup();
        if atoms.len() > MAX_VARIABLES || both.iter().any(|poly| poly.len() > MAX_TERMS) {
            return None;
        }
        let (n, n_scale) = to_integers(&self.numerator, &atoms)?;
        let (d, d_scale) = to_integers(&self.denominator, &atoms)?;
        let common = gcd(&n, &d, atoms.len())?;
        let scaled = |poly: &IntegerPoly, by: &Number| of_integers(pool, poly, &atoms, by);
        let lowest = Self {
            numerator: scaled(&n.exact_quotient(&common)?, &d_scale.over(&n_scale)),
            denominator: scaled(&d.exact_quotient(&common)?, &Number::ONE),
        };
        Some((lowest, scaled(&common.primitive(), &Number::ONE)))
    }
}

/// True if a fraction looks into an expression.
fn is_open(pool: &Pool, e: Expr) -> bool {
    match pool.node(e).op {
        Op::Add | Op::Mul => true,
        Op::Pow => {
            let (base, n) = pool.split_power(e);
            base != e && n.unsigned_abs() <= MAX_POWER
        }
        _ => false,
    }
}

/// The polynomial times a number that makes all coefficients integers, and that number; `None` for
/// a float.
fn to_integers(poly: &Poly, atoms: &[Expr]) -> Option<(IntegerPoly, Number)> {
    let mut scale = BigInt::one();
    for term in poly {
        let (_, denominator) = term.coefficient.parts()?;
        if !(&scale % &denominator).is_zero() {
            scale *= denominator;
        }
    }
    let terms = poly.iter().map(|term| {
        let (numerator, denominator) = term.coefficient.parts()?;
        let exponent = |atom: &Expr| {
            let found = term.monomial.iter().find(|factor| factor.0 == *atom);
            found.map_or(Some(0), |factor| u32::try_from(factor.1).ok())
        };
        let exponents = atoms.iter().map(exponent).collect::<Option<Vec<u32>>>()?;
        Some((exponents, numerator * (&scale / denominator)))
    });
    let terms = terms.collect::<Option<_>>()?;
    Some((IntegerPoly(terms), Number::of_parts(scale, BigInt::one())))
}

fn of_integers(pool: &Pool, poly: &IntegerPoly, atoms: &[Expr], scale: &Number) -> Poly {
    let terms = poly.0.iter().map(|(exponents, coefficient)| {
        let powers = atoms.iter().zip(exponents).filter(|(_, n)| **n > 0);
        let monomial = powers.map(|(&atom, &n)| (atom, i32::try_from(n).unwrap_or(i32::MAX)));
        let coefficient = Number::of_parts(coefficient.clone(), BigInt::one()).times(scale);
        Term { monomial: monomial.collect(), coefficient }
    });
    collect(pool, terms.collect())
}
