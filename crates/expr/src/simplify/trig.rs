//! From Fourier form back to products and squares, where that is shorter.
//!
//! The identities are rows of [`rules`](super::rules); here they are applied to polynomials.

use super::poly::{Monomial, Poly, Term, collect, is_trigonometric, multiply_monomials};
use super::rules::{Halving, SUMS};
use crate::number::Number;
use crate::op::{Function, Op};
use crate::pool::{Expr, ONE, PI, Pool, ZERO};
use std::collections::{BTreeMap, HashMap};

/// Splits a monomial into its sine or cosine, if it has exactly one to the first power and
/// nothing else trigonometric, and the cofactor.
fn split_call(pool: &Pool, monomial: &Monomial) -> Option<(Expr, Monomial)> {
    let mut call = ONE;
    let mut cofactor = Monomial::with_capacity(monomial.len());
    for &(atom, n) in monomial {
        if n > 0 && is_trigonometric(pool, atom) {
            if call != ONE || n != 1 {
                return None;
            }
            call = atom;
        } else {
            cofactor.push((atom, n));
        }
    }
    Some((call, cofactor))
}

/// Sine or cosine, and the angle; the number 1 is cos 0.
fn call_parts(pool: &Pool, call: Expr) -> (Function, Expr) {
    let node = pool.node(call);
    match node.op {
        Op::Call(Function::Sin) => (Function::Sin, node.left),
        Op::Call(_) => (Function::Cos, node.left),
        _ => (Function::Cos, ZERO),
    }
}

/// Largest denominator among the coefficients of an angle.
fn denominator(pool: &Pool, angle: Expr) -> i64 {
    let terms = pool.terms_of(angle).into_iter();
    terms.map(|(_, c)| c.short_parts().map_or(i64::MAX, |parts| parts.1)).max().unwrap_or(1)
}

fn halved(pool: &Pool, angle: Expr) -> Expr {
    pool.sum(
        pool.terms_of(angle)
            .into_iter()
            .map(|(monic, c)| pool.scaled(c.times(Number::rational(1, 2)), monic)),
    )
}

/// The angles in a polynomial that are twice a simpler one, in canonical order.
pub(super) fn doubled_angles(pool: &Pool, poly: &Poly) -> Vec<Expr> {
    let atoms = poly.iter().flat_map(|term| &term.monomial).map(|factor| factor.0);
    let calls = atoms.filter(|&atom| is_trigonometric(pool, atom));
    let mut angles: Vec<Expr> = calls.map(|call| pool.node(call).left).collect();
    angles.sort_by(|&a, &b| pool.canonical_order(a, b));
    angles.dedup();
    angles.retain(|&angle| denominator(pool, halved(pool, angle)) == denominator(pool, angle));
    angles
}

/// Rewrites the first powers of the sine and cosine of `angle`.
pub(super) fn halve(pool: &Pool, poly: &Poly, angle: Expr, halving: Halving) -> Poly {
    let half = halved(pool, angle);
    let term = |monomial: Monomial, c: i64| Term { monomial, coefficient: Number::from(c) };
    let cosine = halving.cosine.map(|(factor, call, constant)| {
        let call = pool.call_one(call, half);
        [term(vec![(call, 2)], factor), term(Vec::new(), constant)]
    });
    let sine = halving.sine.then(|| {
        [term(multiply_monomials(pool, &[(pool.sin(half), 1)], &[(pool.cos(half), 1)]), 2)]
    });
    let mut terms = Vec::with_capacity(2 * poly.len());
    for term in poly {
        let found = term.monomial.iter().find(|&&(atom, n)| {
            n == 1 && is_trigonometric(pool, atom) && pool.node(atom).left == angle
        });
        let replacement: Option<(Expr, &[Term])> = found.and_then(|&(call, _)| {
            let of_call = match call_parts(pool, call).0 {
                Function::Cos => cosine.as_ref().map(<[Term; 2]>::as_slice),
                _ => sine.as_ref().map(<[Term; 1]>::as_slice),
            };
            Some((call, of_call?))
        });
        let Some((call, replacement)) = replacement else {
            terms.push(term.clone());
            continue;
        };
        let cofactor = multiply_monomials(pool, &term.monomial, &[(call, -1)]);
        terms.extend(replacement.iter().map(|part| Term {
            monomial: multiply_monomials(pool, &cofactor, &part.monomial),
            coefficient: term.coefficient.times(&part.coefficient),
        }));
    }
    collect(pool, terms)
}

/// Constant phases as sums: sin(a + ⅙π) = ½ √3 sin a + ½ cos a; `None` without such a term.
///
/// Side condition: the sine and cosine of the phase are known exactly, at multiples of ⅙π and ¼π.
pub(super) fn without_phases(pool: &Pool, poly: &Poly) -> Option<Poly> {
    let mut found = false;
    let mut terms = Vec::with_capacity(poly.len());
    for term in poly {
        let split = split_call(pool, &term.monomial)
            .and_then(|(call, cofactor)| Some((split_phase(pool, call)?, cofactor)));
        let Some((parts, cofactor)) = split else {
            terms.push(term.clone());
            continue;
        };
        found = true;
        terms.extend(parts.into_iter().map(|(call, weight)| {
            let (c, root) = pool.split_coefficient(weight);
            let root = if root == ONE { Vec::new() } else { vec![(root, 1)] };
            let (sign, call) = pool.split_coefficient(call);
            let call = multiply_monomials(pool, &cofactor, &[(call, 1)]);
            Term {
                monomial: multiply_monomials(pool, &call, &root),
                coefficient: term.coefficient.times(c).times(sign),
            }
        }));
    }
    found.then(|| collect(pool, terms))
}

/// A call at an angle plus a constant phase as two calls at the angle, each with its weight.
fn split_phase(pool: &Pool, call: Expr) -> Option<[(Expr, Expr); 2]> {
    if call == ONE {
        return None;
    }
    let (function, angle) = call_parts(pool, call);
    let (phase, rest): (Vec<_>, Vec<_>) =
        pool.terms_of(angle).into_iter().partition(|&(monic, _)| monic == PI);
    let [(_, turns)] = phase.as_slice() else { return None };
    let phase = pool.scaled(turns.clone(), PI);
    let (sine, cosine) = (pool.sin(phase), pool.cos(phase));
    let rest = pool.sum_of(rest);
    let is_exact = !pool.has_call(sine) && !pool.has_call(cosine) && !pool.is_zero(rest);
    is_exact.then(|| match function {
        Function::Cos => [(pool.cos(rest), cosine), (pool.sin(rest), pool.neg(sine))],
        _ => [(pool.sin(rest), cosine), (pool.cos(rest), sine)],
    })
}

/// Two terms of one cofactor that merge into a product of two calls.
struct MergingPair {
    terms: (usize, usize),
    calls: (Expr, Expr),
    product: Term,
}

/// Merges pairs of terms into products, preferring calls that occur in many of the products.
pub(super) fn products(pool: &Pool, poly: &Poly) -> Poly {
    let mut pairs = all_pairs(pool, poly);
    let mut is_used = vec![false; poly.len()];
    let mut result = Vec::new();
    while let Some(best) = most_frequent_call(pool, poly, &pairs, &is_used) {
        let mut progressed = false;
        for pair in &pairs {
            let (i, j) = pair.terms;
            let has_best = pair.calls.0 == best || pair.calls.1 == best;
            if has_best && !is_used[i] && !is_used[j] {
                (is_used[i], is_used[j]) = (true, true);
                result.push(pair.product.clone());
                progressed = true;
            }
        }
        if !progressed {
            break;
        }
        pairs.retain(|pair| !is_used[pair.terms.0] && !is_used[pair.terms.1]);
    }
    result.extend(poly.iter().zip(&is_used).filter(|(_, used)| !**used).map(|(t, _)| t.clone()));
    collect(pool, result)
}

/// The call that most remaining products share.
fn most_frequent_call(
    pool: &Pool,
    poly: &Poly,
    pairs: &[MergingPair],
    is_used: &[bool],
) -> Option<Expr> {
    let mut counts: BTreeMap<Expr, usize> = BTreeMap::new();
    for pair in pairs {
        let (a, b) = pair.calls;
        *counts.entry(a).or_default() += 2;
        if a != b {
            *counts.entry(b).or_default() += 2;
        }
    }
    // A call that is alone in some term costs nothing more.
    for (term, _) in poly.iter().zip(is_used).filter(|(_, used)| !**used) {
        for (atom, _) in &term.monomial {
            if let Some(count) = counts.get_mut(atom) {
                *count += 1;
            }
        }
    }
    counts
        .into_iter()
        .max_by(|a, b| a.1.cmp(&b.1).then_with(|| pool.canonical_order(b.0, a.0)))
        .map(|(call, _)| call)
}

/// All pairs of terms with equal cofactor and equal or opposite coefficient.
fn all_pairs(pool: &Pool, poly: &Poly) -> Vec<MergingPair> {
    let mut groups: Vec<(Monomial, Vec<(usize, Expr)>)> = Vec::new();
    let mut known: HashMap<Monomial, usize> = HashMap::new();
    for (index, term) in poly.iter().enumerate() {
        if let Some((call, cofactor)) = split_call(pool, &term.monomial) {
            let group = *known.entry(cofactor).or_insert_with_key(|cofactor| {
                groups.push((cofactor.clone(), Vec::new()));
                groups.len() - 1
            });
            groups[group].1.push((index, call));
        }
    }
    let mut pairs = Vec::new();
    for (cofactor, calls) in groups {
        for (n, &(i, x)) in calls.iter().enumerate() {
            for &(j, y) in &calls[n + 1..] {
                let [a, b] = [i, j].map(|k| poly[k].coefficient.clone());
                if a.magnitude() == b.magnitude() {
                    let product = product_of(pool, (x, a), (y, b));
                    pairs.extend(product.map(|(calls, coefficient)| {
                        let factors = multiply_monomials(pool, &[(calls.0, 1)], &[(calls.1, 1)]);
                        let monomial = multiply_monomials(pool, &cofactor, &factors);
                        MergingPair {
                            terms: (i, j),
                            calls,
                            product: Term { monomial, coefficient },
                        }
                    }));
                }
            }
        }
    }
    // Which of two overlapping pairs is taken must not depend on the order of building.
    pairs.sort_by(|p, q| {
        pool.canonical_order(p.calls.0, q.calls.0)
            .then_with(|| pool.canonical_order(p.calls.1, q.calls.1))
    });
    pairs
}

/// a x + b y with |a| = |b| as a coefficient times two calls; `None` if halved angles appear or
/// nothing is won.
fn product_of(
    pool: &Pool,
    (x, a): (Expr, Number),
    (y, b): (Expr, Number),
) -> Option<((Expr, Expr), Number)> {
    let ((call_x, angle_x), (call_y, angle_y)) = (call_parts(pool, x), call_parts(pool, y));
    let sign = if a.is_negative() == b.is_negative() { 1 } else { -1 };
    let row = SUMS.iter().find(|row| (row.call, row.call, row.sign) == (call_x, call_y, sign))?;
    let half_sum = halved(pool, pool.add(angle_x, angle_y));
    let half_difference = halved(pool, pool.sub(angle_x, angle_y));
    let allowed = denominator(pool, angle_x).max(denominator(pool, angle_y));
    if denominator(pool, half_sum) > allowed || denominator(pool, half_difference) > allowed {
        return None;
    }
    let first = pool.call_one(row.of_sum, half_sum);
    let second = pool.call_one(row.of_difference, half_difference);
    let ((c, first), (d, second)) = (pool.split_coefficient(first), pool.split_coefficient(second));
    let are_calls = is_trigonometric(pool, first) && is_trigonometric(pool, second);
    let coefficient = a.times(Number::from(row.factor)).times(c).times(d);
    are_calls.then_some(((first, second), coefficient))
}

/// sinⁿ a / cosⁿ a = tanⁿ a; `None` where there is no such quotient.
pub(super) fn with_tangents(pool: &Pool, poly: &Poly) -> Option<Poly> {
    let mut found = false;
    let mut terms = Vec::with_capacity(poly.len());
    for term in poly {
        let mut monomial = term.monomial.clone();
        let divisors = term.monomial.iter().filter(|f| f.1 < 0);
        for &(cosine, n) in divisors.filter(|f| pool.node(f.0).op == Op::Call(Function::Cos)) {
            let angle = call_parts(pool, cosine).1;
            let sine = pool.sin(angle);
            let power = monomial.iter().find(|f| f.0 == sine).map_or(0, |f| f.1).min(-n);
            if power > 0 {
                found = true;
                for (atom, exponent) in [(sine, -power), (cosine, power), (pool.tan(angle), power)]
                {
                    monomial = multiply_monomials(pool, &monomial, &[(atom, exponent)]);
                }
            }
        }
        terms.push(Term { monomial, coefficient: term.coefficient.clone() });
    }
    found.then(|| collect(pool, terms))
}
