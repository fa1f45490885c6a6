//! From expressions to a tape: its instructions, before their order is known.

use super::chains::{Chains, Part, reciprocal_base};
use super::emitter::Emitter;
use super::register::{Register, index};
use super::share::Operand;
use super::{Action, Tape, TapeError};
use crate::number::Number;
use crate::op::{Function, Op, small_integer};
use crate::pool::{Expr, Pool, SymbolId};
use crate::sweep::{Step, Sweep};
use std::collections::HashMap;

impl Tape {
    /// Compiles `outputs` as functions of `inputs` and `parameters`.
    ///
    /// # Errors
    /// [`TapeError::Unbound`] names a symbol that is neither.
    pub fn compile(
        pool: &Pool,
        outputs: &[Expr],
        inputs: &[SymbolId],
        parameters: &[SymbolId],
    ) -> Result<Self, TapeError> {
        let outputs = pool.expand_named(outputs);
        let sweep = pool.sweep(&outputs);
        let mut compiler = Compiler::new(inputs, parameters);
        compiler.chains = Chains::new(pool, &sweep, inputs);
        compiler.parts = vec![None; compiler.chains.n_parts()];
        for (position, step) in sweep.steps.iter().enumerate() {
            let value = compiler.emit_step(pool, &sweep, (position, step))?;
            compiler.values.push(value);
        }
        let roots: Vec<Register> =
            sweep.roots.iter().map(|&root| compiler.register(root)).collect();
        Ok(compiler.emitter.finish(&roots, parameters.len(), inputs.len()))
    }
}

/// The register of a step's value, but for its sign.
#[derive(Clone, Copy, Debug)]
struct SignedRegister {
    register: Register,
    /// The value is minus the register's: sums subtract it instead of negating first.
    is_negated: bool,
}

struct Compiler {
    symbols: HashMap<SymbolId, Register>,
    emitter: Emitter,
    /// Values of the steps so far.
    values: Vec<SignedRegister>,
    chains: Chains,
    /// Registers of the chains' parts beyond the steps, once they are emitted.
    parts: Vec<Option<Register>>,
}

impl Compiler {
    fn new(inputs: &[SymbolId], parameters: &[SymbolId]) -> Self {
        let mut symbols = HashMap::new();
        symbols.extend(
            parameters.iter().enumerate().map(|(i, &s)| (s, Register::Parameter(index(i)))),
        );
        symbols.extend(inputs.iter().enumerate().map(|(i, &s)| (s, Register::Input(index(i)))));
        Self {
            symbols,
            emitter: Emitter::default(),
            values: Vec::new(),
            chains: Chains::default(),
            parts: Vec::new(),
        }
    }

    fn constant(&mut self, value: f64) -> Register {
        self.emitter.constant(value)
    }

    fn emit(&mut self, action: Action, a: Register, b: Register, c: Register) -> Register {
        self.emitter.emit(action, a, b, c)
    }

    fn emit_two(&mut self, action: Action, a: Register, b: Register) -> Register {
        self.emitter.emit(action, a, b, a)
    }

    /// The register with the value of a step, negated into one of its own if need be.
    fn register(&mut self, position: usize) -> Register {
        self.plain(self.values[position])
    }

    fn plain(&mut self, value: SignedRegister) -> Register {
        if !value.is_negated {
            return value.register;
        }
        self.emit_two(Action::Negate, value.register, value.register)
    }

    /// The value of an operand of a chain; parts are emitted when first asked for.
    fn operand(&mut self, operand: Operand) -> SignedRegister {
        if self.emitted(operand.id).is_none() {
            self.emit_with_operands(operand.id);
        }
        let value = self.emitted(operand.id).expect("the part was just emitted");
        SignedRegister { is_negated: value.is_negated != operand.is_negated, ..value }
    }

    /// Emits a part after all that it is made of.
    fn emit_with_operands(&mut self, id: u32) {
        let mut path = vec![id];
        while let Some(&id) = path.last() {
            let waiting: Vec<u32> = match self.chains.part(id) {
                Part::Step(_) => Vec::new(),
                Part::Early(_, operands) => operands.iter().map(|o| o.id).collect(),
                Part::Pair(_, pair) => vec![pair.a, pair.b],
                Part::Multiple(..) => self.chains.of_multiple(id).iter().map(|o| o.id).collect(),
            };
            let waiting: Vec<u32> =
                waiting.into_iter().filter(|&id| self.emitted(id).is_none()).collect();
            if waiting.is_empty() {
                self.emit_part(id);
                path.pop();
            } else {
                path.extend(waiting);
            }
        }
    }

    /// The value of a step or part, if it is emitted.
    fn emitted(&self, id: u32) -> Option<SignedRegister> {
        let n_steps = self.chains.n_steps();
        match (id as usize).checked_sub(n_steps) {
            None => self.values.get(id as usize).copied(),
            Some(part) => {
                self.parts[part].map(|register| SignedRegister { register, is_negated: false })
            }
        }
    }

    /// Emits a part whose operands are emitted.
    fn emit_part(&mut self, id: u32) {
        let mut number = None;
        let (op, operands) = match self.chains.part(id) {
            Part::Step(_) => return,
            Part::Early(op, operands) => (op, operands),
            Part::Pair(op, pair) => {
                let b = Operand { id: pair.b, is_negated: pair.is_difference };
                (op, vec![Operand { id: pair.a, is_negated: false }, b])
            }
            Part::Multiple(factor, _) => {
                number = Some(factor);
                (Op::Add, self.chains.of_multiple(id).to_vec())
            }
        };
        let part = id as usize - self.chains.n_steps();
        if self.parts[part].is_some() {
            return;
        }
        let values: Vec<SignedRegister> = operands
            .into_iter()
            .map(|o| {
                let value = self.emitted(o.id).expect("operands are emitted before their part");
                SignedRegister { is_negated: value.is_negated != o.is_negated, ..value }
            })
            .collect();
        self.parts[part] = if op == Op::Add {
            let sum = self.sum(values);
            let number = number.map(|number| self.register(number as usize));
            Some(number.map_or(sum, |n| self.emit_two(Action::Multiply, n, sum)))
        } else {
            let factors = values.into_iter().map(|value| self.plain(value)).collect();
            self.multiply_all(factors)
        };
    }

    /// Emits one step.
    fn emit_step(
        &mut self,
        pool: &Pool,
        sweep: &Sweep,
        (position, step): (usize, &Step),
    ) -> Result<SignedRegister, TapeError> {
        let chain = self.chains.of(index(position)).map(<[Operand]>::to_vec);
        let chain: Option<Vec<SignedRegister>> =
            chain.map(|chain| chain.into_iter().map(|operand| self.operand(operand)).collect());
        let operands: Vec<usize> = sweep.operands(step).collect();
        let mut is_negated = false;
        let register = match (step.op, operands.as_slice()) {
            (Op::Number, _) => self.constant(pool.number_of(step.expr).to_f64()),
            (Op::Pi, _) => self.constant(std::f64::consts::PI),
            (Op::Symbol, _) => {
                let symbol = SymbolId(step.data);
                let unbound = || TapeError::Unbound { symbol, name: pool.symbol_name(symbol) };
                self.symbols.get(&symbol).copied().ok_or_else(unbound)?
            }
            (Op::Add, terms) => {
                let terms =
                    chain.unwrap_or_else(|| terms.iter().map(|&t| self.values[t]).collect());
                self.sum(terms)
            }
            (Op::Mul, &[a, b])
                if pool.as_number(sweep.steps[a].expr) == Some(Number::MINUS_ONE) =>
            {
                let value = self.values[b];
                is_negated = !value.is_negated;
                value.register
            }
            (Op::Mul, factors) => self.product(pool, sweep, factors, chain),
            (Op::Pow, &[base, exponent]) => {
                let number = pool.as_number(sweep.steps[exponent].expr).map(|n| n.to_f64());
                self.power(base, exponent, number)
            }
            (Op::Call(Function::If), _) => {
                let [condition, then, otherwise] = sweep.branches(step).map(|p| self.register(p));
                self.emit(Action::Call(Function::If), condition, then, otherwise)
            }
            (Op::Call(function), &[a]) => {
                let a = self.register(a);
                self.emit_two(Action::Call(function), a, a)
            }
            (Op::Call(function), &[a, b]) => {
                let (a, b) = (self.register(a), self.register(b));
                self.emit_two(Action::Call(function), a, b)
            }
            // A pair is read by its `if`; its register is never used.
            (Op::Pair, _) => self.constant(0.0),
            (op, operands) => unreachable!("{op:?} on {} operands", operands.len()),
        };
        Ok(SignedRegister { register, is_negated })
    }

    /// Early terms first, so that they are summed once; positive terms lead.
    fn sum(&mut self, mut values: Vec<SignedRegister>) -> Register {
        values.sort_by_key(|value| (!value.register.is_early(), value.is_negated));
        let first = values[0];
        let mut sum = first.register;
        if first.is_negated {
            // Minus leads: −a + b is b − a if any positive term exists.
            match values.iter().position(|value| !value.is_negated) {
                Some(positive) => {
                    let lead = values.remove(positive);
                    values.insert(0, lead);
                    sum = lead.register;
                }
                None => sum = self.emit_two(Action::Negate, sum, sum),
            }
        }
        for value in &values[1..] {
            let action = if value.is_negated { Action::Subtract } else { Action::Add };
            sum = self.emit_two(action, sum, value.register);
        }
        sum
    }

    /// Numerator over denominator, early factors first in both.
    fn product(
        &mut self,
        pool: &Pool,
        sweep: &Sweep,
        factors: &[usize],
        chain: Option<Vec<SignedRegister>>,
    ) -> Register {
        let (mut numerator, mut denominator) = (Vec::new(), Vec::new());
        for &factor in factors {
            match reciprocal_base(pool, sweep, factor) {
                Some(base) => denominator.push(self.register(base)),
                None if chain.is_none() => numerator.push(self.register(factor)),
                None => (),
            }
        }
        for value in chain.into_iter().flatten() {
            numerator.push(self.plain(value));
        }
        let one = self.constant(1.0);
        let numerator = self.multiply_all(numerator).unwrap_or(one);
        match self.multiply_all(denominator) {
            Some(denominator) => self.emit_two(Action::Divide, numerator, denominator),
            None => numerator,
        }
    }

    fn multiply_all(&mut self, mut factors: Vec<Register>) -> Option<Register> {
        factors.sort_by_key(|factor| !factor.is_early());
        factors.into_iter().reduce(|product, f| self.emit_two(Action::Multiply, product, f))
    }

    /// Small integer powers by repeated squaring, others by the general power.
    fn power(&mut self, base: usize, exponent: usize, number: Option<f64>) -> Register {
        let base = self.register(base);
        let Some(n) = number.and_then(small_integer) else {
            let exponent = self.register(exponent);
            return self.emit_two(Action::Power, base, exponent);
        };
        let one = self.constant(1.0);
        let mut square = base;
        let mut result = None;
        let mut left = n.unsigned_abs();
        while left > 0 {
            if left & 1 == 1 {
                result = Some(match result {
                    Some(result) => self.emit_two(Action::Multiply, result, square),
                    None => square,
                });
            }
            left >>= 1;
            if left > 0 {
                square = self.emit_two(Action::Multiply, square, square);
            }
        }
        let result = result.unwrap_or(one);
        if n < 0 { self.emit_two(Action::Divide, one, result) } else { result }
    }
}
