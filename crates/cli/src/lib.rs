//! The command line. Parse, dispatch, exit status; everything else has its own room.
//!
//! A library, so that the Python package brings the command, too.

mod args;
mod commands;
mod exit;
mod output;
mod progress;
mod render;
mod source;

use std::ffi::OsString;

use clap::Parser;

use crate::args::{Cli, Command};
use crate::exit::{Failure, Status};

/// Does what the arguments say, the name of the program first, and gives the exit status of the
/// process. Results go to standard output, all else to standard error. SIGINT and SIGTERM are taken
/// over for the rest of the process by what can end early.
pub fn run(arguments: Vec<OsString>) -> u8 {
    let wants_json = arguments.iter().any(|argument| argument == "--json");
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are results; anything else is a fault of the command line.
            let status = if error.use_stderr() { Status::Usage } else { Status::Done };
            if status == Status::Usage && wants_json {
                render::failure(&wrong_command_line(&error), "", true);
            } else {
                // Nobody reads the help: nothing is wrong.
                let _ = error.print();
            }
            return status.code();
        }
    };
    let (name, result) = dispatch(&cli);
    let status = result.unwrap_or_else(|failure| {
        render::failure(&failure, name, cli.json);
        failure.status()
    });
    status.code()
}

/// What the parser has to say, without its usage lines.
fn wrong_command_line(error: &clap::Error) -> Failure {
    let text = error.to_string();
    let what = text.split("\n\n").next().unwrap_or_default();
    let what = what.trim_start_matches("error: ").split_whitespace().collect::<Vec<_>>();
    Failure::usage(what.join(" "), "`bksim --help` shows what can be written")
}

fn dispatch(cli: &Cli) -> (&'static str, Result<Status, Failure>) {
    let (json, nesting) = (cli.json, cli.max_nesting);
    match &cli.command {
        Command::New(args) => ("new", commands::new::run(args, json)),
        Command::Check(args) => ("check", commands::check::run(args, json, nesting)),
        Command::Equations(args) => ("equations", commands::equations::run(args, json, nesting)),
        Command::Assemble(args) => ("assemble", commands::assemble::run(args, json, nesting)),
        Command::Solve(args) => ("solve", commands::solve::run(args, json, nesting)),
        Command::Sweep(args) => ("sweep", commands::sweep::run(args, json, nesting)),
        Command::Render(args) => ("render", commands::render::run(args, json, nesting)),
        Command::View(args) => ("view", commands::view::run(args, json, nesting)),
        Command::Export(args) => ("export", commands::export::run(args, json)),
        Command::Info(args) => ("info", commands::info::run(args, json)),
        Command::Plot(args) => ("plot", commands::plot::run(args, json)),
        Command::Page(args) => ("page", commands::page::run(args, json)),
        Command::Expr(args) => ("expr", commands::expr::run(args, json, nesting)),
        Command::Cad(args) => (commands::cad::name(args), commands::cad::run(args, json, nesting)),
        Command::Explain(args) => ("explain", commands::explain::run(args, json)),
    }
}
