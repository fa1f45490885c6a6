//! Why there is no model.

use std::io;
use std::path::{Path, PathBuf};

use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::{LOOP_OF_LINKS, suggest};

use crate::excerpt::plain;
use crate::folder::others_in;
use crate::text::Text;

/// Why there is no model.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// Faults of the model text.
    #[error("{}", .diagnostics.iter().map(|fault| plain(source_text, fault)).collect::<Vec<_>>().join("\n\n"))]
    Model {
        /// The text they are in.
        source_text: Box<Text>,
        /// At least one of them is an error.
        diagnostics: Vec<Diagnostic>,
    },
    /// A file cannot be read.
    #[error("`{}` {what}", .path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The fault, worded to follow the file's name.
        what: String,
        /// A way out.
        help: Option<String>,
    },
    /// A file can be read but is no model.
    #[error("`{}` {what}", .path.display())]
    NoModel {
        /// The file.
        path: PathBuf,
        /// The fault, worded to follow the file's name.
        what: String,
    },
    /// The unit of a drawing is none.
    #[error("`{name}` is no unit of length")]
    Unit {
        /// Name as it was written.
        name: String,
    },
}

impl InputError {
    pub(crate) fn reading(path: &Path, error: &io::Error) -> Self {
        let what = format!("cannot be read: {}", plain_words(error));
        let help = match error.kind() {
            io::ErrorKind::NotFound => instead(path),
            _ if is_loop_of_links(error) => {
                Some(format!("put a file in the place of the link `{}`", path.display()))
            }
            _ => None,
        };
        Self::File { path: path.to_owned(), what, help }
    }
}

impl Text {
    /// The error that this text has these faults.
    pub fn rejected(&self, diagnostics: Vec<Diagnostic>) -> InputError {
        let diagnostics = self.distinct(diagnostics);
        InputError::Model { source_text: Box::new(self.clone()), diagnostics }
    }
}

/// Help for a file that is not there: the names that its folder has.
fn instead(path: &Path) -> Option<String> {
    let parent = path.parent()?;
    let folder = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
    if !folder.is_dir() {
        return Some(format!("there is no folder `{}`", folder.display()));
    }
    let there = others_in(folder, path);
    let paths = there.iter().map(|name| parent.join(name).display().to_string());
    let paths: Vec<String> = paths.collect();
    let stem = |name: &str| Path::new(name).with_extension("");
    let same = paths.iter().find(|known| stem(known) == stem(&path.display().to_string()));
    if let Some(same) = same {
        return Some(format!("did you mean `{same}`?"));
    }
    let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
    (!paths.is_empty()).then(|| suggest(&path.display().to_string(), &paths))
}

/// The system's words without the number that follows them.
pub fn plain_words(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file".to_owned(),
        io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
        io::ErrorKind::IsADirectory => "it is a directory".to_owned(),
        _ if is_loop_of_links(error) => LOOP_OF_LINKS.to_owned(),
        _ => without_number(&error.to_string()).to_owned(),
    }
}

/// True of links that lead to each other in a circle: `ELOOP`, which the standard library has no stable word for.
pub(crate) fn is_loop_of_links(error: &io::Error) -> bool {
    error.raw_os_error() == Some(if cfg!(target_os = "linux") { 40 } else { 62 }) && cfg!(unix)
}

/// "No space left on device (os error 28)" without the part in parentheses.
pub fn without_number(words: &str) -> &str {
    words.split_once(" (os error").map_or(words, |(text, _)| text)
}
