//! [`Program`]: the body of a tape as operations of machine code, sines and cosines written out where that is less than a
//! call.

use super::assembler::{Opcode, Width};
use super::{EXTRA, Extra};
use crate::tape::{Action, Tape};

/// Angles at which a call is less than to write them out for one point each: it takes four at once.
const WORTH_A_CALL: usize = 3;

/// How the sines and cosines of a tape are computed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Turns {
    /// Where that is less, by operations of the code itself, which are good for angles that add up to no more than
    /// [`LARGEST`](crate::sincos::LARGEST).
    Written,
    /// By calls.
    Called,
}

/// Operations in their order. Values are those of the registers of the tape, then the numbers that code needs, then parts
/// of sines and cosines.
pub(super) struct Program {
    pub(super) operations: Vec<Operation>,
    /// The angles of turns that are called.
    pub(super) angles: Vec<usize>,
    pub(super) n_values: usize,
    /// The values before the body of the tape.
    n_known: usize,
    /// The first of the numbers that code needs.
    first_extra: usize,
    /// The sum of the magnitudes of all angles that are written out.
    pub(super) total_angle: Option<usize>,
    /// The outputs of the tape by the value that each is, in ascending order.
    pub(super) outputs: Vec<(usize, i32)>,
}

/// An operation on values, operands that it does not take repeated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Operation {
    pub(super) kind: Kind,
    pub(super) operands: [usize; 3],
    /// The first of its results.
    pub(super) result: usize,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    /// An operation of the tape that has one result.
    Action(Action),
    /// Sines and cosines of so many angles in [`Program::angles`], from the first operand on.
    Turn(usize),
    /// Of the bits of two numbers.
    Bits(Opcode),
    /// Bits, moved to the left.
    ShiftLeft(u8),
    /// The second operand where the first is below zero, else the third.
    IfNegative,
}

impl Program {
    /// The body of a tape.
    pub(super) fn of(tape: &Tape, width: Width, turns: Turns) -> Self {
        let mut program = Self {
            operations: Vec::with_capacity(tape.body.len()),
            angles: Vec::new(),
            n_values: tape.n_registers + EXTRA.len(),
            n_known: tape.first_body,
            first_extra: tape.n_registers,
            total_angle: None,
            outputs: Vec::new(),
        };
        // Registers of the tape that are written out have other values.
        let mut values: Vec<usize> = (0..tape.n_registers).collect();
        let mut result = tape.first_body;
        for instruction in &tape.body {
            if instruction.action == Action::Turn {
                let angles = tape.angles_of(instruction).iter();
                let angles: Vec<usize> = angles.map(|&angle| values[angle as usize]).collect();
                let n = angles.len();
                let is_called = turns == Turns::Called || width == Width::One && n >= WORTH_A_CALL;
                if is_called {
                    let first = program.angles.len();
                    program.angles.extend(angles);
                    let operands = [first; 3];
                    program.operations.push(Operation { kind: Kind::Turn(n), operands, result });
                } else {
                    for (i, angle) in angles.into_iter().enumerate() {
                        program.add_angle(angle);
                        let [sine, cosine] = program.turn(angle);
                        (values[result + i], values[result + n + i]) = (sine, cosine);
                    }
                }
            } else {
                let operands = [instruction.a, instruction.b, instruction.c];
                let operands = operands.map(|register| values[register as usize]);
                let kind = Kind::Action(instruction.action);
                program.operations.push(Operation { kind, operands, result });
            }
            result += instruction.n_results();
        }
        let outputs = tape.outputs.iter().map(|&register| values[register as usize]);
        program.outputs = outputs.zip(0..).collect();
        program.outputs.sort_unstable();
        program.drop_unread();
        program
    }

    /// Values that an operation reads.
    pub(super) fn read<'p>(&'p self, operation: &'p Operation) -> &'p [usize] {
        let Operation { kind, operands, .. } = operation;
        match *kind {
            Kind::Turn(n) => &self.angles[operands[0]..][..n],
            Kind::ShiftLeft(_) | Kind::Action(Action::Negate) => &operands[..1],
            Kind::IfNegative => operands,
            Kind::Action(Action::Call(function)) => &operands[..function.arity()],
            Kind::Action(_) | Kind::Bits(_) => &operands[..2],
        }
    }

    /// True for values that are in memory before the code runs: those before the body, and the numbers that it needs.
    pub(super) fn is_known(&self, value: usize) -> bool {
        value < self.n_known || (self.first_extra..self.first_extra + EXTRA.len()).contains(&value)
    }

    /// The value of a number that code needs.
    pub(super) fn extra(&self, extra: Extra) -> usize {
        self.first_extra + extra as usize
    }

    /// A new value by an operation.
    pub(super) fn push(&mut self, kind: Kind, operands: [usize; 3]) -> usize {
        let result = self.n_values;
        self.n_values += 1;
        self.operations.push(Operation { kind, operands, result });
        result
    }

    /// Adds the magnitude of an angle to that of all.
    fn add_angle(&mut self, angle: usize) {
        let size = [angle, self.extra(Extra::AbsMask), angle];
        let size = self.push(Kind::Bits(Opcode::And), size);
        self.total_angle = Some(match self.total_angle {
            None => size,
            Some(total) => self.push(Kind::Action(Action::Add), [total, size, total]),
        });
    }

    /// Leaves out operations whose results nothing reads: a sine without its cosine.
    fn drop_unread(&mut self) {
        let mut is_read = vec![false; self.n_values];
        let ends = self.outputs.iter().map(|&(value, _)| value).chain(self.total_angle);
        ends.for_each(|value| is_read[value] = true);
        let mut kept = Vec::with_capacity(self.operations.len());
        for operation in self.operations.iter().rev() {
            let results = operation.result..operation.result + operation.kind.n_results();
            if is_read[results].contains(&true) {
                self.read(operation).iter().for_each(|&value| is_read[value] = true);
                kept.push(*operation);
            }
        }
        kept.reverse();
        self.operations = kept;
    }
}

impl Kind {
    /// Values that follow each other from the result on.
    pub(super) fn n_results(self) -> usize {
        match self {
            Self::Turn(n) => 2 * n,
            _ => 1,
        }
    }
}

/// The operations that read each value, and how many of them are done.
pub(super) struct Uses {
    times: Vec<Vec<usize>>,
    done: Vec<usize>,
}

impl Uses {
    pub(super) fn new(program: &Program) -> Self {
        let mut times = vec![Vec::new(); program.n_values];
        for (time, operation) in program.operations.iter().enumerate() {
            program.read(operation).iter().for_each(|&value| times[value].push(time));
        }
        // What is looked at after the last of them.
        if let Some(total) = program.total_angle {
            times[total].push(program.operations.len());
        }
        Self { done: vec![0; times.len()], times }
    }

    /// The next operation that reads a value.
    pub(super) fn next(&self, value: usize) -> Option<usize> {
        self.times[value].get(self.done[value]).copied()
    }

    /// The operation at `time` is done with a value.
    pub(super) fn pass(&mut self, value: usize, time: usize) {
        while self.next(value).is_some_and(|next| next <= time) {
            self.done[value] += 1;
        }
    }
}
