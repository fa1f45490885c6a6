//! Operations of a program as machine instructions: the place of every value, in a vector register or in memory.
//!
//! Values known beforehand and inputs are read from memory each time: an operand in memory costs nothing.
//! Where registers are short, the value whose next use is farthest goes to memory (L. A. Belady 1966).
//! Operations are those of the interpreter in the same order.

#[cfg(test)]
mod tests;

use super::assembler::{Argument, Assembler, Base, Opcode, Operand, Predicate, Vector, Width};
use super::program::{Kind, Operation, Program, Turns, Uses};
use super::{EXTRA, Extra, Layout};
use crate::op::Function;
use crate::tape::{Action, Tape};

/// Addresses of the functions that code calls.
#[derive(Clone, Copy, Debug)]
pub(super) struct Callees {
    /// `f(angles, n)`: angles become their sines, and the n after them their cosines.
    pub(super) turn: u64,
    /// `f(a, b, function)`: a number becomes the function of it and another.
    pub(super) elementary: u64,
    /// Address of the general power.
    pub(super) power: u64,
}

/// The machine instructions of the body of a tape.
pub(super) struct Body {
    pub(super) bytes: Vec<u8>,
    /// Registers that they read and write.
    pub(super) n_registers: usize,
    /// True where the sum of the magnitudes of all angles is left in [`Extra::TotalAngle`].
    pub(super) has_angles: bool,
}

/// The whole body, from the registers that are known before it.
pub(super) fn assemble(
    tape: &Tape,
    (width, layout): (Width, Layout),
    turns: Turns,
    callees: Callees,
) -> Body {
    let program = Program::of(tape, width, turns);
    let mut allocation = Allocation::new(tape, &program, (width, layout), callees);
    allocation.code.enter();
    allocation.body();
    allocation.code.leave();
    // Bits of one number are read with those behind it.
    let n_registers = allocation.memory.n_registers + 1;
    let has_angles = program.total_angle.is_some();
    Body { bytes: allocation.code.bytes, n_registers, has_angles }
}

struct Allocation<'a> {
    tape: &'a Tape,
    program: &'a Program,
    callees: Callees,
    code: Assembler,
    width: Width,
    /// The value in each vector register that holds values.
    values: Vec<Option<usize>>,
    /// A register for the moment.
    scratch: Vector,
    /// The vector register of each value.
    vectors: Vec<Option<Vector>>,
    memory: Memory,
    uses: Uses,
}

/// Places in memory, of which those of values that are no longer read are given again.
struct Memory {
    /// Of each value that memory holds.
    places: Vec<Option<usize>>,
    free: Vec<usize>,
    n_registers: usize,
}

impl Memory {
    fn new(tape: &Tape, program: &Program) -> Self {
        let mut places = vec![None; program.n_values];
        let first = EXTRA.len();
        (0..tape.first_body).for_each(|value| places[value] = Some(first + value));
        let extras = &mut places[tape.n_registers..][..first];
        extras.iter_mut().enumerate().for_each(|(place, of)| *of = Some(place));
        Self { places, free: Vec::new(), n_registers: first + tape.first_body }
    }

    /// Gives a value a place.
    fn give(&mut self, value: usize) -> usize {
        let place = self.free.pop().unwrap_or_else(|| self.new_places(1));
        self.places[value] = Some(place);
        place
    }

    /// Gives these values places one after the other.
    fn give_in_a_row(&mut self, values: std::ops::Range<usize>) -> usize {
        let first = self.new_places(values.len());
        for (value, place) in values.zip(first..) {
            self.places[value] = Some(place);
        }
        first
    }

    fn new_places(&mut self, n: usize) -> usize {
        let first = self.n_registers;
        self.n_registers += n;
        first
    }

    /// Takes the place of a value of the body back, if it has one.
    fn take_back(&mut self, value: usize) {
        self.free.extend(self.places[value].take());
    }
}

/// The place of a number in an array.
fn number(n: usize) -> i32 {
    i32::try_from(n).expect("tapes that are compiled have fewer than 2^31 registers")
}

impl<'a> Allocation<'a> {
    fn new(
        tape: &'a Tape,
        program: &'a Program,
        (width, layout): (Width, Layout),
        callees: Callees,
    ) -> Self {
        // Two registers are for the moment, one of them for masks.
        let n_vectors = width.n_vectors() - 2;
        Self {
            tape,
            program,
            callees,
            code: Assembler::new(width, layout, Vector(n_vectors + 1)),
            width,
            values: vec![None; n_vectors as usize],
            scratch: Vector(n_vectors),
            vectors: vec![None; program.n_values],
            memory: Memory::new(tape, program),
            uses: Uses::new(program),
        }
    }

    fn body(&mut self) {
        let program = self.program;
        (0..self.tape.first_body).for_each(|value| self.copy_to_outputs(value));
        for (time, operation) in program.operations.iter().enumerate() {
            self.operation(time, operation);
            for &value in program.read(operation) {
                self.release(value, time);
                // Not before: its place may be read after room was made for the result.
                if !program.is_known(value) && self.uses.next(value).is_none() {
                    self.memory.take_back(value);
                }
            }
        }
        if let Some(total) = program.total_angle {
            let vector = self.vector(total);
            self.code.store(Base::Registers, Extra::TotalAngle as i32, vector);
        }
    }

    fn operation(&mut self, time: usize, operation: &Operation) {
        let &Operation { kind, operands, result } = operation;
        let [a, b, _] = operands;
        let [sign, rest] = [Extra::SignMask, Extra::AbsMask]
            .map(|extra| Operand::Memory(Base::Registers, extra as i32));
        match kind {
            Kind::Turn(_) => self.turn(self.program.read(operation), result),
            Kind::Bits(opcode) => self.commutative(opcode, [a, b], result, time),
            Kind::ShiftLeft(n) => self.shift(a, n, result, time),
            Kind::IfNegative => self.choose(operands, result),
            Kind::Action(action) => match action {
                Action::Add => self.commutative(Opcode::Add, [a, b], result, time),
                Action::Multiply => self.commutative(Opcode::Multiply, [a, b], result, time),
                Action::Subtract => self.binary(Opcode::Subtract, [a, b], result, time),
                Action::Divide => self.binary(Opcode::Divide, [a, b], result, time),
                Action::Negate => self.with(Opcode::Xor, [a, a], sign, result, time),
                Action::Power => self.call(self.callees.power, 0, [a, b], result),
                Action::Call(Function::Abs) => {
                    self.with(Opcode::And, [a, a], rest, result, time);
                }
                Action::Call(Function::Sqrt) => self.root(a, result, time),
                Action::Call(Function::Sign) => self.sign(a, result),
                Action::Call(Function::If) => self.branch(operands, result),
                Action::Call(function) => {
                    if let Some(predicate) = predicate(function) {
                        self.comparison(function, predicate, [a, b], result);
                    } else {
                        let b = if function.arity() == 1 { a } else { b };
                        self.call(self.callees.elementary, function as u32, [a, b], result);
                    }
                }
                Action::Turn => unreachable!("turns are operations of their own"),
            },
        }
    }

    /// Where a value is.
    fn place(&self, value: usize) -> Operand {
        let inputs = self.tape.input_registers();
        match self.vectors[value] {
            Some(vector) => Operand::Vector(vector),
            None if inputs.contains(&value) => {
                Operand::Memory(Base::Inputs, number(value - inputs.start))
            }
            None => {
                let place = self.memory.places[value]
                    .expect("values are somewhere until they are read last");
                Operand::Memory(Base::Registers, number(place))
            }
        }
    }

    fn commutative(&mut self, opcode: Opcode, [a, b]: [usize; 2], result: usize, time: usize) {
        let is_swapped = self.vectors[a].is_none() && self.vectors[b].is_some();
        self.binary(opcode, if is_swapped { [b, a] } else { [a, b] }, result, time);
    }

    fn binary(&mut self, opcode: Opcode, [a, b]: [usize; 2], result: usize, time: usize) {
        let place = self.place(b);
        self.with(opcode, [a, b], place, result, time);
    }

    /// `result = a op place` for the first of the operands; both are read before the result is written.
    fn with(
        &mut self,
        opcode: Opcode,
        operands: [usize; 2],
        place: Operand,
        result: usize,
        time: usize,
    ) {
        let out = match self.place(operands[0]) {
            first @ Operand::Vector(vector) => {
                for value in operands {
                    self.release(value, time);
                }
                let out = self.free(&[first, place]);
                self.code.operate(opcode, out, vector, place);
                out
            }
            first @ Operand::Memory(..) => {
                let out = self.free(&[place]);
                self.code.load(out, first);
                self.code.operate(opcode, out, out, place);
                out
            }
        };
        self.bind(result, out);
    }

    fn root(&mut self, a: usize, result: usize, time: usize) {
        let place = self.place(a);
        self.release(a, time);
        let out = self.free(&[place]);
        self.code.operate(Opcode::Sqrt, out, out, place);
        self.bind(result, out);
    }

    /// `a` in a vector register, at worst one for the moment.
    fn vector(&mut self, a: usize) -> Vector {
        match self.place(a) {
            Operand::Vector(vector) => vector,
            place @ Operand::Memory(..) => {
                self.code.load(self.scratch, place);
                self.scratch
            }
        }
    }

    /// A register for a result while all operands stay as they are, with one of them in it.
    fn free_with(&mut self, first: usize, operands: &[usize]) -> Vector {
        let places: Vec<Operand> = operands.iter().map(|&value| self.place(value)).collect();
        let out = self.free(&places);
        self.code.load(out, self.place(first));
        out
    }

    /// One or zero by a comparison, or the operand that it prefers.
    fn comparison(
        &mut self,
        function: Function,
        predicate: Predicate,
        [a, b]: [usize; 2],
        result: usize,
    ) {
        let vector = self.vector(a);
        let other = self.place(b);
        let out = if matches!(function, Function::Min | Function::Max) {
            // `a` where it compares so with `b` or is NaN, else `b`.
            let out = self.free_with(b, &[a, b]);
            self.code.compare(Predicate::Unordered, vector, Operand::Vector(vector));
            self.code.blend(out, out, Operand::Vector(vector));
            self.code.compare(predicate, vector, other);
            self.code.blend(out, out, Operand::Vector(vector));
            out
        } else {
            let out = self.free(&[Operand::Vector(vector), other]);
            self.code.compare(predicate, vector, other);
            self.code.keep(out, Operand::Memory(Base::Registers, Extra::One as i32));
            out
        };
        self.bind(result, out);
    }

    /// The sign of `a`, or `a` where it is zero or NaN.
    fn sign(&mut self, a: usize, result: usize) {
        let vector = self.vector(a);
        let out = self.free(&[Operand::Vector(vector)]);
        let [sign, one, zero] = [Extra::SignMask, Extra::One, Extra::Zero]
            .map(|extra| Operand::Memory(Base::Registers, extra as i32));
        self.code.operate(Opcode::And, out, vector, sign);
        self.code.operate(Opcode::Or, out, out, one);
        self.code.compare(Predicate::EqualOrUnordered, vector, zero);
        self.code.blend(out, out, Operand::Vector(vector));
        self.bind(result, out);
    }

    /// `if(a, b, c)`: c where a is zero, a where it is NaN, else b.
    fn branch(&mut self, [a, b, c]: [usize; 3], result: usize) {
        let vector = self.vector(a);
        let out = self.free_with(b, &[a, b, c]);
        let zero = Operand::Memory(Base::Registers, Extra::Zero as i32);
        let other = self.place(c);
        self.code.compare(Predicate::Equal, vector, zero);
        self.code.blend(out, out, other);
        self.code.compare(Predicate::Unordered, vector, Operand::Vector(vector));
        self.code.blend(out, out, Operand::Vector(vector));
        self.bind(result, out);
    }

    /// Bits of `a`, moved to the left.
    fn shift(&mut self, a: usize, n: u8, result: usize, time: usize) {
        let vector = self.vector(a);
        self.release(a, time);
        let out = self.free(&[Operand::Vector(vector)]);
        self.code.shift_left(out, vector, n);
        self.bind(result, out);
    }

    /// `b` where a is below zero, else `c`.
    fn choose(&mut self, [a, b, c]: [usize; 3], result: usize) {
        let vector = self.vector(a);
        let zero = Operand::Memory(Base::Registers, Extra::Zero as i32);
        self.code.compare(Predicate::Less, vector, zero);
        let out = self.free_with(c, &[b, c]);
        let other = self.place(b);
        self.code.blend(out, out, other);
        self.bind(result, out);
    }

    /// All angles at once, where their results will be.
    fn turn(&mut self, angles: &[usize], result: usize) {
        self.store_all();
        let results = result..result + 2 * angles.len();
        let first = self.memory.give_in_a_row(results.clone());
        for (place, &angle) in (first..).zip(angles) {
            self.copy(angle, number(place));
        }
        self.code.pass_address(Argument::First, number(first));
        let n = u32::try_from(angles.len()).expect("fewer angles than registers");
        self.code.pass_number(Argument::Second, n);
        self.code.call(self.callees.turn);
        results.for_each(|value| self.bind_stored(value));
    }

    fn call(&mut self, callee: u64, function: u32, [a, b]: [usize; 2], result: usize) {
        self.store_all();
        let (place, operand) = (self.memory.give(result), Extra::Operand as i32);
        self.copy(a, number(place));
        self.copy(b, operand);
        self.code.pass_address(Argument::First, number(place));
        self.code.pass_address(Argument::Second, operand);
        self.code.pass_number(Argument::Third, function);
        self.code.call(callee);
        self.bind_stored(result);
    }

    /// Number of the vector registers that hold values.
    fn n_vectors(&self) -> u8 {
        self.width.n_vectors() - 2
    }

    /// A stored value into another place of the registers.
    fn copy(&mut self, value: usize, to: i32) {
        let place = self.place(value);
        self.code.load(self.scratch, place);
        self.code.store(Base::Registers, to, self.scratch);
    }

    /// Puts all values that are still read into memory, and empties the vector registers.
    fn store_all(&mut self) {
        for vector in 0..self.n_vectors() {
            self.evict(Vector(vector));
        }
    }

    fn evict(&mut self, vector: Vector) {
        let Some(value) = self.values[vector.0 as usize].take() else { return };
        self.vectors[value] = None;
        if self.memory.places[value].is_none() && self.uses.next(value).is_some() {
            let place = self.memory.give(value);
            self.code.store(Base::Registers, number(place), vector);
        }
    }

    /// A register that holds nothing, none of those kept.
    fn free(&mut self, kept: &[Operand]) -> Vector {
        let empty = (0..self.n_vectors()).find(|&n| self.values[n as usize].is_none());
        if let Some(n) = empty {
            return Vector(n);
        }
        let is_kept = |&n: &u8| kept.contains(&Operand::Vector(Vector(n)));
        let next = |n: u8| self.values[n as usize].and_then(|value| self.uses.next(value));
        let others = (0..self.n_vectors()).filter(|n| !is_kept(n));
        // A value that is never read again is the farthest of all.
        let farthest = others.max_by_key(|&n| next(n).unwrap_or(usize::MAX));
        let vector = Vector(farthest.expect("fewer operands than registers"));
        self.evict(vector);
        vector
    }

    /// The instruction at `time` is done with a value.
    fn release(&mut self, value: usize, time: usize) {
        self.uses.pass(value, time);
        if self.uses.next(value).is_none()
            && let Some(Vector(n)) = self.vectors[value].take()
        {
            self.values[n as usize] = None;
        }
    }

    /// A vector register holds a new value.
    fn bind(&mut self, value: usize, vector: Vector) {
        for &(_, output) in self.outputs_of(value) {
            self.code.store(Base::Outputs, output, vector);
        }
        if self.uses.next(value).is_some() {
            self.values[vector.0 as usize] = Some(value);
            self.vectors[value] = Some(vector);
        }
    }

    /// Memory holds a new value.
    fn bind_stored(&mut self, value: usize) {
        self.copy_to_outputs(value);
        if self.uses.next(value).is_none() {
            self.memory.take_back(value);
        }
    }

    fn copy_to_outputs(&mut self, value: usize) {
        for &(_, output) in self.outputs_of(value) {
            self.code.load(self.scratch, self.place(value));
            self.code.store(Base::Outputs, output, self.scratch);
        }
    }

    fn outputs_of(&self, value: usize) -> &'a [(usize, i32)] {
        let outputs = &self.program.outputs;
        let start = outputs.partition_point(|&(of, _)| of < value);
        let end = outputs.partition_point(|&(of, _)| of <= value);
        &outputs[start..end]
    }
}

/// How a function of two operands compares them.
fn predicate(function: Function) -> Option<Predicate> {
    Some(match function {
        Function::Min | Function::Le => Predicate::LessOrEqual,
        Function::Max | Function::Ge => Predicate::GreaterOrEqual,
        Function::Lt => Predicate::Less,
        Function::Gt => Predicate::Greater,
        _ => return None,
    })
}
