//! Values of expressions: one tape, several evaluators.
//!
//! ```text
//! reference     the graph itself, one expression at one point
//! interpreter   a tape at one point: the reference for all that follow
//! batch         a tape at many points, some dozens of them at each instruction
//! lanes         a tape at one, four or eight points at once, in the lanes of registers: as machine code by an assembler
//!               of its own on x86-64 with AVX2, interpreted elsewhere; memory: memory that can be executed
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
mod lanes;
#[cfg(target_arch = "x86_64")]
mod memory;
mod reference;
mod runner;

pub use batch::Batch;
pub use due::Jit;
pub use interpreter::Workspace;
pub use lanes::{LaneRunner, LaneValues, LaneWorkspace, widest_lanes};
pub use reference::{DomainFault, EvalError};
pub use runner::Runner;
