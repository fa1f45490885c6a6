//! `bksim completions SHELL` and `bksim man`: for shells and for the reader of manual pages.

use std::fs;
use std::io::Write;

use bksim::model::message::counted;
use clap::{Command, CommandFactory};
use clap_mangen::Man;
use serde_json::json;

use crate::args::Cli;
use crate::args::shell::{Completions, Man as ManArguments};
use crate::exit::{Failure, Status};
use crate::origin::{is_of_model, stamped};
use crate::output;
use crate::output_file::OutputFile;

/// The words for pages that were not written.
const UNDONE: &str = "no pages were written from there on";

/// Prints the completions of a shell.
pub(crate) fn completions(args: &Completions, as_json: bool) -> Result<Status, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "bksim", &mut script);
    let script = String::from_utf8_lossy(&script);
    if as_json {
        let body = json!({ "shell": args.shell.to_string(), "script": script });
        output::json("completions", body)?;
    } else {
        output::text(script.trim_end())?;
    }
    Ok(Status::Done)
}

/// Prints a page of the manual, or writes all of them.
pub(crate) fn man(args: &ManArguments, as_json: bool) -> Result<Status, Failure> {
    let mut all = Cli::command();
    all.build();
    if let Some(folder) = &args.output {
        fs::create_dir_all(folder).map_err(|e| Failure::writing(folder, &e))?;
        let mut pages = Vec::new();
        gather(&all, "bksim", &mut pages);
        for (name, command) in &pages {
            let path = folder.join(format!("{name}.1"));
            // A page is of no model, and takes the place of an earlier one alone.
            let file = OutputFile::plan(&path, ("manual", &[]), is_of_model(&path, ""), UNDONE)?;
            let mut out = file.create()?;
            let bytes = stamped(&path, page(command).into_bytes(), "");
            out.write_all(&bytes).map_err(|e| Failure::writing(&path, &e))?;
            out.finish()?;
        }
        let names: Vec<&String> = pages.iter().map(|(name, _)| name).collect();
        if as_json {
            output::json("man", json!({ "output": folder.display().to_string(), "pages": names }))?;
        } else {
            output::report(&format!(
                "wrote {} to {}",
                counted(names.len(), "page", "pages"),
                folder.display()
            ))?;
        }
        return Ok(Status::Done);
    }
    let (mut command, mut name) = (&all, "bksim".to_owned());
    for word in &args.command {
        let Some(found) = command.find_subcommand(word) else {
            let message = format!("there is no command `{word}`");
            return Err(Failure::usage(message, "`bksim --help` lists all commands"));
        };
        command = found;
        name = format!("{name}-{word}");
    }
    let text = page(command);
    if as_json {
        output::json("man", json!({ "name": name, "page": text }))?;
    } else {
        output::text(text.trim_end())?;
    }
    Ok(Status::Done)
}

/// A command and all below it, each with the name of its page.
fn gather<'c>(command: &'c Command, name: &str, pages: &mut Vec<(String, &'c Command)>) {
    pages.push((name.to_owned(), command));
    let below = command.get_subcommands().filter(|below| below.get_name() != "help");
    for below in below {
        gather(below, &format!("{name}-{}", below.get_name()), pages);
    }
}

/// The page of a command as roff.
fn page(command: &Command) -> String {
    let mut bytes = Vec::new();
    // Writing to memory cannot fail.
    let _ = Man::new(command.clone()).render(&mut bytes);
    String::from_utf8_lossy(&bytes).into_owned()
}
