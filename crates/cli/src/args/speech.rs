//! The language of diagnostics and of the help: an option of every command but those that have another `--lang`, such as
//! `bksim code`; for these it stands before the command.

use std::ffi::OsString;

use bksim::translation::Language;
use clap::{Arg, ArgMatches, Command, ValueEnum};

const ID: &str = "speech";

/// A language of diagnostics and of the help.
#[derive(ValueEnum, Clone, Copy, Debug)]
enum Lang {
    /// English.
    En,
    /// Vietnamese, next to English.
    Vi,
}

/// `command` and all below it with the option `--lang`.
pub(crate) fn with_language(command: Command) -> Command {
    let has_another = command.get_arguments().any(|argument| argument.get_long() == Some("lang"));
    let option = Arg::new(ID)
        .long("lang")
        .value_name("LANGUAGE")
        .value_parser(clap::value_parser!(Lang))
        .help("Write the help in this language, and explain diagnostics in it, too; that of the environment unless given");
    let command = command.mut_subcommands(with_language);
    if has_another { command } else { command.arg(option) }
}

/// The language that is asked for, or that of the environment: the first of LC_ALL, LC_MESSAGES and LANG
/// that is set.
pub(crate) fn language(matches: &ArgMatches) -> Language {
    let asked = std::iter::successors(Some(matches), |at| Some(at.subcommand()?.1))
        .filter_map(|at| at.try_get_one::<Lang>(ID).ok().flatten())
        .last();
    spoken(asked.copied())
}

/// The language of a command line that the parser has not taken, as of one that asks for help.
pub(crate) fn language_of(arguments: &[OsString]) -> Language {
    let words: Vec<_> = arguments.iter().map(|argument| argument.to_string_lossy()).collect();
    let after = words.windows(2).filter(|pair| pair[0] == "--lang").map(|pair| &*pair[1]);
    let joined = words.iter().filter_map(|word| word.strip_prefix("--lang="));
    let asked = after.chain(joined).filter_map(|word| Lang::from_str(word, false).ok()).next_back();
    spoken(asked)
}

fn spoken(asked: Option<Lang>) -> Language {
    let locale = || {
        let set = ["LC_ALL", "LC_MESSAGES", "LANG"].into_iter().filter_map(std::env::var_os);
        set.map(|value| value.to_string_lossy().into_owned()).find(|value| !value.is_empty())
    };
    match asked {
        Some(Lang::En) => Language::English,
        Some(Lang::Vi) => Language::Vietnamese,
        None => Language::of_locale(&locale().unwrap_or_default()),
    }
}
