//! `bksim-studio`: the command line with all that draws, as a program.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(bksim_studio::run(&std::env::args_os().collect::<Vec<_>>()))
}
