//! Logs: written, read, damaged, exported, and read by other programs.

mod common;
mod export;
mod hostile;
mod log;
mod viewers;
