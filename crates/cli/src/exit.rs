//! Exit statuses and what leads to them.

use std::io;
use std::path::{Path, PathBuf};

use bksim::mbs::diagnostic::Diagnostic;
pub(crate) use bksim_load::without_number;
use bksim_load::{InputError, Text, plain_words};

/// How a command ends.
///
/// | status | meaning |
/// |---|---|
/// | 0 | done |
/// | 1 | the model or input is rejected |
/// | 2 | the command line is wrong |
/// | 3 | the run stopped early; its log is valid |
/// | 4 | a file cannot be read or written, or no window be opened |
/// | 130, 143 | interrupted or terminated; the log is valid |
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Status {
    Done,
    Rejected,
    Usage,
    StoppedEarly,
    InputOutput,
    Interrupted,
    Terminated,
}

impl Status {
    pub(crate) fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Rejected => 1,
            Self::Usage => 2,
            Self::StoppedEarly => 3,
            Self::InputOutput => 4,
            Self::Interrupted => 130,
            Self::Terminated => 143,
        }
    }
}

/// Why a command could not do its work.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Faults of the model text.
    Model { source: Box<Text>, diagnostics: Vec<Diagnostic> },
    /// A file could not be read or written; `help` says what to do.
    File { path: PathBuf, what: String, help: Option<String> },
    /// A file can be read but is not what the command needs.
    Input { path: PathBuf, what: String, help: Option<String> },
    /// The command line asks for something that makes no sense.
    Usage { message: String, help: Option<String> },
    /// There is no window to show something in.
    Window { message: String, help: String },
    /// Standard output was closed by whoever reads it: nothing is wrong.
    OutputClosed,
}

impl Failure {
    pub(crate) fn status(&self) -> Status {
        match self {
            Self::Model { .. } | Self::Input { .. } => Status::Rejected,
            Self::File { .. } | Self::Window { .. } => Status::InputOutput,
            Self::Usage { .. } => Status::Usage,
            Self::OutputClosed => Status::Done,
        }
    }

    pub(crate) fn reading(path: &Path, error: &io::Error) -> Self {
        Self::file(path, format!("cannot be read: {}", plain_words(error)), None)
    }

    pub(crate) fn writing(path: &Path, error: &dyn std::fmt::Display) -> Self {
        let words = error.to_string();
        Self::file(path, format!("cannot be written: {}", without_number(&words)), None)
    }

    pub(crate) fn usage(message: impl Into<String>, help: &str) -> Self {
        Self::Usage { message: message.into(), help: Some(help.to_owned()) }
    }

    pub(crate) fn file(path: &Path, what: String, help: Option<String>) -> Self {
        Self::File { path: path.to_owned(), what, help }
    }

    /// Standard output failed: a closed pipe is the reader's wish, anything else is a fault.
    pub(crate) fn stdout(error: &io::Error) -> Self {
        if error.kind() == io::ErrorKind::BrokenPipe {
            Self::OutputClosed
        } else {
            Self::file(Path::new("standard output"), format!("cannot be written: {error}"), None)
        }
    }
}

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        match error {
            InputError::Model { source_text: source, diagnostics } => {
                Self::Model { source, diagnostics }
            }
            InputError::File { path, what, help } => Self::File { path, what, help },
            InputError::NoModel { path, what } => Self::Input { path, what, help: None },
            InputError::Unit { name } => {
                let help = "one of mm, cm, m, inch, ft, …: `bksim explain D006` lists them";
                Self::usage(format!("`--units {name}` is no unit of length"), help)
            }
        }
    }
}
