//! The sums and products of a sweep as chains of operands, with common pairs taken out.

use super::register::index;
use super::share::{Operand, Pair, share};
use crate::handle::HandleHash;
use crate::number::Number;
use crate::op::Op;
use crate::pool::{Pool, SymbolId};
use crate::sweep::{Step, Sweep};
use std::collections::{HashMap, HashSet};

/// An operand of a chain.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) enum Part {
    /// The step at this position.
    Step(usize),
    /// Terms or factors that depend on parameters only.
    Early(Op, Vec<Operand>),
    /// A pair that several chains have in common.
    Pair(Op, Pair),
    /// The step of a number times the sum of these terms: `2 a + 2 b` is `2 (a + b)`.
    Multiple(u32, Vec<Operand>),
}

/// Every sum and product that depends on inputs, by id.
#[derive(Default)]
pub(super) struct Chains {
    n_steps: usize,
    operands: HashMap<u32, Vec<Operand>, HandleHash>,
    /// Parts beyond the steps, in the order of their ids.
    parts: Vec<Part>,
}

impl Chains {
    pub(super) fn new(pool: &Pool, sweep: &Sweep, inputs: &[SymbolId]) -> Self {
        let mut reader = ChainReader::new(pool, sweep, inputs);
        let (mut sums, mut products) = (Vec::new(), Vec::new());
        for (position, step) in sweep.steps.iter().enumerate() {
            if reader.is_early[position] || !matches!(step.op, Op::Add | Op::Mul) {
                continue;
            }
            let Some(mut chain) = reader.chain(step) else { continue };
            if step.op == Op::Mul {
                products.push((index(position), chain));
                continue;
            }
            for (id, terms) in reader.take_multiples(&mut chain) {
                sums.push((id, terms));
            }
            sums.push((index(position), chain));
        }
        let mut result = Self { n_steps: sweep.steps.len(), ..Self::default() };
        result.parts = reader.parts;
        for (op, found) in [(Op::Add, sums), (Op::Mul, products)] {
            let (ids, mut chains): (Vec<u32>, Vec<Vec<Operand>>) = found.into_iter().unzip();
            let first_id = index(result.n_steps + result.parts.len());
            let pairs = share(&mut chains, first_id);
            result.parts.extend(pairs.into_iter().map(|pair| Part::Pair(op, pair)));
            result.operands.extend(ids.into_iter().zip(chains));
        }
        result
    }

    /// The operands of a step, if it is a chain, or of a multiple; a product's numerators only.
    pub(super) fn of(&self, id: u32) -> Option<&[Operand]> {
        self.operands.get(&id).map(Vec::as_slice)
    }

    /// The terms of a multiple.
    pub(super) fn of_multiple(&self, id: u32) -> &[Operand] {
        self.of(id).expect("the terms of every multiple are kept")
    }

    pub(super) fn n_steps(&self) -> usize {
        self.n_steps
    }

    /// Number of parts beyond the steps.
    pub(super) fn n_parts(&self) -> usize {
        self.parts.len()
    }

    pub(super) fn part(&self, id: u32) -> Part {
        let id = id as usize;
        id.checked_sub(self.n_steps).map_or(Part::Step(id), |part| self.parts[part].clone())
    }
}

struct ChainReader<'s> {
    pool: &'s Pool,
    sweep: &'s Sweep,
    /// Steps that depend on parameters only.
    is_early: Vec<bool>,
    /// Each step but for its sign.
    unsigned: Vec<Operand>,
    known: HashMap<Part, u32, HandleHash>,
    parts: Vec<Part>,
}

impl<'s> ChainReader<'s> {
    fn new(pool: &'s Pool, sweep: &'s Sweep, inputs: &[SymbolId]) -> Self {
        let inputs: HashSet<SymbolId> = inputs.iter().copied().collect();
        let mut is_early: Vec<bool> = Vec::with_capacity(sweep.steps.len());
        let mut unsigned: Vec<Operand> = Vec::with_capacity(sweep.steps.len());
        for (position, step) in sweep.steps.iter().enumerate() {
            is_early.push(match step.symbol() {
                Some(symbol) => !inputs.contains(&symbol),
                None => sweep.operands(step).all(|o| is_early[o]),
            });
            let mut operands = sweep.operands(step);
            let own = Operand { id: index(position), is_negated: false };
            unsigned.push(match (step.op, operands.next(), operands.next(), operands.next()) {
                (Op::Mul, Some(a), Some(b), None)
                    if pool.as_number(sweep.steps[a].expr) == Some(Number::MINUS_ONE) =>
                {
                    negated(unsigned[b])
                }
                _ => own,
            });
        }
        Self { pool, sweep, is_early, unsigned, known: HashMap::default(), parts: Vec::new() }
    }

    /// The operands of a sum or product; none where the step is another one negated.
    fn chain(&mut self, step: &Step) -> Option<Vec<Operand>> {
        let (mut early, mut chain) = (Vec::new(), Vec::new());
        for position in self.sweep.operands(step) {
            let own = Operand { id: index(position), is_negated: false };
            let operand = if step.op == Op::Add { self.unsigned[position] } else { own };
            if step.op == Op::Mul && reciprocal_base(self.pool, self.sweep, position).is_some() {
                continue;
            }
            if self.is_early[position] { early.push(operand) } else { chain.push(operand) }
        }
        let is_sign = |o: &Operand| {
            let expr = self.sweep.steps[o.id as usize].expr;
            step.op == Op::Mul && self.pool.as_number(expr) == Some(Number::MINUS_ONE)
        };
        if chain.len() + early.len() < 2 || early.iter().any(is_sign) {
            return None;
        }
        match early.as_slice() {
            [] => (),
            [single] => chain.push(*single),
            _ => chain.push(self.early_part(step.op, early)),
        }
        Some(chain)
    }

    /// Gathers the terms of a sum that are the same number times something. Gives back the sums
    /// to be multiplied that are new.
    fn take_multiples(&mut self, chain: &mut Vec<Operand>) -> Vec<(u32, Vec<Operand>)> {
        let mut multiples: Vec<(u32, Vec<Operand>)> = Vec::new();
        for &operand in chain.iter() {
            let Some((number, multiplied)) = self.multiple(operand) else { continue };
            match multiples.iter_mut().find(|(known, _)| *known == number) {
                Some((_, terms)) => terms.push(multiplied),
                None => multiples.push((number, vec![multiplied])),
            }
        }
        multiples.retain(|(_, terms)| terms.len() > 1);
        chain.retain(|&operand| {
            let number = self.multiple(operand).map(|(number, _)| number);
            !multiples.iter().any(|(taken, _)| Some(*taken) == number)
        });
        let mut new = Vec::new();
        for (number, mut terms) in multiples {
            // Up to its sign, so that a − b and b − a are one.
            terms.sort_unstable();
            let is_negated = terms[0].is_negated;
            for term in &mut terms {
                term.is_negated ^= is_negated;
            }
            let n_parts = self.parts.len();
            let id = self.part(Part::Multiple(number, terms.clone()));
            if self.parts.len() > n_parts {
                new.push((id, terms));
            }
            chain.push(Operand { id, is_negated });
        }
        new
    }

    /// Splits a late term `number · rest` into the position of the number, and the rest.
    fn multiple(&self, operand: Operand) -> Option<(u32, Operand)> {
        let step = self.sweep.steps.get(operand.id as usize)?;
        let mut factors = self.sweep.operands(step);
        let (Op::Mul, 2, Some(number), Some(rest)) =
            (step.op, factors.len(), factors.next(), factors.next())
        else {
            return None;
        };
        self.pool.as_number(self.sweep.steps[number].expr)?;
        if self.is_early[rest] {
            return None;
        }
        let rest = self.unsigned[rest];
        Some((index(number), Operand { is_negated: rest.is_negated != operand.is_negated, ..rest }))
    }

    fn early_part(&mut self, op: Op, operands: Vec<Operand>) -> Operand {
        Operand { id: self.part(Part::Early(op, operands)), is_negated: false }
    }

    /// The id of a part, new or known.
    fn part(&mut self, part: Part) -> u32 {
        let next = index(self.sweep.steps.len() + self.parts.len());
        let id = *self.known.entry(part.clone()).or_insert(next);
        if id == next {
            self.parts.push(part);
        }
        id
    }
}

fn negated(operand: Operand) -> Operand {
    Operand { is_negated: !operand.is_negated, ..operand }
}

/// Position of `b` where the step at `position` is `b^(−1)`.
pub(super) fn reciprocal_base(pool: &Pool, sweep: &Sweep, position: usize) -> Option<usize> {
    let step = &sweep.steps[position];
    if step.op != Op::Pow {
        return None;
    }
    let [base, exponent] = sweep.operand_array(step);
    (pool.as_number(sweep.steps[exponent].expr) == Some(Number::MINUS_ONE)).then_some(base)
}
