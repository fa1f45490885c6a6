//! Exponentials and hyperbolic functions in polynomials.
//!
//! ```text
//! eᵃ eᵇ = eᵃ⁺ᵇ         sinh a = ½ (eᵃ − e⁻ᵃ)        sinh a / cosh a = tanh a
//!                      cosh a = ½ (eᵃ + e⁻ᵃ)
//! ```
//!
//! Written by exponentials, each term has one of them, so that cosh² a − sinh² a and sums of products
//! collapse by themselves; pairs of opposite exponents then become hyperbolic functions again. All
//! holds for every argument: neither exponentials nor hyperbolic cosines are ever zero.

use super::poly::{Algebra, Monomial, Poly, Term, collect, multiply_monomials};
use crate::number::Number;
use crate::op::{Function, Op};
use crate::pool::{Expr, Pool};
use std::collections::HashMap;

/// Largest power of a hyperbolic function that is written by exponentials.
const MAX_POWER: i32 = 6;

/// The forms worth comparing with a plain one; none without an exponential or hyperbolic function.
pub(super) fn exponential_forms(algebra: &mut Algebra<'_>, poly: &Poly) -> Vec<Poly> {
    let pool = algebra.pool;
    let split = without_hyperbolic_tangents(pool, poly);
    let mut forms = vec![merged(pool, poly), with_hyperbolic_tangents(pool, poly), split.clone()];
    if let Some(spread) = by_exponentials(algebra, &split) {
        let spread = merged(pool, &spread);
        forms.push(hyperbolic(pool, &spread));
        forms.push(spread);
    }
    forms
}

/// The argument of an atom that is a call of `function`.
fn argument(pool: &Pool, atom: Expr, function: Function) -> Option<Expr> {
    let node = pool.node(atom);
    (node.op == Op::Call(function)).then_some(node.left)
}

/// The product of a monomial and powers of atoms in any order.
fn times(pool: &Pool, monomial: &Monomial, powers: &[(Expr, i32)]) -> Monomial {
    powers
        .iter()
        .fold(monomial.clone(), |product, &power| multiply_monomials(pool, &product, &[power]))
}

/// The exponentials of each term as one.
fn merged(pool: &Pool, poly: &Poly) -> Poly {
    let terms = poly.iter().map(|term| {
        let (powers, rest): (Monomial, Monomial) =
            term.monomial.iter().partition(|f| argument(pool, f.0, Function::Exp).is_some());
        let exponents =
            powers.iter().map(|&(atom, n)| pool.mul(pool.int(i64::from(n)), pool.node(atom).left));
        let exponent = pool.expand(pool.sum(exponents.collect::<Vec<_>>()));
        let power = pool.exp(exponent);
        let is_number = powers.is_empty() || pool.is_one(power);
        let monomial = if is_number { rest } else { times(pool, &rest, &[(power, 1)]) };
        Term { monomial, coefficient: term.coefficient.clone() }
    });
    collect(pool, terms.collect())
}

/// tanhⁿ a as sinhⁿ a / coshⁿ a.
fn without_hyperbolic_tangents(pool: &Pool, poly: &Poly) -> Poly {
    let terms = poly.iter().map(|term| {
        let tangents = term
            .monomial
            .iter()
            .filter_map(|&(atom, n)| Some((atom, n, argument(pool, atom, Function::Tanh)?)));
        let monomial = tangents.fold(term.monomial.clone(), |monomial, (atom, n, a)| {
            times(pool, &monomial, &[(atom, -n), (pool.sinh(a), n), (pool.cosh(a), -n)])
        });
        Term { monomial, coefficient: term.coefficient.clone() }
    });
    collect(pool, terms.collect())
}

/// sinhⁿ a / coshⁿ a as tanhⁿ a.
fn with_hyperbolic_tangents(pool: &Pool, poly: &Poly) -> Poly {
    let terms = poly.iter().map(|term| {
        let mut monomial = term.monomial.clone();
        for &(divisor, n) in term.monomial.iter().filter(|factor| factor.1 < 0) {
            let Some(a) = argument(pool, divisor, Function::Cosh) else { continue };
            let sine = pool.sinh(a);
            let power = monomial.iter().find(|f| f.0 == sine).map_or(0, |f| f.1).min(-n);
            if power > 0 {
                let powers = [(sine, -power), (divisor, power), (pool.tanh(a), power)];
                monomial = times(pool, &monomial, &powers);
            }
        }
        Term { monomial, coefficient: term.coefficient.clone() }
    });
    collect(pool, terms.collect())
}

/// Hyperbolic sines and cosines by exponentials; divisors stay. `None` where that is too much.
fn by_exponentials(algebra: &mut Algebra<'_>, poly: &Poly) -> Option<Poly> {
    let pool = algebra.pool;
    let mut terms: Vec<Term> = Vec::new();
    for term in poly {
        let is_spread = |factor: &&(Expr, i32)| {
            let function = pool.node(factor.0).op;
            matches!(function, Op::Call(Function::Sinh | Function::Cosh))
                && (1..=MAX_POWER).contains(&factor.1)
        };
        let (calls, rest): (Monomial, Monomial) =
            term.monomial.iter().partition(|factor| is_spread(factor));
        let mut product = vec![Term { monomial: rest, coefficient: term.coefficient.clone() }];
        for (call, n) in calls {
            let is_sine = argument(pool, call, Function::Sinh).is_some();
            let a = pool.node(call).left;
            let half = |sign: i64| Number::rational(sign, 2);
            let of =
                |a: Expr, sign| Term { monomial: vec![(pool.exp(a), 1)], coefficient: half(sign) };
            let sum = collect(pool, vec![of(a, 1), of(pool.neg(a), if is_sine { -1 } else { 1 })]);
            for _ in 0..n {
                product = merged(pool, &algebra.multiply(&product, &sum, false)?);
            }
        }
        terms.extend(product);
    }
    Some(collect(pool, terms))
}

/// α eᵃ ± α e⁻ᵃ with equal cofactors as hyperbolic functions; what is left over stays.
fn hyperbolic(pool: &Pool, poly: &Poly) -> Poly {
    let exponent = |term: &Term| {
        let found = term.monomial.iter().find_map(|f| argument(pool, f.0, Function::Exp))?;
        Some((found, times(pool, &term.monomial, &[(pool.exp(found), -1)])))
    };
    let split: Vec<_> = poly.iter().map(exponent).collect();
    let index: HashMap<&(Expr, Monomial), usize> =
        split.iter().enumerate().filter_map(|(i, key)| Some((key.as_ref()?, i))).collect();
    let mut is_used = vec![false; poly.len()];
    let mut terms = Vec::new();
    for (i, key) in split.iter().enumerate() {
        if is_used[i] {
            continue;
        }
        is_used[i] = true;
        let partner = key.as_ref().and_then(|(a, rest)| {
            let other = *index.get(&(pool.neg(*a), rest.clone()))?;
            (!is_used[other]).then_some((other, *a, rest))
        });
        let Some((other, a, rest)) = partner else {
            terms.push(poly[i].clone());
            continue;
        };
        // α eᵃ + β e⁻ᵃ = (α + β) cosh a + (α − β) sinh a
        is_used[other] = true;
        let [alpha, beta] = [i, other].map(|k| &poly[k].coefficient);
        let parts = [(pool.cosh(a), alpha.plus(beta)), (pool.sinh(a), alpha.plus(beta.negated()))];
        for (call, weight) in parts {
            let (sign, call) = pool.split_coefficient(call);
            let coefficient = weight.times(sign);
            terms.push(Term { monomial: times(pool, rest, &[(call, 1)]), coefficient });
        }
    }
    collect(pool, terms)
}
