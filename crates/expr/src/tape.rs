//! Straight-line programs: outputs as a list of instructions, each shared part computed once.
//!
//! Registers are written once, in this order:
//!
//! ```text
//! constants | parameters | inputs | prologue (parameters only) | body
//! ```
//!
//! The prologue runs when a [`Workspace`] is made, the body at every evaluation.

use crate::number::Number;
use crate::op::{Function, Op, power, select, small_integer};
use crate::pool::{Expr, Pool, SymbolId};
use crate::sweep::{Step, Sweep};
use std::collections::HashMap;

/// Why outputs cannot be compiled.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TapeError {
    /// A symbol is neither input nor parameter.
    #[error("symbol `{name}` is neither an input nor a parameter")]
    Unbound {
        /// The symbol.
        symbol: SymbolId,
        /// Its name.
        name: String,
    },
}

/// What one instruction computes from its registers.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Action {
    Add,
    Subtract,
    Multiply,
    Divide,
    Negate,
    Power,
    Call(Function),
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) struct Instruction {
    pub(crate) action: Action,
    pub(crate) a: u32,
    pub(crate) b: u32,
    /// Third operand, used by `if` alone.
    pub(crate) c: u32,
}

/// A compiled list of outputs; evaluation allocates nothing.
#[derive(Clone, Debug)]
pub struct Tape {
    pub(crate) constants: Vec<f64>,
    pub(crate) n_parameters: usize,
    pub(crate) n_inputs: usize,
    pub(crate) prologue: Vec<Instruction>,
    pub(crate) body: Vec<Instruction>,
    pub(crate) outputs: Vec<u32>,
}

/// The registers of a [`Tape`] with its parameters set.
#[derive(Clone, Debug)]
pub struct Workspace {
    registers: Vec<f64>,
}

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
        let sweep = pool.sweep(outputs);
        let mut compiler = Compiler::new(inputs, parameters);
        for step in &sweep.steps {
            let place = compiler.place(pool, &sweep, step)?;
            compiler.places.push(place);
        }
        let roots: Vec<Register> =
            sweep.roots.iter().map(|&root| compiler.register(root)).collect();
        Ok(compiler.finish(&roots, parameters.len(), inputs.len()))
    }

    /// Number of instructions, prologue included.
    pub fn len(&self) -> usize {
        self.prologue.len() + self.body.len()
    }

    /// Whether there is nothing to compute.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of instructions in each evaluation.
    pub fn operation_count(&self) -> usize {
        self.body.len()
    }

    /// Number of outputs.
    pub fn n_outputs(&self) -> usize {
        self.outputs.len()
    }

    /// Number of inputs.
    pub fn n_inputs(&self) -> usize {
        self.n_inputs
    }

    /// Registers for this tape, with everything computed that depends on parameters only.
    ///
    /// # Panics
    /// When the number of parameters differs from the compiled one.
    pub fn workspace(&self, parameters: &[f64]) -> Workspace {
        assert_eq!(parameters.len(), self.n_parameters, "number of parameters");
        let mut registers = Vec::with_capacity(self.first_input() + self.n_inputs + self.len());
        registers.extend_from_slice(&self.constants);
        registers.extend_from_slice(parameters);
        registers.resize(self.first_input() + self.n_inputs + self.len(), 0.0);
        run(&self.prologue, &mut registers, self.first_input() + self.n_inputs);
        Workspace { registers }
    }

    /// Computes all outputs.
    ///
    /// # Panics
    /// When `inputs` or `out` have another length than was compiled, or `ws` is of another tape.
    pub fn evaluate(&self, ws: &mut Workspace, inputs: &[f64], out: &mut [f64]) {
        assert_eq!(inputs.len(), self.n_inputs, "number of inputs");
        assert_eq!(out.len(), self.outputs.len(), "number of outputs");
        let first_input = self.first_input();
        ws.registers[first_input..first_input + inputs.len()].copy_from_slice(inputs);
        run(&self.body, &mut ws.registers, first_input + inputs.len() + self.prologue.len());
        for (value, &register) in out.iter_mut().zip(&self.outputs) {
            *value = ws.registers[register as usize];
        }
    }

    pub(crate) fn first_input(&self) -> usize {
        self.constants.len() + self.n_parameters
    }
}

/// Runs instructions; the first writes register `first`, each further one the next.
fn run(instructions: &[Instruction], registers: &mut [f64], first: usize) {
    for (offset, instruction) in instructions.iter().enumerate() {
        let (a, b) = (registers[instruction.a as usize], registers[instruction.b as usize]);
        registers[first + offset] = match instruction.action {
            Action::Add => a + b,
            Action::Subtract => a - b,
            Action::Multiply => a * b,
            Action::Divide => a / b,
            Action::Negate => -a,
            Action::Power => power(a, b),
            Action::Call(Function::If) => select(a, b, registers[instruction.c as usize]),
            Action::Call(function) => function.value(a, b),
        };
    }
}

/// A register before its final number is known: its kind and its index within the kind.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
enum Register {
    Constant(u32),
    Parameter(u32),
    Input(u32),
    Prologue(u32),
    Body(u32),
}

impl Register {
    /// Whether the value is known before the inputs are.
    fn is_early(self) -> bool {
        !matches!(self, Self::Input(_) | Self::Body(_))
    }
}

/// Where the value of a step is found.
#[derive(Clone, Copy, Debug)]
struct Place {
    register: Register,
    /// The value is minus the register's: sums subtract it instead of negating first.
    is_negated: bool,
}

type Key = (Action, Register, Register, Register);

struct Compiler {
    symbols: HashMap<SymbolId, Register>,
    constants: Vec<f64>,
    constant_index: HashMap<u64, Register>,
    prologue: Vec<Key>,
    body: Vec<Key>,
    known: HashMap<Key, Register>,
    places: Vec<Place>,
}

fn index(n: usize) -> u32 {
    u32::try_from(n).expect("a tape holds fewer than 2^32 registers")
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
            constants: Vec::new(),
            constant_index: HashMap::new(),
            prologue: Vec::new(),
            body: Vec::new(),
            known: HashMap::new(),
            places: Vec::new(),
        }
    }

    fn constant(&mut self, value: f64) -> Register {
        let constants = &mut self.constants;
        *self.constant_index.entry(value.to_bits()).or_insert_with(|| {
            constants.push(value);
            Register::Constant(index(constants.len() - 1))
        })
    }

    /// The register that holds the result of an instruction, new or known.
    fn emit(&mut self, action: Action, a: Register, b: Register, c: Register) -> Register {
        let key = (action, a, b, c);
        if let Some(&register) = self.known.get(&key) {
            return register;
        }
        let register = if a.is_early() && b.is_early() && c.is_early() {
            self.prologue.push(key);
            Register::Prologue(index(self.prologue.len() - 1))
        } else {
            self.body.push(key);
            Register::Body(index(self.body.len() - 1))
        };
        self.known.insert(key, register);
        register
    }

    fn emit_two(&mut self, action: Action, a: Register, b: Register) -> Register {
        self.emit(action, a, b, a)
    }

    /// The register with the value of a step, negated into one of its own if need be.
    fn register(&mut self, position: usize) -> Register {
        let place = self.places[position];
        if !place.is_negated {
            return place.register;
        }
        self.emit_two(Action::Negate, place.register, place.register)
    }

    /// Emits one step.
    fn place(&mut self, pool: &Pool, sweep: &Sweep, step: &Step) -> Result<Place, TapeError> {
        let operands: Vec<usize> = sweep.operands(step).collect();
        let mut is_negated = false;
        let register = match (step.op, operands.as_slice()) {
            (Op::Number, _) => {
                let value = pool.as_number(step.expr).map_or(f64::NAN, Number::to_f64);
                self.constant(value)
            }
            (Op::Pi, _) => self.constant(std::f64::consts::PI),
            (Op::Symbol, _) => {
                let symbol = SymbolId(step.data);
                let unbound = || TapeError::Unbound { symbol, name: pool.symbol_name(symbol) };
                self.symbols.get(&symbol).copied().ok_or_else(unbound)?
            }
            (Op::Add, terms) => self.sum(terms),
            (Op::Mul, &[a, b])
                if pool.as_number(sweep.steps[a].expr) == Some(Number::MINUS_ONE) =>
            {
                let place = self.places[b];
                is_negated = !place.is_negated;
                place.register
            }
            (Op::Mul, factors) => self.product(pool, sweep, factors),
            (Op::Pow, &[base, exponent]) => {
                let number = pool.as_number(sweep.steps[exponent].expr).map(Number::to_f64);
                self.power(base, exponent, number)
            }
            (Op::Call(Function::If), &[condition, pair]) => {
                let mut branches = sweep.operands(&sweep.steps[pair]);
                let (then, otherwise) = (branches.next(), branches.next());
                let condition = self.register(condition);
                let then = then.map_or(condition, |p| self.register(p));
                let otherwise = otherwise.map_or(condition, |p| self.register(p));
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
            // A pair is read by its `if`; its place is never used.
            _ => self.constant(0.0),
        };
        Ok(Place { register, is_negated })
    }

    /// Early terms first, so that they are summed once; positive terms lead.
    fn sum(&mut self, terms: &[usize]) -> Register {
        let mut places: Vec<Place> = terms.iter().map(|&t| self.places[t]).collect();
        places.sort_by_key(|place| (!place.register.is_early(), place.is_negated));
        let first = places[0];
        let mut sum = first.register;
        if first.is_negated {
            // Minus leads: −a + b is b − a if any positive term exists.
            match places.iter().position(|place| !place.is_negated) {
                Some(positive) => {
                    let lead = places.remove(positive);
                    places.insert(0, lead);
                    sum = lead.register;
                }
                None => sum = self.emit_two(Action::Negate, sum, sum),
            }
        }
        for place in &places[1..] {
            let action = if place.is_negated { Action::Subtract } else { Action::Add };
            sum = self.emit_two(action, sum, place.register);
        }
        sum
    }

    /// Numerator over denominator, early factors first in both.
    fn product(&mut self, pool: &Pool, sweep: &Sweep, factors: &[usize]) -> Register {
        let (mut numerator, mut denominator) = (Vec::new(), Vec::new());
        for &factor in factors {
            match reciprocal_base(pool, sweep, factor) {
                Some(base) => denominator.push(self.register(base)),
                None => numerator.push(self.register(factor)),
            }
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

    /// Drops what no output needs and numbers the registers.
    fn finish(self, roots: &[Register], n_parameters: usize, n_inputs: usize) -> Tape {
        let mut needed_prologue = vec![false; self.prologue.len()];
        let mut needed_body = vec![false; self.body.len()];
        let mut need = |register: Register, body: &mut Vec<bool>| match register {
            Register::Prologue(i) => needed_prologue[i as usize] = true,
            Register::Body(i) => body[i as usize] = true,
            _ => (),
        };
        for &root in roots {
            need(root, &mut needed_body);
        }
        for i in (0..self.body.len()).rev() {
            if needed_body[i] {
                let (_, a, b, c) = self.body[i];
                for register in [a, b, c] {
                    need(register, &mut needed_body);
                }
            }
        }
        for i in (0..self.prologue.len()).rev() {
            if needed_prologue[i] {
                let (_, a, b, c) = self.prologue[i];
                for register in [a, b, c] {
                    if let Register::Prologue(operand) = register {
                        needed_prologue[operand as usize] = true;
                    }
                }
            }
        }

        let first_parameter = index(self.constants.len());
        let first_input = first_parameter + index(n_parameters);
        let first_prologue = first_input + index(n_inputs);
        let prologue_numbers = running_numbers(&needed_prologue, first_prologue);
        let n_prologue = needed_prologue.iter().filter(|&&n| n).count();
        let body_numbers = running_numbers(&needed_body, first_prologue + index(n_prologue));
        let number = |register: Register| match register {
            Register::Constant(i) => i,
            Register::Parameter(i) => first_parameter + i,
            Register::Input(i) => first_input + i,
            Register::Prologue(i) => prologue_numbers[i as usize],
            Register::Body(i) => body_numbers[i as usize],
        };
        let keep = |keys: &[Key], needed: &[bool]| -> Vec<Instruction> {
            let kept = keys.iter().zip(needed).filter(|(_, n)| **n);
            kept.map(|(&(action, a, b, c), _)| Instruction {
                action,
                a: number(a),
                b: number(b),
                c: number(c),
            })
            .collect()
        };
        Tape {
            prologue: keep(&self.prologue, &needed_prologue),
            body: keep(&self.body, &needed_body),
            outputs: roots.iter().map(|&root| number(root)).collect(),
            constants: self.constants,
            n_parameters,
            n_inputs,
        }
    }
}

/// Consecutive numbers from `first` for the needed entries.
fn running_numbers(needed: &[bool], first: u32) -> Vec<u32> {
    let mut next = first;
    needed
        .iter()
        .map(|&is_needed| {
            let number = next;
            next += u32::from(is_needed);
            number
        })
        .collect()
}

/// Position of `b` where the step at `position` is `b^(−1)`.
fn reciprocal_base(pool: &Pool, sweep: &Sweep, position: usize) -> Option<usize> {
    let step = &sweep.steps[position];
    if step.op != Op::Pow {
        return None;
    }
    let mut operands = sweep.operands(step);
    let (base, exponent) = (operands.next()?, operands.next()?);
    (pool.as_number(sweep.steps[exponent].expr) == Some(Number::MINUS_ONE)).then_some(base)
}
