//! Commands of the studio, handed on to its program.

use std::env;
use std::ffi::OsString;
use std::io;
use std::path::PathBuf;
use std::process::Command;

use bksim_load::plain_words;

use crate::StudioCommand;
use crate::each_case::More;
use crate::exit::Failure;

/// Name of the program, without the ending that the system gives to programs.
const PROGRAM: &str = "bksim-studio";

/// Variables of a desktop, one of which is set where there is one.
const DESKTOP: [&str; 3] = ["XDG_RUNTIME_DIR", "WAYLAND_DISPLAY", "DISPLAY"];
/// Leaves the layer of Mesa that chooses among graphics cards by displays aside.
const NO_DISPLAYS: (&str, &str) = ("NODEVICE_SELECT", "1");

/// Starts the program of the studio with these arguments, the first of which is the name of this one,
/// and gives its exit status.
pub(crate) fn run(
    command: StudioCommand<'_>,
    arguments: &[OsString],
    more: More,
) -> Result<u8, Failure> {
    let program = path().map_err(|error| unavailable(command, &error))?;
    let mut studio = Command::new(program);
    studio.args(arguments.iter().skip(1));
    // Where there is no desktop, a layer of Mesa that asks for its displays complains on stderr.
    if DESKTOP.iter().all(|name| env::var_os(name).is_none()) {
        studio.env(NO_DISPLAYS.0, NO_DISPLAYS.1);
    }
    let done = if more == More::Follows { status_of(studio) } else { finish(studio) };
    done.map_err(|error| unavailable(command, &error))
}

/// The studio lies in the folder of this program, be that a link or not.
fn path() -> io::Result<PathBuf> {
    let own = env::current_exe()?;
    let name = format!("{PROGRAM}{}", env::consts::EXE_SUFFIX);
    let there = own.with_file_name(&name);
    if there.exists() {
        return Ok(there);
    }
    Ok(own.canonicalize()?.with_file_name(name))
}

/// Signals have to reach the program that works, so it takes this one's place.
#[cfg(unix)]
fn finish(mut studio: Command) -> io::Result<u8> {
    use std::os::unix::process::CommandExt;
    Err(studio.exec())
}

#[cfg(not(unix))]
fn finish(studio: Command) -> io::Result<u8> {
    status_of(studio)
}

fn status_of(mut studio: Command) -> io::Result<u8> {
    let status = studio.status()?;
    // Statuses of bksim are small; a process that was ended from outside has none of them.
    Ok(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(u8::MAX))
}

fn unavailable(command: StudioCommand<'_>, error: &io::Error) -> Failure {
    let work = match command {
        StudioCommand::Export(..) => "an export as Parquet".to_owned(),
        StudioCommand::Assemblies(..) => "a picture of assemblies".to_owned(),
        StudioCommand::Doctor(..) => "a picture of motions".to_owned(),
        StudioCommand::Bode(..) => "a picture of a frequency response".to_owned(),
        StudioCommand::Polygons(..) => "a picture of polygons".to_owned(),
        StudioCommand::Modes(_) => "a picture of a mode".to_owned(),
        command => format!("`bksim {}`", command.name()),
    };
    let why = match error.kind() {
        io::ErrorKind::NotFound => "is not in the folder of `bksim`".to_owned(),
        _ => format!("cannot be started: {}", plain_words(error)),
    };
    Failure::Unavailable {
        message: format!("{work} needs the program `{PROGRAM}`, which {why}"),
        help: format!(
            "build it with `cargo build -p {PROGRAM}`, or install it with \
             `cargo install --path crates/studio`"
        ),
    }
}
