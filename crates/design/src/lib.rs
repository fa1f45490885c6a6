//! From an answer to a design: optima, fits to measurements, tolerances, synthesis.
//!
//! ```text
//! optimize    min f(p)   lower ≤ p ≤ upper,  c(p) ≥ 0         over motions, positions, equilibria
//! fit         min Σ ρ((y − h(p)) / σ)                         with what the data leave open
//! tolerance   h over p ± limit                                proved by intervals, by slopes, by samples
//! synthesize  linkages whose motion is asked for              as models that solve
//! ```
//!
//! Texts come in, plain data come out; nothing here opens files or prints.

mod base;
mod data;
mod error;
mod fit;
mod formula;
mod interval;
mod least_squares;
mod optimize;
mod poses;
mod quadratic;
mod spec;
mod sqp;
mod synthesis;
mod tolerance;

pub use base::{Source, Watch};
pub use bksim::design_codes as codes;
pub use data::DataFile;
pub use error::DesignError;
pub use fit::{Curve, Fit, FitWish, Unidentifiable, Unknown, fit};
pub use optimize::{
    Choice, ConditionAt, EndOfStart, Finished, Front, FrontPoint, OptimizeWish, Optimized, Optimum,
    Unfinished, optimize,
};
pub use synthesis::{Candidate, Synthesis, general_solutions, synthesize};
pub use tolerance::{
    Band, Cheapest, CheapestPart, Contributor, Kept, PathBand, PoseTolerance, Tolerance,
    ToleranceWish, tolerance,
};
