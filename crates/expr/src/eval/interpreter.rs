//! The interpreter: one instruction after the other at one point.

use super::lanes::{EXTRA, LaneValues};
use crate::op::{Function, power, select};
use crate::sincos::{FEW, sin_cos_few};
use crate::tape::{Action, Instruction, Tape};

/// The registers of a [`Tape`] with its parameters set.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// Some that machine code needs, those of the tape, then as many as code has asked for.
    pub(super) memory: LaneValues<1>,
    /// Number of registers of the tape.
    n_registers: usize,
}

impl Workspace {
    /// The registers of the tape.
    pub(super) fn registers(&mut self) -> &mut [f64] {
        &mut self.memory.as_flattened_mut()[EXTRA.len()..][..self.n_registers]
    }
}

impl Tape {
    /// Registers for this tape, with everything computed that depends on parameters only.
    ///
    /// # Panics
    /// When the number of parameters differs from the compiled one.
    pub fn workspace(&self, parameters: &[f64]) -> Workspace {
        let mut memory = LaneValues::zeros(EXTRA.len() + self.n_registers);
        let (extra, registers) = memory.as_flattened_mut().split_at_mut(EXTRA.len());
        extra.copy_from_slice(&EXTRA);
        self.write_known(parameters, registers);
        Workspace { memory, n_registers: self.n_registers }
    }

    /// Writes constants, parameters and what depends on these alone to the first registers.
    fn write_known(&self, parameters: &[f64], registers: &mut [f64]) {
        assert_eq!(parameters.len(), self.n_parameters, "number of parameters");
        let (constants, rest) = registers.split_at_mut(self.constants.len());
        constants.copy_from_slice(&self.constants);
        rest[..parameters.len()].copy_from_slice(parameters);
        self.run(&self.prologue, registers, self.first_prologue());
    }

    /// The first `n` registers: constants, parameters, and what depends on these alone, then zeros.
    pub(super) fn known(&self, parameters: &[f64], n: usize) -> Vec<f64> {
        let mut registers = vec![0.0; n];
        self.write_known(parameters, &mut registers);
        registers
    }

    /// Computes all outputs.
    ///
    /// # Panics
    /// When `inputs` or `out` have another length than was compiled, or `ws` is of another tape.
    pub fn evaluate(&self, ws: &mut Workspace, inputs: &[f64], out: &mut [f64]) {
        self.check(ws, inputs, out);
        let registers = ws.registers();
        registers[self.input_registers()].copy_from_slice(inputs);
        self.run(&self.body, registers, self.first_body);
        for (value, &register) in out.iter_mut().zip(&self.outputs) {
            *value = registers[register as usize];
        }
    }

    /// Refuses arrays and workspaces that do not fit the tape.
    pub(super) fn check(&self, ws: &Workspace, inputs: &[f64], out: &[f64]) {
        assert_eq!(inputs.len(), self.n_inputs, "number of inputs");
        assert_eq!(out.len(), self.outputs.len(), "number of outputs");
        assert_eq!(ws.n_registers, self.n_registers, "a workspace of this tape");
    }

    /// Runs instructions; the first writes register `next`, each further one those that follow.
    fn run(&self, instructions: &[Instruction], registers: &mut [f64], mut next: usize) {
        for instruction in instructions {
            if instruction.action == Action::Turn {
                turn(self.angles_of(instruction), registers, next);
                next += instruction.n_results();
                continue;
            }
            let (a, b) = (registers[instruction.a as usize], registers[instruction.b as usize]);
            registers[next] = match instruction.action {
                Action::Add => a + b,
                Action::Subtract => a - b,
                Action::Multiply => a * b,
                Action::Divide => a / b,
                Action::Negate => -a,
                Action::Power => power(a, b),
                Action::Call(Function::If) => select(a, b, registers[instruction.c as usize]),
                Action::Call(function) => function.value(a, b),
                Action::Turn => unreachable!("turns are executed above"),
            };
            next += 1;
        }
    }
}

/// Sines of all angles, then their cosines, into the registers from `first` on.
fn turn(angles: &[u32], registers: &mut [f64], first: usize) {
    let (known, results) = registers.split_at_mut(first);
    let (sines, cosines) = results.split_at_mut(angles.len());
    let results = sines.chunks_mut(FEW).zip(cosines.chunks_mut(FEW));
    for (angles, (sines, cosines)) in angles.chunks(FEW).zip(results) {
        let angle = |lane| known[*angles.get(lane).unwrap_or(&angles[0]) as usize];
        let n = angles.len();
        sin_cos_few([angle(0), angle(1), angle(2), angle(3)], sines, &mut cosines[..n]);
    }
}
