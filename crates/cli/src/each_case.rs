//! `--cases`: a command that is done for each of the load cases of its model.

use std::ffi::OsString;
use std::path::Path;

use bksim_load::{Request, is_log, is_stdin, load};
use clap::Parser;

use crate::args::{Cli, Command};
use crate::exit::{Failure, Status};
use crate::{output, render};

/// True if the process has more to do after a command.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum More {
    /// Nothing.
    Ends,
    /// Another case follows.
    Follows,
}

/// The option.
const OPTION: &str = "--cases";
/// Options that name a file to be written.
const OUTPUT: [&str; 3] = ["-o", "--output", "--out"];

/// Does a command once, or with `--cases` once for each of the load cases of its model; gives the largest exit status.
///
/// A sheet is about all cases by itself, and `--cases` of a sweep is a table.
pub fn for_each_case(arguments: &[OsString], once: &dyn Fn(&[OsString], More) -> u8) -> u8 {
    let as_json = arguments.iter().any(|argument| argument == "--json");
    let cases = match cases(arguments) {
        Ok(Some(cases)) => cases,
        Ok(None) => return once(arguments, More::Ends),
        Err(failure) => {
            render::failure(&failure, "", as_json);
            return failure.status().code();
        }
    };
    let mut status = Status::Done.code();
    for (name, title) in &cases {
        let title = title.as_ref().map_or(String::new(), |title| format!(", {title}"));
        if !as_json {
            // The command reports an output that is closed.
            let _ = output::report(&format!("case `{name}`{title}"));
        }
        status = status.max(once(&with_case(arguments, name), More::Follows));
    }
    status
}

/// A load case with its title.
type Named = (String, Option<String>);

/// The cases that are asked for; `None` of a command that is done once, be it to report a fault.
fn cases(arguments: &[OsString]) -> Result<Option<Vec<Named>>, Failure> {
    if !arguments.iter().any(|argument| argument == OPTION) {
        return Ok(None);
    }
    let Ok(cli) = Cli::try_parse_from(arguments) else { return Ok(None) };
    let inputs = cli.command.inputs();
    let Some(input) = inputs.first() else { return Ok(None) };
    if matches!(cli.command, Command::Sweep(_) | Command::Sheet(_)) {
        return Ok(None);
    }
    if cli.watch || is_stdin(input) {
        let message = "--cases is for a model in a file, and not for --watch";
        return Err(Failure::usage(message, "choose one case with --case"));
    }
    if is_log(input) {
        let message = "--cases is for models, and this is a log";
        return Err(Failure::usage(message, "name the model"));
    }
    // Bodies without masses are read, too; a command that needs them reports it.
    let request = Request { is_geometry: true, ..Request::new(input) };
    let Ok(loaded) = load(&request) else { return Ok(None) };
    let cases: Vec<Named> =
        loaded.model.cases.into_iter().map(|case| (case.name, case.title)).collect();
    if cases.is_empty() {
        let message = format!("`{}` has no load cases", input.display());
        return Err(Failure::usage(message, "define one: `[cases.full]` with `set = { … }`"));
    }
    Ok(Some(cases))
}

/// The arguments for one case: its name in the place of `--cases`, and in the name of a file that is written.
fn with_case(arguments: &[OsString], name: &str) -> Vec<OsString> {
    let mut given = Vec::new();
    let mut is_output = false;
    for argument in arguments {
        let text = argument.to_string_lossy();
        let option = OUTPUT.iter().find(|option| text.starts_with(&format!("{option}=")));
        if *argument == *OPTION {
            given.extend(["--case".into(), name.into()]);
        } else if let Some(option) = option {
            let file = of_case(Path::new(&text[option.len() + 1..]), name);
            given.push(format!("{option}={}", file.to_string_lossy()).into());
        } else if is_output {
            given.push(of_case(Path::new(argument), name));
        } else {
            given.push(argument.clone());
        }
        is_output = OUTPUT.iter().any(|option| *argument == **option);
    }
    given
}

/// The name of a file with that of a case: `pins-full.csv`.
pub(crate) fn of_case(path: &Path, name: &str) -> OsString {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().map_or(String::new(), |e| format!(".{}", e.to_string_lossy()));
    path.with_file_name(format!("{stem}-{name}{ending}")).into_os_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_of_a_case_takes_the_place_of_the_option() {
        let words = |text: &str| text.split(' ').map(OsString::from).collect::<Vec<_>>();
        let check = |given: &str, expected: &str| {
            assert_eq!(with_case(&words(given), "full"), words(expected));
        };
        check(
            "bksim report a.toml --cases -o b/r.md",
            "bksim report a.toml --case full -o b/r-full.md",
        );
        check(
            "bksim solve --cases --output=r.mcap a.toml",
            "bksim solve --case full --output=r-full.mcap a.toml",
        );
    }
}
