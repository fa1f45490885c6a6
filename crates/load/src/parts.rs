//! Models of several files: the parts and rows that a model names, found next to it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bksim::model::diagnostic::{Diagnostic, Label};
use bksim::model::file::{Expansion, Limits, SourceFile, expand};

use crate::error::InputError;
use crate::file::read_bytes;
use crate::text::{Parts, Text, moved_by};

/// The text of a model with its parts in it, and warnings about them; the text itself where it has none.
///
/// # Errors
/// [`InputError::Model`] with the faults of parts and rows.
pub fn whole(source: Text, limits: Limits) -> Result<(Text, Vec<Diagnostic>), InputError> {
    let folder = source.path.parent().unwrap_or(Path::new("")).to_owned();
    let name = source.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut open = |file: &str| opened(&folder, file);
    let Some(mut expansion) = expand(&name, &source.text, limits, &mut open) else {
        return Ok((source, Vec::new()));
    };
    let faults = std::mem::take(&mut expansion.faults);
    let offset = expansion.text.len() + 1;
    let faults: Vec<Diagnostic> = faults.into_iter().map(|fault| moved_by(fault, offset)).collect();
    let text = with_parts(source, &folder, expansion);
    if faults.iter().any(Diagnostic::is_error) {
        return Err(text.rejected(faults));
    }
    Ok((text, faults))
}

fn with_parts(model: Text, folder: &Path, expansion: Expansion) -> Text {
    let path = |file: &SourceFile| {
        let is_own = !file.is_of_library();
        if is_own { folder.join(&file.name) } else { PathBuf::from(&file.name) }
    };
    let paths: Vec<PathBuf> = expansion.files.iter().map(path).collect();
    let whole = Text::new(model.path.clone(), expansion.text.clone());
    Text { parts: Some(Arc::new(Parts { expansion, paths, model })), ..whole }
}

/// The bytes of a file in a folder or below it, links resolved: a model from elsewhere has no business with
/// other files.
fn opened(folder: &Path, file: &str) -> Result<Vec<u8>, String> {
    let path = folder.join(file);
    let bytes = read_bytes(&path).map_err(|error| match error {
        InputError::File { what, .. } | InputError::NoModel { what, .. } => what,
        error => error.to_string(),
    })?;
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let [Ok(here), Ok(found)] = [here.canonicalize(), path.canonicalize()] else {
        return Err("cannot be found".to_owned());
    };
    if !found.starts_with(&here) {
        return Err("lies outside of the folder of the model".to_owned());
    }
    Ok(bytes)
}

impl Parts {
    /// The file of a span of the model's text, or of a fault of its parts, and the span there.
    pub(crate) fn site(&self, label: &Label) -> Option<(usize, Label)> {
        let offset = self.expansion.text.len() + 1;
        let (file_idx, span) = if label.span.start >= offset {
            self.expansion.source(&(label.span.start - offset..label.span.end - offset))
        } else {
            self.expansion.origin(&label.span)?
        };
        Some((file_idx, Label { span, text: label.text.clone() }))
    }
}
