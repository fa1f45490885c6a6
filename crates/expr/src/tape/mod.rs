//! Straight-line programs: outputs as a list of instructions, each shared part computed once.
//!
//! Registers are written once, in this order:
//!
//! ```text
//! constants | parameters | inputs | prologue (parameters only) | body
//! ```
//!
//! The prologue runs when a [`Workspace`] is made, the body at every evaluation. An instruction
//! writes one register, but for [`Action::Turn`]: it takes all angles that are known at its time
//! and writes their sines, then their cosines, so that they are computed together in SIMD lanes.

mod chains;
mod compile;
mod composition;
mod emitter;
mod latency;
mod register;
mod schedule;
mod share;

use crate::op::Function;
use crate::pool::SymbolId;

pub use self::composition::{Composition, Value};

/// Reason why outputs cannot be compiled.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TapeError {
    /// A symbol is neither input nor parameter.
    #[error("symbol `{name}` is neither an input nor a parameter")]
    Unbound {
        /// The symbol.
        symbol: SymbolId,
        /// Name of the symbol.
        name: String,
    },
}

/// The computation of one instruction on its registers.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Action {
    Add,
    Subtract,
    Multiply,
    Divide,
    Negate,
    Power,
    /// Sines and cosines of the `b` angles in [`Tape::angles`] from `a` on.
    Turn,
    /// Any function; in a finished tape neither sine nor cosine, which are turns.
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

impl Instruction {
    /// Number of registers written.
    pub(crate) fn n_results(&self) -> usize {
        if self.action == Action::Turn { 2 * self.b as usize } else { 1 }
    }
}

/// A compiled list of outputs; evaluation allocates nothing.
#[derive(Clone, Debug)]
pub struct Tape {
    pub(crate) constants: Vec<f64>,
    pub(crate) n_parameters: usize,
    pub(crate) n_inputs: usize,
    pub(crate) prologue: Vec<Instruction>,
    pub(crate) body: Vec<Instruction>,
    /// Registers of the angles of all turns.
    pub(crate) angles: Vec<u32>,
    pub(crate) outputs: Vec<u32>,
    /// Register of the first result of the body.
    pub(crate) first_body: usize,
    pub(crate) n_registers: usize,
    /// Operations of prologue and body; a sine and a cosine count as one each.
    pub(crate) n_operations: [usize; 2],
}

impl Tape {
    /// Number of operations, prologue included.
    pub fn len(&self) -> usize {
        self.n_operations.iter().sum()
    }

    /// True if there is nothing to compute.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of operations in each evaluation.
    pub fn operation_count(&self) -> usize {
        self.n_operations[1]
    }

    /// Number of outputs.
    pub fn n_outputs(&self) -> usize {
        self.outputs.len()
    }

    /// Number of inputs.
    pub fn n_inputs(&self) -> usize {
        self.n_inputs
    }

    /// Number of parameters.
    pub fn n_parameters(&self) -> usize {
        self.n_parameters
    }

    /// Register of the first input.
    pub(crate) fn first_input(&self) -> usize {
        self.constants.len() + self.n_parameters
    }

    /// Register of the first result of the prologue.
    pub(crate) fn first_prologue(&self) -> usize {
        self.first_input() + self.n_inputs
    }

    /// The registers of the inputs.
    pub(crate) fn input_registers(&self) -> std::ops::Range<usize> {
        self.first_input()..self.first_prologue()
    }

    /// The registers of the angles of a turn.
    pub(crate) fn angles_of(&self, turn: &Instruction) -> &[u32] {
        &self.angles[turn.a as usize..][..turn.b as usize]
    }

    /// All operations in the order of their registers, turns as separate sines and cosines.
    pub(crate) fn operations(&self) -> impl Iterator<Item = (usize, Instruction)> {
        let single = |instruction: &Instruction| -> Vec<Instruction> {
            if instruction.action != Action::Turn {
                return vec![*instruction];
            }
            let angles = self.angles_of(instruction);
            let call = |function: Function| {
                let action = Action::Call(function);
                angles.iter().map(move |&a| Instruction { action, a, b: a, c: a })
            };
            call(Function::Sin).chain(call(Function::Cos)).collect()
        };
        (self.first_prologue()..).zip(self.prologue.iter().chain(&self.body).flat_map(single))
    }
}
