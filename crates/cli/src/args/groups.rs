//! The list of commands in the help, by what they are for.

use std::fmt::Write;

use bksim::translation::{Language, help_text};
use clap::Command;

/// Headings of the help and the commands below each.
const GROUPS: [(&str, &[&str]); 8] = [
    ("Models", &["new", "check", "edit", "expand", "parts", "import", "cad"]),
    ("Equations", &["equations", "code", "fmu", "expr"]),
    ("Motion", &["assemble", "solve", "sweep", "gradient", "verify"]),
    (
        "Questions",
        &[
            "kinematics",
            "curves",
            "polygons",
            "static",
            "inverse",
            "linearize",
            "modes",
            "bode",
            "doctor",
            "cam",
        ],
    ),
    ("Design", &["optimize", "fit", "tolerance", "synthesize"]),
    ("Results", &["info", "report", "sheet", "export"]),
    ("Pictures", &["view", "render", "plot", "page"]),
    ("Help and tools", &["explain", "lsp", "schema", "completions", "man", "help"]),
];

/// Layout of the help: the commands follow the usage line, the options come last.
const TEMPLATE: &str =
    "{about-with-newline}\n{usage-heading} {usage}{after-help}\n\nOptions:\n{options}";

/// Columns that the names of commands take.
const NAME_WIDTH: usize = 13;

/// `command` with its subcommands listed by groups in the help, the headings in a language.
pub(crate) fn with_groups(command: Command, language: Language) -> Command {
    let list = listed(&command, language);
    command.help_template(TEMPLATE).after_help(list)
}

/// One line for each command, below the heading of its group.
fn listed(command: &Command, language: Language) -> String {
    let words = |text: &'static str| help_text(text, language).unwrap_or(text);
    let mut list = String::new();
    for (heading, names) in GROUPS {
        // Writing to a text does not fail.
        let _ = write!(list, "\n{}:\n", words(heading));
        for &name in names {
            let about = match command.find_subcommand(name).and_then(Command::get_about) {
                Some(about) => about.to_string(),
                // The parser adds this command by itself.
                None => words("Print this list, or the help of a command").to_owned(),
            };
            let _ = writeln!(list, "  {name:NAME_WIDTH$}{about}");
        }
    }
    list.trim().to_owned()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use clap::CommandFactory;

    use super::*;
    use crate::args::Cli;

    #[test]
    fn every_command_is_in_one_group() {
        let listed: Vec<&str> =
            GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect();
        let unique: BTreeSet<&str> = listed.iter().copied().collect();
        assert_eq!(listed.len(), unique.len(), "a command is in two groups: {listed:?}");
        let command = Cli::command();
        let known: BTreeSet<&str> =
            command.get_subcommands().map(Command::get_name).chain(["help"]).collect();
        assert_eq!(unique, known);
    }

    #[test]
    fn a_line_of_the_list_fits_a_terminal() {
        for line in listed(&Cli::command(), Language::English).lines() {
            assert!(line.chars().count() <= 80, "{line}");
        }
    }
}
