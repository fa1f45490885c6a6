//! A mechanism as a solver in one C99 file, as a functional mock-up unit (FMI 2.0 and 3.0) around the same solver, and as
//! equations in scripts of other programs.
//!
//! ```text
//! Mechanism → Core (functions and tables in C) → + c/*.c → solver: header, source, test
//!                                                          unit: source, descriptions, archive
//! ```
//!
//! # Invariants
//!
//! Opens no files and runs no programs: a compiler is the caller's. The same mechanism gives the same bytes. The
//! code allocates nothing but whole instances, has no globals and keeps its state in one struct without pointers.

mod archive;
pub mod codes;
mod core;
mod description;
mod functions;
mod script;
mod shown;
mod solver;
mod source;
mod unit;
mod variable;

pub use crate::core::{Core, Request};
pub use archive::archive;
pub use codes::PAGES;
pub use description::Version;
pub use script::{Script, ScriptKind, script};
pub use solver::{Solver, solver};
pub use unit::{Platform, Unit};
pub use variable::Variable;
