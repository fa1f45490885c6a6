//! What goes wrong after reading, said in the author's terms: assembly and run faults as
//! diagnostics that name loops, bodies, stated values and expressions.

mod closing;
mod guesses;
mod pole;
mod reach;
mod run;
mod start;
mod switch;

pub use guesses::diagnose_guesses;
pub use run::diagnose_run;
pub use start::{diagnose_mobility, diagnose_start, unit_of};
