//! Mechanisms in numbers and time: compiled functions, the consistent start, modes, the run.

mod assembly;
pub mod belt;
pub mod codes;
pub mod compiled;
mod coupling;
pub mod evaluator;
pub mod fault;
pub mod formulate;
mod function;
pub mod functions;
pub mod hybrid;
pub mod input;
mod latch;
mod linear;
pub mod load_forces;
mod mechanism;
pub mod mobility;
mod modes;
mod multiplier;
pub mod observable;
pub mod pose;
mod pressing;
pub mod redundancy;
pub mod run;
mod sampled;
pub mod sensitivity;
mod simulation;
pub mod start;
mod start_error;
pub mod state;
mod stepping;

pub use mechanism::Mechanism;
pub use sensitivity::SensitivityPlan;
pub use simulation::{Motion, SensitivityMotion, Simulation};
pub use stepping::{AdvanceError, SavedState, Stepping};
