//! The help in another language: the texts of `docs/vi/help.toml` in the place of the English ones.

use std::ffi::OsString;

use bksim::translation::{Language, help_text};
use clap::builder::{PossibleValue, PossibleValuesParser, StyledStr};
use clap::error::ErrorKind;
use clap::{Arg, Command};

use super::groups::with_groups;
use super::speech::language_of;

/// Words that the parser writes by itself; longer ones come before their parts.
const OWN: [&str; 13] = [
    "Usage:",
    "Arguments:",
    "Options:",
    "Commands:",
    "Examples:",
    "Possible values:",
    "[default: ",
    "[possible values: ",
    "[OPTIONS]",
    "<COMMAND>",
    "Print help (see a summary with '-h')",
    "Print help (see more with '--help')",
    "Print this message or the help of the given subcommand(s)",
];

/// The help that `arguments` ask for, where they ask in another language than English. It is found by reading the
/// arguments once more: the values of this command are texts.
pub(crate) fn help(command: Command, arguments: &[OsString]) -> Option<String> {
    let language = language_of(arguments);
    if language == Language::English {
        return None;
    }
    let translated = with_groups(translated(command, language), language);
    let asked = translated.try_get_matches_from(arguments).err()?;
    let is_help = matches!(
        asked.kind(),
        ErrorKind::DisplayHelp | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
    );
    let text = is_help.then(|| asked.render().to_string())?;
    let put = |text: String, own: &&str| match help_text(own, language) {
        Some(words) => text.replace(own, words),
        None => text,
    };
    Some(OWN.iter().fold(text, put))
}

/// A command and all below it with texts in a language.
fn translated(command: Command, language: Language) -> Command {
    let words = |text: Option<&StyledStr>| text.map(|text| in_words(&text.to_string(), language));
    let [about, long_about] = [command.get_about(), command.get_long_about()].map(words);
    let mut command = command;
    if let Some(about) = about {
        command = command.about(about);
    }
    if let Some(about) = long_about {
        command = command.long_about(about);
    }
    let of_argument = |argument: Arg| translated_argument(argument, language);
    command.mut_args(of_argument).mut_subcommands(|below| translated(below, language))
}

fn translated_argument(argument: Arg, language: Language) -> Arg {
    let words = |text: Option<&StyledStr>| text.map(|text| in_words(&text.to_string(), language));
    let [help, long_help] = [argument.get_help(), argument.get_long_help()].map(words);
    let value = |value: &PossibleValue| {
        let own = value.clone();
        match words(value.get_help()) {
            Some(help) => own.help(help),
            None => own,
        }
    };
    // A flag has none to choose from.
    let values = argument.get_possible_values();
    let values = values.iter().filter(|_| argument.get_action().takes_values());
    let values: Vec<PossibleValue> = values.map(value).collect();
    let mut argument = argument;
    if let Some(help) = help {
        argument = argument.help(help);
    }
    if let Some(help) = long_help {
        argument = argument.long_help(help);
    }
    if values.is_empty() {
        argument
    } else {
        argument.value_parser(PossibleValuesParser::new(values))
    }
}

/// A text in a language, paragraph by paragraph; one without a translation stays as it is.
fn in_words(text: &str, language: Language) -> String {
    let paragraph = |text: &str| {
        let one_line = text.split_whitespace().collect::<Vec<_>>().join(" ");
        let words = help_text(one_line.trim_end_matches('.'), language);
        words.map_or_else(|| text.to_owned(), str::to_owned)
    };
    text.split("\n\n").map(paragraph).collect::<Vec<_>>().join("\n\n")
}
