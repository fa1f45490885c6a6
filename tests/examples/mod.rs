//! The examples, and runs of them: against textbooks and balances, drawn, played back, and read by other programs.

mod conformance;
mod drawings;
mod mechanics;
mod paper;
mod playback;
mod viewers;
mod worked;
mod worked_examples;
mod worked_machines;
mod worth;
