//! [`Composition`]: a tape made of others and of arithmetic between them, as a step of a Runge–Kutta method is
//! made of evaluations and sums.

use super::emitter::Emitter;
use super::register::{Register, index};
use super::{Action, Instruction, Tape};
use crate::op::Function;

/// A number of a [`Composition`]: an input, a constant, or a result.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Value(Register);

impl Value {
    /// Parameter number `i`.
    pub(super) fn parameter(i: usize) -> Self {
        Self(Register::Parameter(index(i)))
    }
}

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
}

impl Composition {
    /// A tape of so many inputs and parameters, empty so far.
    pub fn new(n_inputs: usize, n_parameters: usize) -> Self {
        Self { emitter: Emitter::default(), n_inputs, n_parameters }
    }

    /// Input number `i`.
    ///
    /// # Panics
    /// When there are not so many.
    pub fn input(&self, i: usize) -> Value {
        assert!(i < self.n_inputs, "input {i} of {}", self.n_inputs);
        Value(Register::Input(index(i)))
    }

    /// A number known now.
    pub fn constant(&mut self, value: f64) -> Value {
        Value(self.emitter.constant(value))
    }

    /// `a + b`.
    pub fn add(&mut self, a: Value, b: Value) -> Value {
        self.emit(Action::Add, a, b)
    }

    /// `a b`.
    pub fn multiply(&mut self, a: Value, b: Value) -> Value {
        self.emit(Action::Multiply, a, b)
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
        let [a, b, c] = std::array::from_fn(|i| operands.get(i).unwrap_or(&operands[0]).0);
        Value(self.emitter.emit(Action::Call(function), a, b, c))
    }

    pub(super) fn n_parameters(&self) -> usize {
        self.n_parameters
    }

    /// Any operation; operands that it does not take are not read.
    pub(super) fn emit_three(&mut self, action: Action, operands: [Value; 3]) -> Value {
        let [a, b, c] = operands.map(|Value(register)| register);
        Value(self.emitter.emit(action, a, b, c))
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
            registers.push(self.emitter.emit(action, a, b, c));
        }
        tape.outputs.iter().map(|&output| Value(registers[output as usize])).collect()
    }

    /// The tape with these outputs.
    pub fn finish(self, outputs: &[Value]) -> Tape {
        let outputs: Vec<Register> = outputs.iter().map(|&Value(register)| register).collect();
        self.emitter.finish(&outputs, self.n_parameters, self.n_inputs)
    }
}
