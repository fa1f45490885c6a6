//! Sweeps: their tables, and cases that equal single runs.

mod common;
mod equal_to_solve;
mod slopes;
mod table;
