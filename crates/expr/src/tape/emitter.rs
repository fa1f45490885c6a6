//! [`Emitter`]: the instructions of a tape as they come, each written once, and the tape that they make.

use super::register::{Key, Register, index};
use super::schedule::Section;
use super::{Action, Tape};
use crate::handle::HandleHash;
use std::collections::HashMap;

/// Instructions before their order is known.
#[derive(Debug, Default)]
pub(super) struct Emitter {
    constants: Vec<f64>,
    constant_index: HashMap<u64, Register>,
    prologue: Vec<Key>,
    body: Vec<Key>,
    known: HashMap<Key, Register, HandleHash>,
}

impl Emitter {
    /// The register of a number.
    pub(super) fn constant(&mut self, value: f64) -> Register {
        let constants = &mut self.constants;
        *self.constant_index.entry(value.to_bits()).or_insert_with(|| {
            constants.push(value);
            Register::Constant(index(constants.len() - 1))
        })
    }

    /// The number that a register holds, where it is a constant.
    pub(super) fn number(&self, register: Register) -> Option<f64> {
        match register {
            Register::Constant(i) => Some(self.constants[i as usize]),
            _ => None,
        }
    }

    /// The register that holds the result of an instruction, new or known.
    pub(super) fn emit(
        &mut self,
        action: Action,
        a: Register,
        b: Register,
        c: Register,
    ) -> Register {
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

    /// Orders the instructions that the outputs need and numbers the registers.
    pub(super) fn finish(self, roots: &[Register], n_parameters: usize, n_inputs: usize) -> Tape {
        let in_prologue = |register| match register {
            Register::Prologue(i) => Some(i as usize),
            _ => None,
        };
        let in_body = |register| match register {
            Register::Body(i) => Some(i as usize),
            _ => None,
        };
        let body = Section::new(&self.body, in_body, roots);
        let prologue_roots = [roots, &body.operands()].concat();
        let prologue = Section::new(&self.prologue, in_prologue, &prologue_roots);

        let first_parameter = index(self.constants.len());
        let first_input = first_parameter + index(n_parameters);
        let first_prologue = (first_input as usize) + n_inputs;
        let first_body = first_prologue + prologue.n_results();
        let (prologue_numbers, body_numbers) =
            (prologue.numbers(first_prologue), body.numbers(first_body));
        let number = |register: Register| match register {
            Register::Constant(i) => i,
            Register::Parameter(i) => first_parameter + i,
            Register::Input(i) => first_input + i,
            Register::Prologue(i) => prologue_numbers[i as usize],
            Register::Body(i) => body_numbers[i as usize],
        };
        let mut angles = Vec::new();
        Tape {
            prologue: prologue.instructions(&number, &mut angles),
            body: body.instructions(&number, &mut angles),
            angles,
            outputs: roots.iter().map(|&root| number(root)).collect(),
            first_body,
            n_registers: first_body + body.n_results(),
            n_operations: [prologue.n_operations(), body.n_operations()],
            constants: self.constants,
            n_parameters,
            n_inputs,
        }
    }
}
