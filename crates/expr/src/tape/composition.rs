//! [`Composition`]: a tape made of others and of arithmetic between them, as a step of a Runge–Kutta method is
//! made of evaluations and sums.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::emitter::Emitter;
use super::latency::cycles;
use super::register::{Register, index};
use super::{Action, Instruction, Tape};
use crate::op::Function;

/// A number of a [`Composition`]: an input, a constant, or a result.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Value(Register);

/// A tape in the making. Whatever two calls compute alike, from the same values, is computed once.
///
/// All tapes that it is made of are functions of the same parameters, which become those of the whole.
/// Operations keep their operands and order: the whole gives the bits of its parts, one after the other.
///
/// ```
/// use bksim_expr::{Composition, Pool, Tape};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let pool = Pool::new();
/// let e = pool.parse("k*x")?;
/// let id = |name| pool.find_symbol(name).expect("was parsed");
/// let f = Tape::compile(&pool, &[e], &[id("x")], &[id("k")])?;
///
/// // A step of Euler's method for x' = k x, from the inputs h and x.
/// let mut step = Composition::new(2, 1);
/// let [h, x] = [step.input(0), step.input(1)];
/// let slope = step.call(&f, &[x])[0];
/// let change = step.multiply(h, slope);
/// let end = step.add(x, change);
/// let tape = step.finish(&[end]);
///
/// let mut workspace = tape.workspace(&[2.0]);
/// let mut out = [0.0];
/// tape.evaluate(&mut workspace, &[0.5, 3.0], &mut out);
/// assert_eq!(out, [6.0]);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Composition {
    emitter: Emitter,
    n_inputs: usize,
    n_parameters: usize,
    /// Processor cycles until each input, and each result, is known.
    known_after: KnownAfter,
}

#[derive(Debug, Default)]
struct KnownAfter {
    inputs: Vec<u32>,
    results: Vec<u32>,
}

impl KnownAfter {
    fn of(&self, register: Register) -> u32 {
        match register {
            Register::Input(i) => self.inputs[i as usize],
            Register::Body(i) => self.results[i as usize],
            Register::Constant(_) | Register::Parameter(_) | Register::Prologue(_) => 0,
        }
    }
}

impl Composition {
    /// A tape of so many inputs and parameters, empty so far.
    pub fn new(n_inputs: usize, n_parameters: usize) -> Self {
        let known_after = KnownAfter { inputs: vec![0; n_inputs], results: Vec::new() };
        Self { emitter: Emitter::default(), n_inputs, n_parameters, known_after }
    }

    /// Input number `i`.
    ///
    /// # Panics
    /// When there are not so many.
    pub fn input(&self, i: usize) -> Value {
        assert!(i < self.n_inputs, "input {i} of {}", self.n_inputs);
        Value(Register::Input(index(i)))
    }

    /// States that input number `i` is known so many processor cycles after the first of them:
    /// [`Composition::signed_sum`] goes by that.
    ///
    /// # Panics
    /// When there are not so many inputs.
    pub fn delay_input(&mut self, i: usize, cycles: u32) {
        self.known_after.inputs[i] = cycles;
    }

    /// A number known now.
    pub fn constant(&mut self, value: f64) -> Value {
        Value(self.emitter.constant(value))
    }

    /// `a + b`.
    pub fn add(&mut self, a: Value, b: Value) -> Value {
        self.emit(Action::Add, a, b)
    }

    /// `a b`; factors of zero, one and minus one that are known now cost no product.
    pub fn multiply(&mut self, a: Value, b: Value) -> Value {
        match (self.number(a), self.number(b)) {
            (_, Some(1.0)) | (Some(0.0), _) => a,
            (Some(1.0), _) | (_, Some(0.0)) => b,
            (_, Some(-1.0)) => self.negate(a),
            (Some(-1.0), _) => self.negate(b),
            _ => self.emit(Action::Multiply, a, b),
        }
    }

    /// `−a`.
    pub fn negate(&mut self, a: Value) -> Value {
        self.emit(Action::Negate, a, a)
    }

    /// `Σ plus − Σ minus`, in the order in which the terms are known.
    pub fn signed_sum(&mut self, plus: &[Value], minus: &[Value]) -> Value {
        // Those known first come first, of these the first.
        let mut values: Vec<(Value, bool)> = plus.iter().map(|&value| (value, false)).collect();
        values.extend(minus.iter().map(|&value| (value, true)));
        values.retain(|&(value, _)| self.number(value) != Some(0.0));
        let wait = |this: &Self, (Value(register), _), number| {
            Reverse((this.known_after.of(register), number))
        };
        let mut waiting: BinaryHeap<Reverse<(u32, usize)>> =
            values.iter().enumerate().map(|(number, &value)| wait(self, value, number)).collect();
        while waiting.len() > 1 {
            let [a, b] = [(); 2].map(|()| waiting.pop().map_or(0, |Reverse((_, number))| number));
            let (a, b) = (values[a.min(b)], values[a.max(b)]);
            let sum = match (a, b) {
                ((a, false), (b, true)) => (self.subtract(a, b), false),
                ((a, true), (b, false)) => (self.subtract(b, a), false),
                ((a, is_negative), (b, _)) => (self.add(a, b), is_negative),
            };
            waiting.push(wait(self, sum, values.len()));
            values.push(sum);
        }
        match values.last() {
            None => self.constant(0.0),
            Some(&(value, false)) => value,
            Some(&(value, true)) => self.negate(value),
        }
    }

    /// The number that a value is, where it is known now.
    pub fn number(&self, Value(register): Value) -> Option<f64> {
        self.emitter.number(register)
    }

    /// `a − b`.
    pub fn subtract(&mut self, a: Value, b: Value) -> Value {
        self.emit(Action::Subtract, a, b)
    }

    /// `a/b`.
    pub fn divide(&mut self, a: Value, b: Value) -> Value {
        self.emit(Action::Divide, a, b)
    }

    /// A function at as many values as it takes.
    ///
    /// # Panics
    /// When it takes another number of them.
    pub fn apply(&mut self, function: Function, operands: &[Value]) -> Value {
        assert_eq!(function.arity(), operands.len(), "number of operands");
        let operands = std::array::from_fn(|i| *operands.get(i).unwrap_or(&operands[0]));
        self.emit_three(Action::Call(function), operands)
    }

    /// Any operation; operands that it does not take are not read.
    pub(super) fn emit_three(&mut self, action: Action, operands: [Value; 3]) -> Value {
        let operands = operands.map(|Value(register)| register);
        Value(self.emit_registers(action, operands))
    }

    fn emit_registers(&mut self, action: Action, operands: [Register; 3]) -> Register {
        let [a, b, c] = operands;
        let register = self.emitter.emit(action, a, b, c);
        if let Register::Body(i) = register
            && i as usize == self.known_after.results.len()
        {
            let last = operands.map(|operand| self.known_after.of(operand)).into_iter().max();
            self.known_after.results.push(last.unwrap_or(0) + cycles(action));
        }
        register
    }

    fn emit(&mut self, action: Action, a: Value, b: Value) -> Value {
        self.emit_three(action, [a, b, a])
    }

    /// The outputs of a tape at these inputs.
    ///
    /// # Panics
    /// When the tape has another number of inputs, or of parameters than the whole.
    pub fn call(&mut self, tape: &Tape, inputs: &[Value]) -> Vec<Value> {
        assert_eq!(inputs.len(), tape.n_inputs, "number of inputs");
        assert_eq!(self.n_parameters, tape.n_parameters, "number of parameters");
        // The registers of the tape in their order, by those here.
        let constants = tape.constants.iter().map(|&value| self.emitter.constant(value));
        let mut registers: Vec<Register> = constants.collect();
        registers.extend((0..tape.n_parameters).map(|i| Register::Parameter(index(i))));
        registers.extend(inputs.iter().map(|&Value(register)| register));
        for (number, Instruction { action, a, b, c }) in tape.operations() {
            debug_assert_eq!(number, registers.len(), "registers are written in their order");
            let [a, b, c] = [a, b, c].map(|register| registers[register as usize]);
            registers.push(self.emit_registers(action, [a, b, c]));
        }
        tape.outputs.iter().map(|&output| Value(registers[output as usize])).collect()
    }

    /// The tape with these outputs.
    pub fn finish(self, outputs: &[Value]) -> Tape {
        let outputs: Vec<Register> = outputs.iter().map(|&Value(register)| register).collect();
        self.emitter.finish(&outputs, self.n_parameters, self.n_inputs)
    }
}
