//! Polynomials written short: common factors, squares, and equal cofactors grouped.

use super::poly::{
    Monomial, Poly, Term, collect, compare_monomials, is_trigonometric, multiply_monomials,
    sum_expr, take_one, term_expr,
};
use crate::handle::ExprMap;
use crate::number::Number;
use crate::op::Op;
use crate::pool::{Expr, ONE, Pool};

/// The atom to be factored out first.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Preference {
    /// The one that occurs in most terms.
    Frequent,
    /// Sines and cosines before anything else.
    Trigonometric,
    /// Anything else before sines and cosines.
    Plain,
}

/// Total degree above which nothing is factored; bounds how deep factors nest.
const MAX_DEGREE: i32 = 48;
/// Number of terms above which squares are not searched.
const MAX_SQUARE_TERMS: usize = 120;

/// Writes a polynomial with common factors taken out.
pub(super) fn factored(pool: &Pool, poly: &Poly, preference: Preference) -> Expr {
    let degree = |term: &Term| term.monomial.iter().map(|factor| factor.1.abs()).sum::<i32>();
    if poly.iter().any(|term| degree(term) > MAX_DEGREE) {
        return sum_expr(pool, poly);
    }
    factor_out(pool, poly.clone(), preference)
}

/// Nests at most as deep as the total degree: each call takes out at least one atom.
fn factor_out(pool: &Pool, mut poly: Poly, preference: Preference) -> Expr {
    if poly.len() <= 1 {
        return sum_expr(pool, &poly);
    }
    let common = take_common(pool, &mut poly);
    let rest = without_common(pool, poly, preference);
    // A sum with a square of numbers in front folds further on its own.
    pool.mul(common, rest)
}

/// Takes out the factors of all terms: powers of atoms and the numeric content.
fn take_common(pool: &Pool, poly: &mut Poly) -> Expr {
    let mut shared = poly[0].monomial.clone();
    for term in &poly[1..] {
        shared.retain_mut(|(atom, n)| {
            let other = term.monomial.iter().find(|factor| factor.0 == *atom).map_or(0, |f| f.1);
            *n = if *n > 0 { (*n).min(other.max(0)) } else { (*n).max(other.min(0)) };
            *n != 0
        });
    }
    let content = content(poly);
    if shared.is_empty() && content.is_one() {
        return ONE;
    }
    let inverse: Monomial = shared.iter().map(|&(atom, n)| (atom, -n)).collect();
    for term in poly.iter_mut() {
        term.monomial = multiply_monomials(pool, &term.monomial, &inverse);
        if !content.is_one() {
            term.coefficient = term.coefficient.over(&content);
        }
    }
    *poly = collect(pool, std::mem::take(poly));
    term_expr(pool, &Term { monomial: shared, coefficient: content })
}

/// A number worth dividing all coefficients by, because fewer of them remain.
fn content(poly: &Poly) -> Number {
    let sign = if poly.iter().all(|term| term.coefficient.is_negative()) {
        Number::MINUS_ONE
    } else {
        Number::ONE
    };
    if poly.iter().all(|term| term.coefficient.magnitude().is_one()) {
        return sign;
    }
    let n_numbers = |divisor: &Number| {
        let others = poly.iter().filter(|term| !term.coefficient.is_like(divisor));
        others.count() + usize::from(!divisor.is_one())
    };
    let divisor = rational_gcd(poly).into_iter().chain([poly[0].coefficient.magnitude()]);
    let best = divisor.chain([Number::ONE]).min_by_key(|d| (n_numbers(d), !d.is_one()));
    best.expect("one is among the divisors").times(sign)
}

/// Greatest rational that divides all coefficients into integers; `None` where it is longer than a person
/// would read, as between decimals of many digits.
fn rational_gcd(poly: &Poly) -> Option<Number> {
    if poly.iter().any(|term| term.coefficient.has_long_denominator()) {
        return None;
    }
    poly.iter().try_fold(Number::ZERO, |gcd, term| {
        gcd.gcd(&term.coefficient).filter(|gcd| gcd.short_parts().is_some())
    })
}

/// Splits by the preferred atom again and again, then groups equal cofactors.
fn without_common(pool: &Pool, mut rest: Poly, preference: Preference) -> Expr {
    let mut summands = Vec::new();
    if let Some((square, remaining)) = take_square(pool, &rest) {
        summands.push(square);
        rest = remaining;
    }
    while let Some(atom) = preferred_atom(pool, &rest, preference) {
        let (mut with, without): (Poly, Poly) =
            rest.into_iter().partition(|term| has_power(term, atom));
        for term in &mut with {
            take_one(&mut term.monomial, atom);
        }
        sort(pool, &mut with);
        summands.push(pool.mul(atom, factor_out(pool, with, preference)));
        rest = without;
    }
    summands.extend(rest.iter().map(|term| term_expr(pool, term)));
    grouped(pool, &summands)
}

/// Puts distinct terms back into canonical order.
fn sort(pool: &Pool, terms: &mut [Term]) {
    let order = pool.ordering();
    terms.sort_by(|a, b| compare_monomials(&order, &a.monomial, &b.monomial));
}

fn has_power(term: &Term, atom: Expr) -> bool {
    term.monomial.iter().any(|&(a, n)| a == atom && n > 0)
}

/// The atom to take out next: it occurs in at least two terms.
fn preferred_atom(pool: &Pool, poly: &Poly, preference: Preference) -> Option<Expr> {
    let mut counts: ExprMap<usize> = ExprMap::default();
    let mut order = Vec::new();
    for &(atom, n) in poly.iter().flat_map(|term| &term.monomial) {
        if n > 0 {
            let count = counts.entry(atom).or_insert(0);
            if *count == 0 {
                order.push(atom);
            }
            *count += 1;
        }
    }
    let key = |atom: &Expr| {
        let is_trig = is_trigonometric(pool, *atom);
        let is_preferred = match preference {
            Preference::Frequent => false,
            Preference::Trigonometric => is_trig,
            Preference::Plain => !is_trig,
        };
        (is_preferred, counts[atom])
    };
    order
        .into_iter()
        .filter(|atom| counts[atom] >= 2)
        .max_by(|a, b| key(a).cmp(&key(b)).then_with(|| pool.canonical_order(*b, *a)))
}

/// a S + b S = (a + b) S for sums S that several summands have as a factor.
fn grouped(pool: &Pool, summands: &[Expr]) -> Expr {
    let mut groups: Vec<(Option<Expr>, Vec<Expr>)> = Vec::new();
    for &summand in summands {
        let (coefficient, monic) = pool.split_coefficient(summand);
        let factors = pool.chain(monic, Op::Mul);
        let is_group = |f: &&Expr| pool.node(pool.split_power(**f).0).op == Op::Add;
        let sum = factors
            .iter()
            .find(is_group)
            .copied()
            .filter(|_| factors.len() > 1 || !coefficient.is_one());
        let cofactor = match sum {
            Some(sum) => pool.product(
                factors.into_iter().filter(|&f| f != sum).chain([pool.number(coefficient)]),
            ),
            None => summand,
        };
        match groups.iter_mut().find(|group| sum.is_some() && group.0 == sum) {
            Some(group) => group.1.push(cofactor),
            None => groups.push((sum, vec![cofactor])),
        }
    }
    pool.sum(groups.into_iter().map(|(sum, cofactors)| {
        let cofactor = pool.sum(cofactors);
        sum.map_or(cofactor, |sum| pool.mul(sum, cofactor))
    }))
}

/// Finds a² + b² + … + 2ab + … among the terms: the square of the sum, and the terms that remain.
fn take_square(pool: &Pool, poly: &Poly) -> Option<(Expr, Poly)> {
    if poly.len() < 3 || poly.len() > MAX_SQUARE_TERMS {
        return None;
    }
    let roots: Vec<(usize, Term)> =
        poly.iter().enumerate().filter_map(|(i, term)| Some((i, square_root(term)?))).collect();
    let cross = |a: &Term, b: &Term| -> Option<(usize, bool)> {
        let monomial = multiply_monomials(pool, &a.monomial, &b.monomial);
        let index = find(pool, poly, &monomial)?;
        let doubled = a.coefficient.times(&b.coefficient).times(Number::integer(2));
        let found = &poly[index].coefficient;
        (found.magnitude() == doubled.magnitude())
            .then(|| (index, found.is_negative() != doubled.is_negative()))
    };
    let mut best: Option<(Vec<Term>, Vec<usize>)> = None;
    for (first, (index, root)) in roots.iter().enumerate() {
        let (mut members, mut used) = (vec![root.clone()], vec![*index]);
        for (other_index, other) in &roots[first + 1..] {
            let Some((_, is_negative)) = cross(&members[0], other) else { continue };
            let mut member = other.clone();
            if is_negative {
                member.coefficient = member.coefficient.negated();
            }
            let crossings: Vec<_> = members.iter().map(|m| cross(m, &member)).collect();
            if crossings.iter().all(|c| c.is_some_and(|(_, is_negative)| !is_negative)) {
                used.extend(crossings.into_iter().flatten().map(|(i, _)| i));
                used.push(*other_index);
                members.push(member);
            }
        }
        let is_better = best.as_ref().is_none_or(|found| found.0.len() < members.len());
        if members.len() > 1 && is_better {
            best = Some((members, used));
        }
    }
    let (members, used) = best?;
    let sum = factor_members(pool, members);
    let remaining = poly
        .iter()
        .enumerate()
        .filter(|(i, _)| !used.contains(i))
        .map(|(_, t)| t.clone())
        .collect();
    Some((pool.powi(sum, 2), remaining))
}

/// The index of the term with this monomial.
fn find(pool: &Pool, poly: &Poly, monomial: &Monomial) -> Option<usize> {
    let order = pool.ordering();
    poly.binary_search_by(|term| compare_monomials(&order, &term.monomial, monomial)).ok()
}

fn factor_members(pool: &Pool, members: Vec<Term>) -> Expr {
    sum_expr(pool, &collect(pool, members))
}

/// The term whose square this is.
fn square_root(term: &Term) -> Option<Term> {
    if term.monomial.is_empty() || term.monomial.iter().any(|factor| factor.1 % 2 != 0) {
        return None;
    }
    let coefficient = term.coefficient.exact_sqrt()?;
    let monomial = term.monomial.iter().map(|&(atom, n)| (atom, n / 2)).collect();
    Some(Term { monomial, coefficient })
}

#[cfg(test)]
mod tests {
    use crate::pool::Pool;

    #[test]
    fn content_is_taken_out_only_where_it_saves() {
        let pool = Pool::new();
        let simplified = |text: &str| pool.to_text(pool.simplify(pool.parse(text).expect(text)));
        assert_eq!(simplified("x/2 + y/3"), "0.5*x + 1/3*y");
        assert_eq!(simplified("2*x + 2*y"), "2*(x + y)");
    }
}
