//! Faults after reading, said in the author's terms: those of the assembly and of runs as
//! diagnostics that name loops, bodies, stated values and expressions.

mod amount;
mod at_start;
mod closing;
mod corner;
mod dead_centre;
mod guesses;
mod number;
mod pace;
mod pole;
mod reach;
mod run;
mod start;
mod switch;
mod table;
mod values;
mod within_turn;
mod words;
mod worth;

pub use at_start::diagnose_at_start;
pub use guesses::diagnose_guesses;
pub use pace::diagnose_slowness;
pub use run::diagnose_run;
pub use start::{diagnose_mobility, diagnose_start};
pub use within_turn::diagnose_turns;
pub use words::unit_of;
pub use worth::{another_assembly, diagnose_worth};
