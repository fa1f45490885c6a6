//! The command line: its arguments, and the commands that need no graphics, pages or sweeps.
//!
//! The others belong to the program `bksim-studio` of the crate `bksim-studio`, so that a model is
//! solved without building them. Both programs have this one command line: [`run`] hands a command
//! of the studio on to that program, [`run_with`] to a function.

mod again;
pub mod args;
pub mod commands;
mod each_case;
pub mod examples;
pub mod exit;
mod handover;
mod into_file;
mod leftover;
mod lsp;
pub mod origin;
pub mod output;
pub mod output_file;
pub mod progress;
mod quiet;
pub mod render;
pub mod source;
mod typed;
#[cfg(unix)]
mod unfinished;
mod visible;
pub mod waiting;

pub use self::each_case::for_each_case;

use std::ffi::OsString;
use std::path::Path;

use bksim::translation::Language;
use clap::{CommandFactory, FromArgMatches};

use crate::args::analysis::{Bode, Doctor, Inverse, Kinematics, Polygons};
use crate::args::design::{Fit, Optimize, Synthesize, Tolerance};
use crate::args::groups::with_groups;
use crate::args::live::Edit;
use crate::args::page::Page;
use crate::args::plot::Plot;
use crate::args::render::Render;
use crate::args::sheet::Sheet;
use crate::args::speech::{language, with_language};
use crate::args::sweep::Sweep;
use crate::args::translated::help;
use crate::args::view::View;
use crate::args::{Cli, Command, Export};
use crate::exit::{Failure, Status};

/// A command of the studio.
#[derive(Clone, Copy, Debug)]
pub enum StudioCommand<'a> {
    /// The ways in which a start closes, as a picture in this file.
    Assemblies(&'a Kinematics, &'a Path),
    /// A frequency response, as a picture in this file.
    Bode(&'a Bode, &'a Path),
    /// Free motions and repeated conditions, as a picture in this file.
    Doctor(&'a Doctor, &'a Path),
    /// Channels of a log, as Parquet to this file.
    Export(&'a Export, &'a Path),
    /// Efforts over speeds, as a picture in this file.
    Inverse(&'a Inverse, &'a Path),
    /// A mode as a film or a picture.
    Modes(&'a Render),
    /// A model in a page that changes it.
    Edit(&'a Edit),
    /// A run as a page of HTML.
    Page(&'a Page),
    /// Curves of runs.
    Plot(&'a Plot),
    /// Velocity and acceleration polygons, as a picture in this file.
    Polygons(&'a Polygons, &'a Path),
    /// A picture or a film.
    Render(&'a Render),
    /// One model at many parameter values.
    Sweep(&'a Sweep),
    /// The best values of parameters.
    Optimize(&'a Optimize),
    /// Parameters from measured curves.
    Fit(&'a Fit),
    /// Effects of limits of lengths.
    Tolerance(&'a Tolerance),
    /// Linkages for a task.
    Synthesize(&'a Synthesize),
    /// The largest pin forces.
    Sheet(&'a Sheet),
    /// A window.
    View(&'a View),
}

impl StudioCommand<'_> {
    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Assemblies(..) => "kinematics",
            Self::Bode(..) => "bode",
            Self::Doctor(..) => "doctor",
            Self::Export(..) => "export",
            Self::Inverse(..) => "inverse",
            Self::Modes(_) => "modes",
            Self::Edit(_) => "edit",
            Self::Page(_) => "page",
            Self::Plot(_) => "plot",
            Self::Polygons(..) => "polygons",
            Self::Render(_) => "render",
            Self::Sheet(_) => "sheet",
            Self::Sweep(_) => "sweep",
            Self::Optimize(_) => "optimize",
            Self::Fit(_) => "fit",
            Self::Tolerance(_) => "tolerance",
            Self::Synthesize(_) => "synthesize",
            Self::View(_) => "view",
        }
    }
}

/// Options that every command has.
#[derive(Clone, Copy, Debug)]
pub struct Common {
    /// True if one JSON object is printed in place of text.
    pub json: bool,
    /// Levels to which tables, arrays and parentheses of a model may nest.
    pub nesting: usize,
}

/// Does a command of the studio and gives its exit status.
pub type Studio<'a> = &'a dyn Fn(StudioCommand<'_>, Common) -> Result<u8, Failure>;

/// Does what the arguments say, the name of the program first, and gives the exit status of the
/// process. Results go to standard output, all else to standard error. SIGINT and SIGTERM are taken
/// over for the rest of the process by what can end early.
///
/// A command of the studio is done by the program `bksim-studio` in the folder of this one: on Unix
/// that takes the place of this process, elsewhere its exit status is this one's.
pub fn run(arguments: &[OsString]) -> u8 {
    for_each_case(arguments, &|arguments, more| {
        run_with(arguments, &|command, _| handover::run(command, arguments, more))
    })
}

/// Run of the command line ([`run`]) with the commands of the studio done by `studio`.
pub fn run_with(arguments: &[OsString], studio: Studio<'_>) -> u8 {
    let wants_json = arguments.iter().any(|argument| argument == "--json");
    let parsed = with_groups(with_language(Cli::command()), Language::English)
        .try_get_matches_from(arguments)
        .and_then(|matches| {
            bksim::translation::speak(language(&matches));
            Cli::from_arg_matches(&matches)
        });
    let cli = match parsed {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are results; anything else is a fault of the command line.
            let status = if error.use_stderr() { Status::Usage } else { Status::Done };
            let advice = typed::advice(&error, arguments);
            if status == Status::Usage && (wants_json || advice.is_some()) {
                let failure = advice.unwrap_or_else(|| wrong_command_line(&error));
                render::failure(&failure, "", wants_json);
            } else if let Some(help) = help(with_language(Cli::command()), arguments) {
                let _ = output::text(&help);
            } else {
                // Nobody reads the help: nothing is wrong.
                let _ = error.print();
            }
            return status.code();
        }
    };
    quiet::be_quiet(cli.quiet);
    let told = |name: &str, result: Result<u8, Failure>| {
        result.unwrap_or_else(|failure| {
            render::failure(&failure, name, cli.json);
            failure.status().code()
        })
    };
    let once = || {
        let (name, result) = dispatch(&cli, studio);
        told(name, result)
    };
    let status = once();
    if cli.watch { told("watch", again::again(&cli.command, status, &once)) } else { status }
}

/// The parser's message, without its usage lines.
fn wrong_command_line(error: &clap::Error) -> Failure {
    let text = error.to_string();
    let what = text.split("\n\n").next().unwrap_or_default();
    let what = what.trim_start_matches("error: ").split_whitespace().collect::<Vec<_>>();
    Failure::usage(what.join(" "), "`bksim --help` shows what can be written")
}

/// Does the command, its text into a file where one is named; gives its name and the exit status.
fn dispatch(cli: &Cli, studio: Studio<'_>) -> (&'static str, Result<u8, Failure>) {
    let Some((name, path, force)) = cli.command.text_file() else { return done(cli, studio) };
    let run = || done(cli, studio).1;
    (name, into_file::into_file((path, force), &cli.command.inputs(), run))
}

/// Does the command; gives its name and the exit status.
fn done(cli: &Cli, studio: Studio<'_>) -> (&'static str, Result<u8, Failure>) {
    let common @ Common { json, nesting } = Common { json: cli.json, nesting: cli.max_nesting };
    let own = |name, done: Result<Status, Failure>| (name, done.map(Status::code));
    let studio = |command: StudioCommand<'_>| (command.name(), studio(command, common));
    match &cli.command {
        Command::New(args) => own("new", commands::new::run(args, json)),
        Command::Expand(args) => own("expand", commands::expand::run(&args.model, json, nesting)),
        Command::Parts(args) => own("parts", commands::parts::run(args.name.as_deref(), json)),
        Command::Check(args) => own("check", commands::check::run(&args.model, json, nesting)),
        Command::Equations(args) => own("equations", commands::equations::run(args, json, nesting)),
        Command::Assemble(args) => {
            own("assemble", commands::assemble::run(&args.model, json, nesting))
        }
        Command::Kinematics(args) => match args.picture() {
            Some(path) => studio(StudioCommand::Assemblies(args, path)),
            None => {
                own("kinematics", commands::analysis::kinematics::run(args, None, json, nesting))
            }
        },
        Command::Curves(args) => {
            own("curves", commands::analysis::curves::run(args, json, nesting))
        }
        Command::Polygons(args) => match args.table.picture() {
            Some(path) => studio(StudioCommand::Polygons(args, path)),
            None => own("polygons", commands::analysis::polygons::run(args, None, json, nesting)),
        },
        Command::Static(args) => {
            own("static", commands::analysis::statics::run(args, json, nesting))
        }
        Command::Linearize(args) => {
            own("linearize", commands::analysis::linearize::run(args, json, nesting))
        }
        Command::Modes(args) => match args.picture() {
            Some(render) => studio(StudioCommand::Modes(&render)),
            None => own("modes", commands::analysis::modes::run(args, json, nesting)),
        },
        Command::Bode(args) => match args.table.picture() {
            Some(path) => studio(StudioCommand::Bode(args, path)),
            None => own("bode", commands::analysis::bode::run(args, None, json, nesting)),
        },
        Command::Verify(args) => {
            own("verify", commands::analysis::verify::run(args, json, nesting))
        }
        Command::Gradient(args) => {
            own("gradient", commands::analysis::gradient::run(args, json, nesting))
        }
        Command::Doctor(args) => match args.table.picture() {
            Some(path) => studio(StudioCommand::Doctor(args, path)),
            None => own("doctor", commands::analysis::doctor::run(args, None, json, nesting)),
        },
        Command::Inverse(args) => match args.table.picture() {
            Some(path) => studio(StudioCommand::Inverse(args, path)),
            None => own("inverse", commands::analysis::inverse::run(args, None, json, nesting)),
        },
        Command::Cam(args) => own("cam", commands::analysis::cam::run(args, json, nesting)),
        Command::Code(args) => own("code", commands::code::run(args, json, nesting)),
        Command::Fmu(args) => own("fmu", commands::fmu::run(args, json, nesting)),
        Command::Solve(args) => own("solve", commands::solve::run(args, json, nesting)),
        Command::Sweep(args) => studio(StudioCommand::Sweep(args)),
        Command::Optimize(args) => studio(StudioCommand::Optimize(args)),
        Command::Fit(args) => studio(StudioCommand::Fit(args)),
        Command::Tolerance(args) => studio(StudioCommand::Tolerance(args)),
        Command::Synthesize(args) => studio(StudioCommand::Synthesize(args)),
        Command::Render(args) => studio(StudioCommand::Render(args)),
        Command::View(args) => studio(StudioCommand::View(args)),
        Command::Sheet(args) => studio(StudioCommand::Sheet(args)),
        Command::Export(args) => match args.parquet() {
            Some(path) => studio(StudioCommand::Export(args, path)),
            None => own("export", commands::export::run(args, json, nesting)),
        },
        Command::Report(args) => own("report", commands::report::run(args, json, nesting)),
        Command::Info(args) => own("info", commands::info::run(args, json, nesting)),
        Command::Plot(args) => studio(StudioCommand::Plot(args)),
        Command::Page(args) => studio(StudioCommand::Page(args)),
        Command::Edit(args) => studio(StudioCommand::Edit(args)),
        Command::Expr(args) => own("expr", commands::expr::run(args, json, nesting)),
        Command::Cad(args) => {
            own(commands::cad::name(args), commands::cad::run(args, json, nesting))
        }
        Command::Import(args) => own("import", commands::import::run(args, json, nesting)),
        Command::Lsp => own("lsp", lsp::run(nesting)),
        Command::Schema(_) => own("schema", commands::schema::run(json)),
        Command::Completions(args) => own("completions", commands::shell::completions(args, json)),
        Command::Man(args) => own("man", commands::shell::man(args, json)),
        Command::Explain(args) => own("explain", commands::explain::run(args, json)),
    }
}
