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
//! sines and cosines are filled. Work is bounded by a [`Budget`]: what is not reached stays as it
//! is. The result depends on the expression alone, not on the order it was built in.

mod budget;
mod collect;
mod cost;
mod factor;
mod flatten;
mod poly;
mod report;
mod rules;
mod trig;
mod unfold;

pub use budget::{Budget, Limit};
pub use report::{Report, Simplified};

use crate::op::{Function, Op};
use crate::pool::{Expr, ExprMap, Pool, fact};
use crate::sweep::Sweep;
use budget::Meter;
use cost::{Cost, Judge};
use factor::{Preference, factored};
use poly::{Algebra, Poly, Reading, is_trigonometric};
use rules::HALVINGS;
use trig::{doubled_angles, halve, products, with_tangents, without_phases};

/// Multiplications of terms spent on one normal form of one part of an expression.
const FORM_BUDGET: usize = 60_000;
/// Terms up to which each halved angle is tried by its cost.
const MAX_TRIED_TERMS: usize = 48;
/// Terms up to which a polynomial is factored.
const MAX_FACTORED_TERMS: usize = 1_500;
/// Doubled angles tried in one expression.
const MAX_TRIED_ANGLES: usize = 8;
/// Rounds of simplification; each further one needs a cheaper result.
const MAX_ROUNDS: usize = 3;
/// Nodes of an atom, written out, above which forms are compared without looking into it.
const MAX_SEEN_NODES: u32 = 1_000;
/// Terms above which no products are sought.
const MAX_PAIRED_TERMS: usize = 160;
/// Visits to each factor while a polynomial is factored, about.
const FACTORING_WORK: usize = 4;

impl Pool {
    /// The cheapest form found; the expression itself if none is cheaper or the work too much.
    pub fn simplify(&self, e: Expr) -> Expr {
        self.simplify_all(&[e])[0]
    }

    /// Simplifies several expressions within the default [`Budget`], shared parts once.
    pub fn simplify_all(&self, roots: &[Expr]) -> Vec<Expr> {
        Driver::new(self, &Budget::default(), roots.len()).run(&self.sweep(roots))
    }

    /// Simplifies several expressions within a budget, and says what came of it. Whatever is not
    /// reached before the budget ends stays as it is: the result always has the same values.
    ///
    /// ```
    /// use bksim_expr::{Budget, Limit, Pool};
    ///
    /// let pool = Pool::new();
    /// let e = pool.parse("a*cos(p)*cos(q) - a*sin(p)*sin(q)").expect("valid");
    /// let done = pool.simplify_within(&[e], &Budget::default());
    /// assert_eq!(pool.to_text(done.roots[0]), "a*cos(p + q)");
    /// assert_eq!((done.report.before.total(), done.report.after.total()), (9, 3));
    /// assert_eq!(done.report.ended_by, None);
    ///
    /// let none = pool.simplify_within(&[e], &Budget { nodes: 0, ..Budget::default() });
    /// assert_eq!((none.roots[0], none.report.ended_by), (e, Some(Limit::Nodes)));
    /// ```
    pub fn simplify_within(&self, roots: &[Expr], budget: &Budget) -> Simplified {
        let sweep = self.sweep(roots);
        let mut driver = Driver::new(self, budget, roots.len());
        let simple = driver.run(&sweep);
        let report = Report {
            before: self.count_sweep(&sweep).operations(),
            after: self.operation_count(&simple).operations(),
            printed_before: self.printed_operations(roots),
            printed_after: self.printed_operations(&simple),
            work: driver.judge.meter.spent(),
            ended_by: driver.judge.meter.ended_by(),
            n_kept: driver.n_kept,
        };
        Simplified { roots: simple, report }
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
/// of sine and cosine are linear forms and stay as they are, unless they hold angles themselves.
fn parts(pool: &Pool, sweep: &Sweep) -> Vec<bool> {
    let mut is_part = vec![false; sweep.steps.len()];
    sweep.roots.iter().for_each(|&root| is_part[root] = true);
    for step in &sweep.steps {
        let is_polynomial = match step.op {
            Op::Add | Op::Mul => true,
            Op::Call(Function::Sin | Function::Cos) => !sweep.operands(step).any(|operand| {
                pool.has_fact(sweep.steps[operand].expr, fact::TRIGONOMETRIC | fact::TANGENT)
            }),
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

/// Which steps are operands of a chain of their own operation: long chains are built of pieces.
fn chain_pieces(sweep: &Sweep) -> Vec<bool> {
    let mut is_piece = vec![false; sweep.steps.len()];
    for step in sweep.steps.iter().filter(|step| matches!(step.op, Op::Add | Op::Mul)) {
        for operand in sweep.operands(step).filter(|&o| sweep.steps[o].op == step.op) {
            is_piece[operand] = true;
        }
    }
    is_piece
}

/// Goes through an expression, operands first, and simplifies part by part.
struct Driver<'p> {
    judge: Judge<'p>,
    algebra: Algebra<'p>,
    known: ExprMap<Expr>,
    n_kept: usize,
}

impl<'p> Driver<'p> {
    fn new(pool: &'p Pool, budget: &Budget, n_roots: usize) -> Self {
        Self {
            judge: Judge::new(pool, Meter::new(budget, n_roots)),
            algebra: Algebra::new(pool, 0),
            known: ExprMap::default(),
            n_kept: 0,
        }
    }

    /// The images of the roots.
    fn run(&mut self, sweep: &Sweep) -> Vec<Expr> {
        let pool = self.judge.pool;
        let (is_part, is_piece) = (parts(pool, sweep), chain_pieces(sweep));
        let mut images: Vec<Expr> = Vec::with_capacity(sweep.steps.len());
        let mut sizes: Vec<u32> = Vec::with_capacity(sweep.steps.len());
        for (position, step) in sweep.steps.iter().enumerate() {
            let operands: Vec<Expr> = sweep.operands(step).map(|o| images[o]).collect();
            let is_unchanged = sweep.operands(step).all(|o| images[o] == sweep.steps[o].expr);
            let mut image = if is_unchanged { step.expr } else { pool.rebuild(step, &operands) };
            if is_part[position] || !is_piece[position] {
                image = self.flattened(image);
            }
            if is_part[position] {
                image = self.part(image);
            }
            let is_chain = matches!(step.op, Op::Add | Op::Mul);
            let size = sweep
                .operands(step)
                .fold(u32::from(!is_chain), |size, operand| size.saturating_add(sizes[operand]));
            if size > MAX_SEEN_NODES && !is_chain {
                self.judge.make_opaque(image);
            }
            sizes.push(size);
            images.push(image);
        }
        sweep.roots.iter().map(|&root| images[root]).collect()
    }

    /// Long chains are built of pieces in the order they come; flat, they are the same in any.
    fn flattened(&mut self, e: Expr) -> Expr {
        if self.judge.meter.has_ended() {
            return e;
        }
        let (flat, n_operands) = self.judge.pool.flattened(e, self.judge.meter.left());
        self.judge.meter.spend(n_operands);
        flat
    }

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
        self.n_kept += usize::from(self.judge.meter.has_ended());
        self.known.insert(e, result);
        result
    }

    /// Tries every form once.
    fn round(&mut self, e: Expr) -> Expr {
        let pool = self.judge.pool;
        let is_chain = matches!(pool.node(e).op, Op::Add | Op::Mul | Op::Pow);
        // A polynomial would drop the zero in 0·(1/0), which has no value.
        if !is_chain || pool.has_fact(e, fact::POISONED) {
            return e;
        }
        let mut best = Best { e, cost: self.judge.cost(e) };
        let mut seen: Vec<Poly> = Vec::new();
        for reading in readings(pool, e) {
            let Some(poly) = self.read(e, reading) else { continue };
            if !reading.is_fourier
                && let Some(poly) = with_tangents(pool, &poly)
            {
                best.consider_factored(&self.judge, &poly);
            }
            if seen.contains(&poly) {
                continue;
            }
            best.consider_factored(&self.judge, &poly);
            if reading.is_fourier {
                consider_trigonometric(&self.judge, &poly, &mut best);
                if let Some(poly) = without_phases(pool, &poly) {
                    best.consider_factored(&self.judge, &poly);
                }
            }
            seen.push(poly);
        }
        best.e
    }

    /// A normal form; `None` if it takes too much work.
    fn read(&mut self, e: Expr, reading: Reading) -> Option<Poly> {
        let meter = &self.judge.meter;
        if meter.has_ended() {
            return None;
        }
        let granted = FORM_BUDGET.min(meter.left());
        self.algebra.budget = granted;
        let poly = self.algebra.read(e, reading);
        meter.spend(granted - self.algebra.budget);
        // Less than a form's own budget was left, and did not suffice.
        if poly.is_none() && granted < FORM_BUDGET {
            meter.spend(meter.left() + 1);
        }
        poly
    }
}

/// The cheapest form so far.
struct Best {
    e: Expr,
    cost: Cost,
}

impl Best {
    fn consider(&mut self, judge: &Judge, e: Expr) {
        if e != self.e || self.cost == Cost::MAX {
            self.take(Self { e, cost: judge.cost(e) });
        }
    }

    fn take(&mut self, other: Self) {
        if other.cost < self.cost {
            *self = other;
        }
    }

    fn consider_factored(&mut self, judge: &Judge, poly: &Poly) {
        if poly.len() > MAX_FACTORED_TERMS {
            return;
        }
        let n_factors: usize = poly.iter().map(|term| 1 + term.monomial.len()).sum();
        let atoms = || poly.iter().flat_map(|term| &term.monomial);
        let is_mixed = atoms().any(|f| is_trigonometric(judge.pool, f.0))
            && atoms().any(|f| !is_trigonometric(judge.pool, f.0));
        let preferences = [Preference::Frequent, Preference::Trigonometric, Preference::Plain];
        for &preference in &preferences[..if is_mixed { 3 } else { 1 }] {
            if judge.meter.has_ended() {
                return;
            }
            judge.meter.spend(FACTORING_WORK * n_factors);
            self.consider(judge, factored(judge.pool, poly, preference));
        }
    }
}

/// The polynomials worth reading from `e`.
fn readings(pool: &Pool, e: Expr) -> Vec<Reading> {
    let has_tangents = pool.has_fact(e, fact::TANGENT);
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
fn consider_trigonometric(judge: &Judge, fourier: &Poly, best: &mut Best) {
    best.consider_factored(judge, &paired(judge, fourier));
    if fourier.len() > MAX_TRIED_TERMS {
        let halved = halved_where_shorter(judge, fourier);
        best.consider_factored(judge, &halved);
        return;
    }
    let halved = halved_where_cheaper(judge, fourier, best);
    best.consider_factored(judge, &paired(judge, &halved));
}

fn paired(judge: &Judge, poly: &Poly) -> Poly {
    if judge.meter.has_ended() || poly.len() > MAX_PAIRED_TERMS {
        return poly.clone();
    }
    judge.meter.spend(poly.len() * poly.len());
    products(judge.pool, poly)
}

/// Halves each doubled angle in the way that leaves the fewest terms, if fewer than before.
fn halved_where_shorter(judge: &Judge, fourier: &Poly) -> Poly {
    let mut poly = fourier.clone();
    for angle in doubled_angles(judge.pool, fourier) {
        if judge.meter.has_ended() {
            break;
        }
        judge.meter.spend(HALVINGS.len() * poly.len());
        let options = HALVINGS.iter().map(|&halving| halve(judge.pool, &poly, angle, halving));
        if let Some(shortest) = options.min_by_key(Vec::len)
            && shortest.len() < poly.len()
        {
            poly = shortest;
        }
    }
    poly
}

/// Halves each doubled angle in the cheapest way, if cheaper than before.
fn halved_where_cheaper(judge: &Judge, fourier: &Poly, best: &mut Best) -> Poly {
    let pool = judge.pool;
    let mut poly = fourier.clone();
    let from_e = factored(pool, &poly, Preference::Frequent);
    let mut lowest = judge.cost(from_e);
    for angle in doubled_angles(pool, fourier).into_iter().take(MAX_TRIED_ANGLES) {
        let from = poly.clone();
        for halving in HALVINGS {
            judge.meter.spend(from.len());
            let option = halve(pool, &from, angle, halving);
            // What is beaten by anything, until a form has been written out.
            let mut own = Best { e: from_e, cost: Cost::MAX };
            own.consider_factored(judge, &option);
            if own.cost < lowest {
                lowest = own.cost;
                poly = option;
            }
            best.take(own);
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
            let judge = Judge::new(&pool, Meter::new(&Budget::default(), 1));
            assert_eq!(judge.cost(pool.parse(text).expect(text)).work, expected, "{text}");
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
