//! From Fourier form back to products and squares, where that is shorter.
//!
//! ```text
//! cos x + cos y =  2 cos ½(x+y) cos ½(x−y)      1 + cos x = 2 cos² ½x
//! cos x − cos y = −2 sin ½(x+y) sin ½(x−y)      1 − cos x = 2 sin² ½x
//! sin x ± sin y =  2 sin ½(x±y) cos ½(x∓y)      sin x = 2 sin ½x cos ½x
//! ```

use super::poly::{Monomial, Poly, Term, collect, is_trigonometric, multiply_monomials};
use crate::number::Number;
use crate::op::{Function, Op};
use crate::pool::{Expr, ONE, Pool, ZERO};
use std::collections::BTreeMap;

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

/// Whether the call is a cosine, and its angle; the number 1 is cos 0.
fn call_parts(pool: &Pool, call: Expr) -> (bool, Expr) {
    if call == ONE {
        return (true, ZERO);
    }
    let node = pool.node(call);
    (node.op == Op::Call(Function::Cos), node.left)
}

/// Largest denominator among the coefficients of an angle.
fn denominator(pool: &Pool, angle: Expr) -> i128 {
    let terms = pool.terms_of(angle).into_iter();
    terms.map(|(_, c)| c.as_rational().map_or(i128::MAX, |r| *r.denom())).max().unwrap_or(1)
}

fn halved(pool: &Pool, angle: Expr) -> Expr {
    pool.sum(
        pool.terms_of(angle)
            .into_iter()
            .map(|(monic, c)| pool.scaled(c.times(Number::rational(1, 2)), monic)),
    )
}

/// How the calls of one doubled angle are rewritten in terms of the angle itself.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Halving {
    /// cos 2a = 2 cos² a − 1 (`Some(true)`) or 1 − 2 sin² a (`Some(false)`).
    pub(super) cosine: Option<bool>,
    /// sin 2a = 2 sin a cos a.
    pub(super) sine: bool,
}

/// The ways to rewrite a doubled angle that are tried.
pub(super) const HALVINGS: [Halving; 5] = [
    Halving { cosine: Some(true), sine: false },
    Halving { cosine: Some(false), sine: false },
    Halving { cosine: Some(true), sine: true },
    Halving { cosine: Some(false), sine: true },
    Halving { cosine: None, sine: true },
];

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
    let (sine, cosine) = (pool.sin(half), pool.cos(half));
    let square = |call: Expr, factor: i128| (vec![(call, 2)], Number::integer(factor));
    let mut terms = Vec::with_capacity(2 * poly.len());
    for term in poly {
        let found = term.monomial.iter().find(|&&(atom, n)| {
            n == 1 && is_trigonometric(pool, atom) && pool.node(atom).left == angle
        });
        let replacement: Vec<(Monomial, Number)> =
            match found.map(|&(call, _)| call_parts(pool, call).0) {
                Some(true) => match halving.cosine {
                    Some(true) => vec![square(cosine, 2), (Vec::new(), Number::MINUS_ONE)],
                    Some(false) => vec![square(sine, -2), (Vec::new(), Number::ONE)],
                    None => Vec::new(),
                },
                Some(false) if halving.sine => {
                    let mut pair = vec![(sine, 1), (cosine, 1)];
                    pair.sort_unstable();
                    vec![(pair, Number::integer(2))]
                }
                _ => Vec::new(),
            };
        let Some(&(call, _)) = found.filter(|_| !replacement.is_empty()) else {
            terms.push(term.clone());
            continue;
        };
        let cofactor = multiply_monomials(&term.monomial, &vec![(call, -1)]);
        terms.extend(replacement.into_iter().map(|(monomial, coefficient)| Term {
            monomial: multiply_monomials(&cofactor, &monomial),
            coefficient: term.coefficient.times(coefficient),
        }));
    }
    collect(terms)
}

/// Two terms of one cofactor that merge into a product of two calls.
struct Pair {
    terms: (usize, usize),
    calls: (Expr, Expr),
    product: Term,
}

/// Terms above which no products are sought.
const MAX_PAIRED_TERMS: usize = 160;

/// Merges pairs of terms into products, preferring calls that occur in many of the products.
pub(super) fn products(pool: &Pool, poly: &Poly) -> Poly {
    if poly.len() > MAX_PAIRED_TERMS {
        return poly.clone();
    }
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
    collect(result)
}

/// The call that most remaining products share.
fn most_frequent_call(pool: &Pool, poly: &Poly, pairs: &[Pair], is_used: &[bool]) -> Option<Expr> {
    let mut counts: BTreeMap<Expr, usize> = BTreeMap::new();
    for pair in pairs {
        let (a, b) = pair.calls;
        *counts.entry(a).or_default() += 2;
        if a != b {
            *counts.entry(b).or_default() += 2;
        }
    }
    // A call that stands alone in some term costs nothing more.
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
fn all_pairs(pool: &Pool, poly: &Poly) -> Vec<Pair> {
    let mut groups: BTreeMap<Monomial, Vec<(usize, Expr)>> = BTreeMap::new();
    for (index, term) in poly.iter().enumerate() {
        if let Some((call, cofactor)) = split_call(pool, &term.monomial) {
            groups.entry(cofactor).or_default().push((index, call));
        }
    }
    let mut pairs = Vec::new();
    for (cofactor, calls) in groups {
        for (n, &(i, x)) in calls.iter().enumerate() {
            for &(j, y) in &calls[n + 1..] {
                let (a, b) = (poly[i].coefficient, poly[j].coefficient);
                if a.magnitude() == b.magnitude() {
                    let product = product_of(pool, (x, a), (y, b));
                    pairs.extend(product.map(|(calls, coefficient)| {
                        let mut factors = vec![(calls.0, 1), (calls.1, 1)];
                        factors.sort_unstable();
                        if calls.0 == calls.1 {
                            factors = vec![(calls.0, 2)];
                        }
                        let monomial = multiply_monomials(&cofactor, &factors);
                        Pair { terms: (i, j), calls, product: Term { monomial, coefficient } }
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
    let ((cos_x, angle_x), (cos_y, angle_y)) = (call_parts(pool, x), call_parts(pool, y));
    if cos_x != cos_y {
        return None;
    }
    let half_sum = halved(pool, pool.add(angle_x, angle_y));
    let half_difference = halved(pool, pool.sub(angle_x, angle_y));
    let allowed = denominator(pool, angle_x).max(denominator(pool, angle_y));
    if denominator(pool, half_sum) > allowed || denominator(pool, half_difference) > allowed {
        return None;
    }
    let is_equal = a.is_negative() == b.is_negative();
    let (first, second, sign) = match (cos_x, is_equal) {
        (true, true) => (pool.cos(half_sum), pool.cos(half_difference), 2),
        (true, false) => (pool.sin(half_sum), pool.sin(half_difference), -2),
        (false, true) => (pool.sin(half_sum), pool.cos(half_difference), 2),
        (false, false) => (pool.cos(half_sum), pool.sin(half_difference), 2),
    };
    let ((c, first), (d, second)) = (pool.split_coefficient(first), pool.split_coefficient(second));
    let are_calls = is_trigonometric(pool, first) && is_trigonometric(pool, second);
    let coefficient = a.times(Number::integer(sign)).times(c).times(d);
    are_calls.then_some(((first, second), coefficient))
}

/// sinⁿ a / cosⁿ a = tanⁿ a; `None` where there is no such quotient.
pub(super) fn with_tangents(pool: &Pool, poly: &Poly) -> Option<Poly> {
    let mut found = false;
    let mut terms = Vec::with_capacity(poly.len());
    for term in poly {
        let mut monomial = term.monomial.clone();
        let divisors = term.monomial.iter().filter(|f| f.1 < 0);
        for &(cosine, n) in divisors.filter(|f| call_parts(pool, f.0).0) {
            let angle = call_parts(pool, cosine).1;
            let sine = pool.sin(angle);
            let power = monomial.iter().find(|f| f.0 == sine).map_or(0, |f| f.1).min(-n);
            if power > 0 {
                found = true;
                for (atom, exponent) in [(sine, -power), (cosine, power), (pool.tan(angle), power)]
                {
                    monomial = multiply_monomials(&monomial, &vec![(atom, exponent)]);
                }
            }
        }
        terms.push(Term { monomial, coefficient: term.coefficient });
    }
    found.then(|| collect(terms))
}
