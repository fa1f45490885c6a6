//! [`ModelFile`]: the one file that is edited; what another program has written into it is never lost.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use bksim_cli::exit::Failure;
use tempfile::NamedTempFile;

/// A model file under edit.
#[derive(Debug)]
pub(crate) struct ModelFile {
    /// With its links resolved, so that a link stays one.
    path: PathBuf,
    name: String,
}

/// Why the file was not written.
#[derive(Debug)]
pub(crate) enum NotWritten {
    /// It holds another text than the one that was edited.
    Changed,
    /// The system's reason.
    Refused(String),
}

impl ModelFile {
    /// The file at a path: a model file with text in it, perhaps none yet.
    pub(crate) fn open(path: &Path) -> Result<Self, Failure> {
        if bksim_load::is_drawn(path) {
            let help =
                "make a model file of it first: `bksim expand DRAWING -o model.toml`".to_owned();
            return Err(Failure::file(
                path,
                "is or names a drawing, and only texts are edited".to_owned(),
                Some(help),
            ));
        }
        let resolved = path.canonicalize().map_err(|e| Failure::reading(path, &e))?;
        let name =
            path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let file = Self { path: resolved, name };
        file.read().map(|_| file)
    }

    /// The name of the model, where its text states none.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// The text as it is now.
    pub(crate) fn read(&self) -> Result<String, Failure> {
        fs::read_to_string(&self.path).map_err(|e| Failure::reading(&self.path, &e))
    }

    /// Puts `text` in place of `before`, whole or not at all.
    pub(crate) fn write(&self, before: &str, text: &str) -> Result<(), Failure> {
        self.replace(before, text).map_err(|reason| {
            let (what, help) = match reason {
                NotWritten::Changed => ("was changed by another program".to_owned(), None),
                NotWritten::Refused(words) => (format!("cannot be written: {words}"), None),
            };
            Failure::file(&self.path, what, help)
        })
    }

    /// Writes the file ([`ModelFile::write`]), with the reason as data.
    pub(crate) fn replace(&self, before: &str, text: &str) -> Result<(), NotWritten> {
        let refused = |error: std::io::Error| NotWritten::Refused(error.to_string());
        let found = fs::read_to_string(&self.path).map_err(refused)?;
        if found != before {
            return Err(NotWritten::Changed);
        }
        if found == text {
            return Ok(());
        }
        let folder = self.path.parent().unwrap_or(Path::new("."));
        let mut new = NamedTempFile::new_in(folder).map_err(refused)?;
        new.write_all(text.as_bytes()).map_err(refused)?;
        new.as_file().sync_all().map_err(refused)?;
        let permissions = fs::metadata(&self.path).map_err(refused)?.permissions();
        fs::set_permissions(new.path(), permissions).map_err(refused)?;
        new.persist(&self.path).map(drop).map_err(|error| refused(error.error))
    }
}
