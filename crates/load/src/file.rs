//! Files as bytes: read whole, unless they are too large to be a model.

use std::fs;
use std::path::Path;

use crate::error::InputError;

/// Larger model files are refused: a mechanism of ten thousand bodies takes a tenth of this.
const LARGEST_MODEL_BYTES: u64 = 64 * 1024 * 1024;

/// The bytes of a file that is small enough to be a model.
///
/// # Errors
/// [`InputError`] when it cannot be read, or is too large.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, InputError> {
    let metadata = fs::metadata(path).map_err(|e| InputError::reading(path, &e))?;
    if metadata.is_dir() {
        let help = Some(format!("name a file in it: `{}`", path.join("model.toml").display()));
        let what = "is a directory, not a model file".to_owned();
        return Err(InputError::File { path: path.to_owned(), what, help });
    }
    let size = metadata.len();
    if size > LARGEST_MODEL_BYTES {
        let what = format!("is {size} bytes long; a model may have {LARGEST_MODEL_BYTES}");
        return Err(InputError::NoModel { path: path.to_owned(), what });
    }
    fs::read(path).map_err(|e| InputError::reading(path, &e))
}
