//! Values of expressions: one tape, several evaluators.
//!
//! ```text
//! reference     the graph itself, one expression at one point
//! interpreter   a tape at one point: the reference for all that follow
//! batch         a tape at many points, some dozens of them at each instruction
//! lanes         a tape at one, four or eight points at once, in the lanes of registers, by an assembler of its own
//! jit           a tape as machine code by cranelift, for processors that have no such assembler (feature `jit`);
//!               sections: in several functions; memory: memory that can be executed, of either kind of code
//! runner        a tape at one point, interpreted until machine code pays; due: when that is
//! ```
//!
//! **All evaluators of a tape agree bit for bit** at every input, where all NaN count as one: they
//! carry out the same operations, none fuses a product into a sum, and elementary functions come
//! from [`Function::value`](crate::op::Function::value), its lanes and [`sin_cos`](crate::sincos::sin_cos)
//! alone. `tests/evaluation/evaluators.rs` holds each of them to it.

mod batch;
mod due;
mod interpreter;
#[cfg(feature = "jit")]
mod jit;
mod lanes;
#[cfg(feature = "jit")]
mod memory;
mod reference;
mod runner;
#[cfg(feature = "jit")]
mod sections;

pub use batch::Batch;
pub use due::Jit;
pub use interpreter::Workspace;
#[cfg(feature = "jit")]
pub use jit::MachineCode;
pub use lanes::{LaneRunner, LaneValues, LaneWorkspace, widest_lanes};
#[cfg(feature = "jit")]
pub use memory::JitError;
pub use reference::{DomainFault, EvalError};
pub use runner::Runner;
