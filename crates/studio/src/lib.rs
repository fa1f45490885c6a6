//! The studio: the commands that draw, make pages, sweep and write Parquet.
//!
//! Graphics, fonts, films and tables take most of the time that building bksim takes. They are all
//! here, so that the main command, `bksim`, is built without them; it starts the program of this
//! crate, `bksim-studio`, for them. That program has the whole command line.

mod commands;
mod curve_fault;
mod modal;
mod parquet;

use std::ffi::OsString;

use bksim_cli::commands::analysis::{doctor, kinematics};
use bksim_cli::commands::export::{TableFormat, to_file};
use bksim_cli::exit::{Failure, Status};
use bksim_cli::{Common, StudioCommand, for_each_case, run_with};

pub use crate::parquet::to_parquet;
pub use bksim_cli::output_file;

/// Questions besides motion in time, with their answers as the command line tells them.
pub mod questions {
    pub use bksim_cli::commands::analysis::answer::Answer;
    pub use bksim_cli::commands::analysis::{
        bode, curves, doctor, gradient, inverse, kinematics, limits, linearize, modes, polygons,
        statics, verify,
    };
}

const PARQUET: TableFormat = TableFormat {
    name: "parquet",
    write: |log, asked, out| to_parquet(log, &asked.selection, out),
};

/// Does what the arguments of `bksim` say, the name of the program first, all of it in this process,
/// and gives its exit status; the rest as [`bksim_cli::run`].
pub fn run(arguments: &[OsString]) -> u8 {
    for_each_case(arguments, &|arguments, _| {
        run_with(arguments, &|command, common| studio(command, common).map(Status::code))
    })
}

fn studio(command: StudioCommand<'_>, common: Common) -> Result<Status, Failure> {
    let Common { json, nesting } = common;
    match command {
        StudioCommand::Assemblies(args, path) => {
            let draw = commands::panels::drawing(path);
            kinematics::run(args, Some(&draw), json, nesting)
        }
        StudioCommand::Doctor(args, path) => {
            let draw = commands::panels::drawing(path);
            doctor::run(args, Some(&draw), json, nesting)
        }
        StudioCommand::Bode(args, path) => commands::bode::run(args, path, json, nesting),
        StudioCommand::Export(args, path) => to_file(args, path, &PARQUET, (json, nesting)),
        StudioCommand::Inverse(args, path) => commands::inverse::run(args, path, json, nesting),
        StudioCommand::Edit(args) => commands::edit::run(args, json),
        StudioCommand::Page(args) => commands::page::run(args, json, nesting),
        StudioCommand::Plot(args) => commands::plot::run(args, json, nesting),
        StudioCommand::Polygons(args, path) => commands::polygons::run(args, path, json, nesting),
        StudioCommand::Modes(args) | StudioCommand::Render(args) => {
            commands::render::run(args, json, nesting)
        }
        StudioCommand::Optimize(args) => commands::design::optimize(args, json, nesting),
        StudioCommand::Fit(args) => commands::design::fit(args, json, nesting),
        StudioCommand::Tolerance(args) => commands::design::tolerance(args, json, nesting),
        StudioCommand::Synthesize(args) => commands::design::synthesize(args, json),
        StudioCommand::Sweep(args) => commands::sweep::run(args, json, nesting),
        StudioCommand::Sheet(args) => commands::sheet::run(args, json, nesting),
        StudioCommand::View(args) => commands::view::run(args, json, nesting),
    }
}
