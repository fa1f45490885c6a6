//! `bksim`: the command line as a program.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(bksim_cli::run(&std::env::args_os().collect::<Vec<_>>()))
}
