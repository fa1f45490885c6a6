//! Simplification: several normal forms of an expression are written out, the cheapest wins.
//!
//! ```text
//! expression ── plain polynomial ───────────────┐
//!            └─ Fourier form ─┬─────────────────┤
//!                             ├─ halved angles ─┼─ common factors out ─ cost ─ cheapest
//!                             └─ products ──────┘
//! ```
//!
//! The value never changes where the expression has one; removable singularities of quotients of
//! sines and cosines are filled. Work is bounded: a part that takes more than its budget stays as
//! it is. The result depends on the expression alone, not on the order it was built in.

mod cost;
mod factor;
mod poly;
mod trig;

use crate::op::{Function, Op};
use crate::pool::{Expr, Pool, fact};
use crate::sweep::Sweep;
use cost::{Cost, cost};
use factor::{Preference, factored};
use poly::{Algebra, Poly, Reading};
use std::collections::HashMap;
use trig::{HALVINGS, doubled_angles, halve, products, with_tangents};

/// Multiplications of terms spent on one normal form of one part of an expression.
const FORM_BUDGET: usize = 60_000;
/// Multiplications of terms spent on one call of simplify for each expression in it.
const CALL_BUDGET: usize = 2_000_000;
/// Terms up to which each halved angle is tried by its cost.
const MAX_TRIED_TERMS: usize = 48;
/// Terms up to which a polynomial is factored.
const MAX_FACTORED_TERMS: usize = 1_500;
/// Doubled angles tried in one expression.
const MAX_TRIED_ANGLES: usize = 8;
/// Rounds of simplification; each further one needs a cheaper result.
const MAX_ROUNDS: usize = 3;

impl Pool {
    /// The cheapest form found; the expression itself if none is cheaper or the work too much.
    pub fn simplify(&self, e: Expr) -> Expr {
        self.simplify_all(&[e])[0]
    }

    /// Simplifies several expressions, shared parts once.
    pub fn simplify_all(&self, roots: &[Expr]) -> Vec<Expr> {
        let sweep = self.sweep(roots);
        let is_part = parts(self, &sweep);
        let mut simplifier = Simplifier {
            pool: self,
            budget: CALL_BUDGET.saturating_mul(roots.len()),
            known: HashMap::new(),
        };
        let mut images: Vec<Expr> = Vec::with_capacity(sweep.steps.len());
        for (position, step) in sweep.steps.iter().enumerate() {
            let operands: Vec<Expr> = sweep.operands(step).map(|o| images[o]).collect();
            let is_unchanged = sweep.operands(step).all(|o| images[o] == sweep.steps[o].expr);
            let rebuilt = if is_unchanged { step.expr } else { self.rebuild(step, &operands) };
            images.push(if is_part[position] { simplifier.part(rebuilt) } else { rebuilt });
        }
        sweep.roots.iter().map(|&root| images[root]).collect()
    }

    /// Multiplies out products and powers of sums; the expression itself if that is too much.
    pub fn expand(&self, e: Expr) -> Expr {
        let reading =
            Reading { is_fourier: false, keeps_plain_sums: false, splits_tangents: false };
        let poly = Algebra::new(self, FORM_BUDGET).read(e, reading);
        poly.map_or(e, |poly| poly::sum_expr(self, &poly))
    }
}

/// Which steps are simplified as a whole: roots, arguments of functions and divisors. Arguments
/// of sine and cosine stay as they are: linear forms.
fn parts(pool: &Pool, sweep: &Sweep) -> Vec<bool> {
    let mut is_part = vec![false; sweep.steps.len()];
    sweep.roots.iter().for_each(|&root| is_part[root] = true);
    for step in &sweep.steps {
        let is_polynomial = match step.op {
            Op::Add | Op::Mul | Op::Call(Function::Sin | Function::Cos) => true,
            Op::Pow => pool.split_power(step.expr).1 > 1,
            _ => false,
        };
        if !is_polynomial {
            sweep.operands(step).for_each(|operand| is_part[operand] = true);
        }
    }
    // A pair is no value.
    for (flag, step) in is_part.iter_mut().zip(&sweep.steps) {
        *flag &= !matches!(step.op, Op::Pair | Op::Number | Op::Symbol | Op::Pi);
    }
    is_part
}

struct Simplifier<'p> {
    pool: &'p Pool,
    budget: usize,
    known: HashMap<Expr, Expr>,
}

/// The cheapest form so far.
struct Best {
    e: Expr,
    cost: Cost,
}

impl Best {
    fn consider(&mut self, pool: &Pool, e: Expr) {
        if e != self.e {
            let cost = cost(pool, e);
            if cost < self.cost {
                (self.e, self.cost) = (e, cost);
            }
        }
    }

    fn consider_factored(&mut self, pool: &Pool, poly: &Poly) {
        if poly.len() > MAX_FACTORED_TERMS {
            return;
        }
        for preference in [Preference::Frequent, Preference::Trigonometric, Preference::Plain] {
            self.consider(pool, factored(pool, poly, preference));
        }
    }
}

impl Simplifier<'_> {
    /// Simplifies one part, whose atoms are simplified already.
    fn part(&mut self, e: Expr) -> Expr {
        if let Some(&known) = self.known.get(&e) {
            return known;
        }
        let mut result = e;
        for _ in 0..MAX_ROUNDS {
            let next = self.round(result);
            if next == result {
                break;
            }
            result = next;
        }
        self.known.insert(e, result);
        result
    }

    /// Tries every form once.
    fn round(&mut self, e: Expr) -> Expr {
        let pool = self.pool;
        if !matches!(pool.node(e).op, Op::Add | Op::Mul | Op::Pow) || self.budget == 0 {
            return e;
        }
        let mut best = Best { e, cost: cost(pool, e) };
        let mut seen: Vec<Poly> = Vec::new();
        for reading in readings(pool, e) {
            let Some(poly) = self.read(e, reading) else { continue };
            if !reading.is_fourier
                && let Some(poly) = with_tangents(pool, &poly)
            {
                best.consider_factored(pool, &poly);
            }
            if seen.contains(&poly) {
                continue;
            }
            best.consider_factored(pool, &poly);
            if reading.is_fourier {
                consider_trigonometric(pool, &poly, &mut best);
            }
            seen.push(poly);
        }
        best.e
    }

    fn read(&mut self, e: Expr, reading: Reading) -> Option<Poly> {
        let budget = FORM_BUDGET.min(self.budget);
        let mut algebra = Algebra::new(self.pool, budget);
        let poly = algebra.read(e, reading);
        self.budget -= budget - algebra.budget;
        poly
    }
}

/// The polynomials worth reading from `e`.
fn readings(pool: &Pool, e: Expr) -> Vec<Reading> {
    let has_tangents = pool.sweep(&[e]).steps.iter().any(|step| step.op == Op::Call(Function::Tan));
    let has_angles = has_tangents || pool.has_fact(e, fact::TRIGONOMETRIC);
    let mut readings = Vec::new();
    for is_fourier in [true, false] {
        for keeps_plain_sums in [false, true] {
            for splits_tangents in [false, true] {
                if (has_angles || !is_fourier) && (has_tangents || !splits_tangents) {
                    readings.push(Reading { is_fourier, keeps_plain_sums, splits_tangents });
                }
            }
        }
    }
    readings
}

/// Forms that leave the Fourier form again.
fn consider_trigonometric(pool: &Pool, fourier: &Poly, best: &mut Best) {
    best.consider_factored(pool, &products(pool, fourier));
    if fourier.len() > MAX_TRIED_TERMS {
        let halved = halved_where_shorter(pool, fourier);
        best.consider_factored(pool, &halved);
        return;
    }
    let halved = halved_where_cheaper(pool, fourier, best);
    best.consider_factored(pool, &products(pool, &halved));
}

/// Halves each doubled angle in the way that leaves the fewest terms, if fewer than before.
fn halved_where_shorter(pool: &Pool, fourier: &Poly) -> Poly {
    let mut poly = fourier.clone();
    for angle in doubled_angles(pool, fourier) {
        let options = HALVINGS.iter().map(|&halving| halve(pool, &poly, angle, halving));
        if let Some(shortest) = options.min_by_key(Vec::len)
            && shortest.len() < poly.len()
        {
            poly = shortest;
        }
    }
    poly
}

/// Halves each doubled angle in the cheapest way, if cheaper than before.
fn halved_where_cheaper(pool: &Pool, fourier: &Poly, best: &mut Best) -> Poly {
    let mut poly = fourier.clone();
    let mut lowest = cost(pool, factored(pool, &poly, Preference::Frequent));
    for angle in doubled_angles(pool, fourier).into_iter().take(MAX_TRIED_ANGLES) {
        let from = poly.clone();
        for halving in HALVINGS {
            let option = halve(pool, &from, angle, halving);
            let mut own = Best { e: pool.zero(), cost: Cost::MAX };
            own.consider_factored(pool, &option);
            if option.is_empty() {
                own.cost = Cost::ZERO;
            }
            best.consider(pool, own.e);
            if own.cost < lowest {
                lowest = own.cost;
                poly = option;
            }
        }
    }
    poly
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cost_counts_shared_parts_once_and_signs_not_at_all() {
        let pool = Pool::new();
        for (text, expected) in [
            ("sin(q)^2 + cos(q)^2", 27),
            ("-sin(q1 + q2)", 13),
            ("a*cos(q1 + q2)/(b + d)", 19),
            ("l1^2 + l2^2 + 2*l1*l2*cos(q2)", 19),
            ("1 + tan(q)^2", 14),
            ("sqrt(a^2 + b^2)", 11),
            ("a/(b*c)", 5),
        ] {
            assert_eq!(cost(&pool, pool.parse(text).expect(text)).work, expected, "{text}");
        }
    }

    #[test]
    fn content_is_taken_out_only_where_it_saves() {
        let pool = Pool::new();
        let simplified = |text: &str| pool.to_text(pool.simplify(pool.parse(text).expect(text)));
        assert_eq!(simplified("x/2 + y/3"), "0.5*x + 1/3*y");
        assert_eq!(simplified("2*x + 2*y"), "2*(x + y)");
    }
}
