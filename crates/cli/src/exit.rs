//! Exit statuses and what leads to them.

use std::io;
use std::path::{Path, PathBuf};

use bksim::model::diagnostic::Diagnostic;
pub use bksim_load::without_number;
use bksim_load::{InputError, Text, plain_words};

/// How a command ends.
///
/// | status | meaning |
/// |---|---|
/// | 0 | done |
/// | 1 | the model or input is rejected, or runs that are compared differ too much |
/// | 2 | the command line is wrong |
/// | 3 | the run stopped early; its log is valid |
/// | 4 | a file cannot be read or written, or no window or program be started |
/// | 130, 143 | interrupted or terminated; the log is valid |
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Status {
    /// Done.
    Done,
    /// The model or input is rejected.
    Rejected,
    /// The command line is wrong.
    Usage,
    /// The run stopped early; its log is valid.
    StoppedEarly,
    /// A file cannot be read or written, or no window or program be started.
    InputOutput,
    /// Interrupted; the log is valid.
    Interrupted,
    /// Terminated; the log is valid.
    Terminated,
}

impl Status {
    /// The number that the process ends with.
    pub fn code(self) -> u8 {
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
pub enum Failure {
    /// Faults of the model text.
    Model {
        /// The text they are in.
        source: Box<Text>,
        /// The faults.
        diagnostics: Vec<Diagnostic>,
    },
    /// A file could not be read or written.
    File {
        /// The file.
        path: PathBuf,
        /// The rest of a sentence that begins with the path.
        what: String,
        /// A way out.
        help: Option<String>,
    },
    /// A file can be read but is not what the command needs.
    Input {
        /// The file.
        path: PathBuf,
        /// The rest of a sentence that begins with the path.
        what: String,
        /// A way out.
        help: Option<String>,
    },
    /// The command line asks for something that makes no sense.
    Usage {
        /// The fault.
        message: String,
        /// A way out.
        help: Option<String>,
    },
    /// There is no window to show something in, or no program to do it.
    Unavailable {
        /// The fault.
        message: String,
        /// A way out.
        help: String,
    },
    /// Standard output was closed by its reader: nothing is wrong.
    OutputClosed,
}

impl Failure {
    /// How the command ends.
    pub fn status(&self) -> Status {
        match self {
            Self::Model { .. } | Self::Input { .. } => Status::Rejected,
            Self::File { .. } | Self::Unavailable { .. } => Status::InputOutput,
            Self::Usage { .. } => Status::Usage,
            Self::OutputClosed => Status::Done,
        }
    }

    /// A file that cannot be read.
    pub fn reading(path: &Path, error: &io::Error) -> Self {
        Self::file(path, format!("cannot be read: {}", plain_words(error)), None)
    }

    /// A file that cannot be written.
    pub fn writing(path: &Path, error: &dyn std::fmt::Display) -> Self {
        let words = error.to_string();
        Self::file(path, format!("cannot be written: {}", without_number(&words)), None)
    }

    /// A command line that makes no sense.
    pub fn usage(message: impl Into<String>, help: &str) -> Self {
        Self::Usage { message: message.into(), help: Some(help.to_owned()) }
    }

    /// A file with which something is wrong.
    pub fn file(path: &Path, what: String, help: Option<String>) -> Self {
        Self::File { path: path.to_owned(), what, help }
    }

    /// Standard output failed: a closed pipe is the reader's wish, anything else is a fault.
    pub fn stdout(error: &io::Error) -> Self {
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
