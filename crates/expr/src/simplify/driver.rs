//! The driver: goes through expressions, operands first, and simplifies part by part.

use super::best::Best;
use super::budget::{FORM_BUDGET, Meter};
use super::cost::CostModel;
use super::exponential::exponential_forms;
use super::poly::{Algebra, Poly, Reading, Term};
use super::together::cheapest_together;
use super::trig::{with_tangents, without_phases};
use super::trig_forms::consider_trigonometric;
use crate::handle::ExprMap;
use crate::number::Number;
use crate::op::{Function, Op};
use crate::pool::{Expr, Pool, fact};
use crate::sweep::Sweep;

/// Rounds of simplification; each further one needs a cheaper result.
const MAX_ROUNDS: usize = 3;
/// Nodes of an atom, written out, above which forms are compared without looking into it.
const MAX_SEEN_NODES: u32 = 1_000;

/// Which steps are simplified as a whole: roots, arguments of functions and divisors. Arguments
/// of sine and cosine are linear forms and stay as they are, unless they hold angles themselves.
pub(super) fn parts(pool: &Pool, sweep: &Sweep) -> Vec<bool> {
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
pub(super) struct Driver<'p> {
    pub(super) model: CostModel<'p>,
    algebra: Algebra<'p>,
    known: ExprMap<Expr>,
}

impl<'p> Driver<'p> {
    pub(super) fn new(pool: &'p Pool, budget: u64, n_roots: usize) -> Self {
        Self {
            model: CostModel::new(pool, Meter::new(budget, n_roots)),
            algebra: Algebra::new(pool, 0),
            known: ExprMap::default(),
        }
    }

    /// The images of the roots.
    pub(super) fn run(&mut self, sweep: &Sweep) -> Vec<Expr> {
        let pool = self.model.pool;
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
            if matches!(step.op, Op::Call(_))
                && let Some(folded) = pool.folded_call(image)
            {
                image = self.part(folded);
            }
            let is_chain = matches!(step.op, Op::Add | Op::Mul);
            let size = sweep
                .operands(step)
                .fold(u32::from(!is_chain), |size, operand| size.saturating_add(sizes[operand]));
            if size > MAX_SEEN_NODES && !is_chain {
                self.model.make_opaque(image);
            }
            sizes.push(size);
            images.push(image);
        }
        let simplified: Vec<Expr> = sweep.roots.iter().map(|&root| images[root]).collect();
        let originals = self.flat_originals(sweep, &is_piece);
        cheapest_together(&self.model, &originals, &simplified)
    }

    /// The roots as they are, with long chains in one piece: those must not be compared as they were
    /// built.
    fn flat_originals(&mut self, sweep: &Sweep, is_piece: &[bool]) -> Vec<Expr> {
        if !is_piece.contains(&true) {
            return sweep.roots.iter().map(|&root| sweep.steps[root].expr).collect();
        }
        let pool = self.model.pool;
        let mut images: Vec<Expr> = Vec::with_capacity(sweep.steps.len());
        for (position, step) in sweep.steps.iter().enumerate() {
            let operands: Vec<Expr> = sweep.operands(step).map(|o| images[o]).collect();
            let is_unchanged = sweep.operands(step).all(|o| images[o] == sweep.steps[o].expr);
            let image = if is_unchanged { step.expr } else { pool.rebuild(step, &operands) };
            images.push(if is_piece[position] { image } else { self.flattened(image) });
        }
        sweep.roots.iter().map(|&root| images[root]).collect()
    }

    /// Long chains are built of pieces in the order they come; flat, they are the same in any.
    fn flattened(&mut self, e: Expr) -> Expr {
        if self.model.meter.has_ended() {
            return e;
        }
        let (flat, n_operands) = self.model.pool.flattened(e, self.model.meter.left());
        self.model.meter.spend(n_operands);
        flat
    }

    /// Simplifies one part, whose atoms are simplified already.
    fn part(&mut self, e: Expr) -> Expr {
        if let Some(&known) = self.known.get(&e) {
            return known;
        }
        let mut result = e;
        // Whose forms no longer compete: they have lost against the result, or are it.
        let mut seen: Vec<Poly> = Vec::new();
        for _ in 0..MAX_ROUNDS {
            let next = self.round(result, &mut seen);
            if next == result {
                break;
            }
            result = next;
        }
        self.known.insert(e, result);
        result
    }

    /// Tries every form once, but those of the polynomials that were seen before.
    fn round(&mut self, e: Expr, seen: &mut Vec<Poly>) -> Expr {
        let pool = self.model.pool;
        let is_chain = matches!(pool.node(e).op, Op::Add | Op::Mul | Op::Pow);
        // A polynomial would drop the zero in 0·(1/0), which has no value.
        if !is_chain || pool.has_fact(e, fact::POISONED) {
            return e;
        }
        let mut best = Best::of(&self.model, e);
        for reading in readings(pool, e) {
            let Some(poly) = self.read(e, reading) else { continue };
            if !reading.is_fourier
                && let Some(poly) = with_tangents(pool, &poly)
            {
                best.consider_factored(&self.model, &poly);
            }
            if seen.contains(&poly) {
                continue;
            }
            best.consider_factored(&self.model, &poly);
            // Quotients cancel first, products become sums afterwards.
            if !reading.is_fourier && reading.splits_tangents {
                self.algebra.budget = FORM_BUDGET.min(self.model.meter.left());
                let one = vec![Term { monomial: Vec::new(), coefficient: Number::ONE }];
                if let Some(fourier) = self.algebra.multiply(&poly, &one, true)
                    && fourier != poly
                {
                    best.consider_factored(&self.model, &fourier);
                    consider_trigonometric(&self.model, &fourier, &mut best);
                }
            }
            if reading.is_fourier {
                consider_trigonometric(&self.model, &poly, &mut best);
                if let Some(poly) = without_phases(pool, &poly) {
                    best.consider_factored(&self.model, &poly);
                }
            }
            if !reading.is_fourier && pool.has_fact(e, fact::EXPONENTIAL) {
                self.algebra.budget = FORM_BUDGET.min(self.model.meter.left());
                for form in exponential_forms(&mut self.algebra, &poly) {
                    best.consider_factored(&self.model, &form);
                }
            }
            seen.push(poly);
        }
        best.e
    }

    /// A normal form; `None` if it takes too much work.
    fn read(&mut self, e: Expr, reading: Reading) -> Option<Poly> {
        let meter = &self.model.meter;
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
