//! Words of those who do not know the command line yet, and the commands that they mean.

use std::ffi::OsString;
use std::path::Path;

use bksim::model::file::{WrittenUnit, closest};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, CommandFactory};

use crate::args::Cli;
use crate::exit::Failure;

/// Endings of the files that commands read and write.
const ENDINGS: [&str; 14] = [
    "toml", "dxf", "dwg", "mcap", "csv", "parquet", "svg", "png", "pdf", "gif", "mp4", "html",
    "json", "md",
];

/// Words of other programs for commands, and the command that does it here.
const SYNONYMS: [(&str, &str); 34] = [
    ("run", "solve"),
    ("simulate", "solve"),
    ("sim", "solve"),
    ("integrate", "solve"),
    ("start", "assemble"),
    ("close", "assemble"),
    ("animate", "render"),
    ("film", "render"),
    ("video", "render"),
    ("movie", "render"),
    ("draw", "render"),
    ("picture", "render"),
    ("show", "view"),
    ("open", "view"),
    ("play", "view"),
    ("latex", "equations --format latex"),
    ("typst", "equations --format typst"),
    ("mathml", "equations --format mathml"),
    ("derive", "equations"),
    ("eq", "equations"),
    ("html", "page"),
    ("csv", "export"),
    ("parquet", "export"),
    ("table", "export"),
    ("curve", "curves"),
    ("graph", "plot"),
    ("chart", "plot"),
    ("validate", "check"),
    ("lint", "check"),
    ("statics", "static"),
    ("equilibrium", "static"),
    ("eigen", "modes"),
    ("frequency", "bode"),
    ("init", "new"),
];

/// Words of other programs for options, and the option that does it here.
const OPTIONS: [(&str, &[&str]); 7] = [
    ("t-end", &["duration", "time", "until", "end", "tend", "tmax", "stop-time", "end-time"]),
    ("at", &["t", "instant", "moment", "frame"]),
    ("every", &["dt", "interval", "sample", "sampling", "output-interval"]),
    ("step", &["timestep", "time-step", "step-size", "stepsize"]),
    ("rtol", &["tol", "precision", "reltol", "accuracy"]),
    ("output", &["out", "save", "to-file", "outfile"]),
    ("set", &["param", "params", "parameter", "define", "with"]),
];

/// The way out of a command line that the parser refuses, where it is one of those that people often write.
pub(crate) fn advice(error: &clap::Error, arguments: &[OsString]) -> Option<Failure> {
    let word = |kind| match error.get(kind) {
        Some(ContextValue::String(word)) => Some(word.as_str()),
        _ => None,
    };
    match error.kind() {
        ErrorKind::InvalidSubcommand => {
            let word = word(ContextKind::InvalidSubcommand)?;
            file_alone(word).or_else(|| synonym(word))
        }
        ErrorKind::UnknownArgument => {
            let word = word(ContextKind::InvalidArg)?;
            unit_alone(word, arguments)
                .or_else(|| file_too_many(word))
                .or_else(|| option(word, arguments))
        }
        _ => None,
    }
}

/// `bksim first.toml`: a file where a command must stand.
fn file_alone(word: &str) -> Option<Failure> {
    let ending = ending(word)?;
    let name = quoted(word);
    let help = match ending.as_str() {
        "mcap" => {
            format!("`bksim view {name}` shows a log, `bksim info {name}` says what is in it")
        }
        "toml" | "dxf" | "dwg" => {
            format!("`bksim solve {name}` solves a model, `bksim view {name}` shows it moving")
        }
        _ => "`bksim --help` lists the commands".to_owned(),
    };
    Some(Failure::usage(format!("`{word}` is a file, and the first word is a command"), &help))
}

/// `bksim run first.toml`: the word of another program for a command, or one like it that is no misspelt command.
fn synonym(word: &str) -> Option<Failure> {
    let small = word.to_ascii_lowercase();
    let ours = Cli::command();
    let ours = ours.get_subcommands().map(Command::get_name);
    let known: Vec<&str> = ours.chain(SYNONYMS.map(|(theirs, _)| theirs)).collect();
    let nearest = closest(&small, &known)?;
    let (_, command) = SYNONYMS.iter().find(|(theirs, _)| *theirs == nearest)?;
    let help = format!("did you mean `bksim {command}`?");
    Some(Failure::usage(format!("there is no command `{word}`"), &help))
}

/// `bksim solve --duration 2`: the word of another program for an option that the command has.
fn option(word: &str, arguments: &[OsString]) -> Option<Failure> {
    let theirs = word.strip_prefix("--")?;
    let is_it = |(ours, words): &&(&str, &[&str])| *ours == theirs || words.contains(&theirs);
    let (ours, _) = OPTIONS.iter().find(is_it)?;
    let command = arguments.iter().skip(1).find_map(|argument| {
        Cli::command().get_subcommands().find(|command| argument == command.get_name()).cloned()
    })?;
    let find = |name: &str| command.get_arguments().find(|known| known.get_long() == Some(name));
    let help = if let Some(known) = find(ours) {
        let value = known.get_value_names().and_then(|names| names.first());
        let value = value.map(|name| format!(" <{name}>"));
        format!("did you mean `--{ours}{}`?", value.unwrap_or_default())
    } else {
        // Options of a run are keys of the model, too.
        let is_key = ["t-end", "every", "step", "rtol"].contains(ours);
        let key = (is_key && find("set").is_some()).then(|| ours.replace('-', "_"))?;
        format!("set it as a key of the model: `--set solve.{key}=VALUE`")
    };
    Some(Failure::usage(format!("`{}` has no option `{word}`", command.get_name()), &help))
}

/// `--set a=5 kg`: a unit apart from its number.
fn unit_alone(word: &str, arguments: &[OsString]) -> Option<Failure> {
    WrittenUnit::parse(word).filter(|_| !word.starts_with('-'))?;
    let at = arguments.iter().position(|argument| argument == word)?;
    let before = arguments.get(at.checked_sub(1)?)?.to_str()?;
    before.ends_with(|c: char| c.is_ascii_digit() || c == '.').then(|| {
        let help = format!("put them into quotes: \"{before} {word}\"");
        Failure::usage(format!("the unit `{word}` stands apart from its number"), &help)
    })
}

/// `bksim solve first.toml out.mcap`: a file to be written without `-o`.
fn file_too_many(word: &str) -> Option<Failure> {
    ending(word)?;
    let help = format!("a file to write comes after `-o`: `-o {}`", quoted(word));
    Some(Failure::usage(format!("`{word}` is one file too many"), &help))
}

/// The ending of a file's name, if it is a known one.
fn ending(word: &str) -> Option<String> {
    let ending = Path::new(word).extension()?.to_str()?.to_ascii_lowercase();
    ENDINGS.contains(&ending.as_str()).then_some(ending)
}

/// A name as a shell takes it.
fn quoted(word: &str) -> String {
    if word.contains(char::is_whitespace) { format!("\"{word}\"") } else { word.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_other_programs_lead_to_commands_that_exist() {
        let command = Cli::command();
        for (theirs, ours) in SYNONYMS {
            let name = ours.split(' ').next().unwrap_or_default();
            assert!(command.find_subcommand(name).is_some(), "{ours}");
            assert!(command.find_subcommand(theirs).is_none(), "`{theirs}` is a command");
        }
    }

    #[test]
    fn options_of_other_programs_lead_to_options_that_exist() {
        let command = Cli::command();
        for (ours, theirs) in OPTIONS {
            let has = |name: &str| {
                let mut all = command.get_subcommands().flat_map(Command::get_arguments);
                all.any(|argument| argument.get_long() == Some(name))
            };
            assert!(has(ours), "no command has `--{ours}`");
            assert!(!theirs.contains(&ours), "{ours}");
        }
        let typed = |line: &str| -> Vec<OsString> { line.split(' ').map(OsString::from).collect() };
        let found = option("--duration", &typed("bksim solve a.toml --duration 2"));
        assert!(format!("{found:?}").contains("--t-end <S>"), "{found:?}");
        let found = option("--t-end", &typed("bksim report a.toml --t-end 2"));
        assert!(format!("{found:?}").contains("--set solve.t_end=VALUE"), "{found:?}");
        let found = option("--t", &typed("bksim render a.toml --t 2"));
        assert!(format!("{found:?}").contains("--at <S>"), "{found:?}");
        assert!(option("--t", &typed("bksim solve a.toml --t 2")).is_none());
        // A list of parts takes no changes.
        assert!(option("--duration", &typed("bksim parts --duration 2")).is_none());
    }

    #[test]
    fn misspelt_words_of_other_programs_lead_to_commands_too() {
        let help = |word: &str| synonym(word).map(|failure| format!("{failure:?}"));
        assert!(help("simulat").is_some_and(|help| help.contains("bksim solve")));
        assert!(help("anmiate").is_some_and(|help| help.contains("bksim render")));
        // The parser knows what a misspelt command is like.
        assert!(help("slove").is_none() && help("xyzzy").is_none());
    }
}
