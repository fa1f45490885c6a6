//! Files as bytes: read whole, unless they are too large to be a model. `-` is standard input.

use std::fs;
use std::io::{self, Read};
use std::path::Path;
use std::sync::OnceLock;

use crate::error::InputError;
use crate::folder::models_in;

/// Larger model files are refused: a mechanism of ten thousand bodies takes a tenth of this.
const LARGEST_MODEL_BYTES: u64 = 64 * 1024 * 1024;

/// The bytes of a file that is small enough to be a model.
///
/// # Errors
/// [`InputError`] when it cannot be read, or is too large.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, InputError> {
    if is_stdin(path) {
        return standard_input();
    }
    let metadata = fs::metadata(path).map_err(|e| InputError::reading(path, &e))?;
    if metadata.is_dir() {
        let help = match models_in(path).first() {
            Some(first) => format!("name a file in it: `{}`", path.join(first).display()),
            None => {
                "there is no model and no drawing in it; `bksim new NAME` writes a model".to_owned()
            }
        };
        let help = Some(help);
        let what = "is a directory, not a model file".to_owned();
        return Err(InputError::File { path: path.to_owned(), what, help });
    }
    let size = metadata.len();
    if size > LARGEST_MODEL_BYTES {
        let what = format!("is {size} bytes long; a model may have {LARGEST_MODEL_BYTES}");
        return Err(InputError::NoModel { path: path.to_owned(), what });
    }
    // A device states no size, and need not end.
    let mut bytes = Vec::new();
    let file = fs::File::open(path).map_err(|e| InputError::reading(path, &e))?;
    let read = file.take(LARGEST_MODEL_BYTES + 1).read_to_end(&mut bytes);
    read.map_err(|e| InputError::reading(path, &e))?;
    if bytes.len() as u64 > LARGEST_MODEL_BYTES {
        let what = format!("is longer than {LARGEST_MODEL_BYTES} bytes, which a model may have");
        return Err(InputError::NoModel { path: path.to_owned(), what });
    }
    Ok(bytes)
}

/// The first bytes of every MCAP file.
const MCAP: [u8; 8] = *b"\x89MCAP0\r\n";

/// True for a log: by how it begins, or, where it begins otherwise, by its name.
pub fn is_log(path: &Path) -> bool {
    let mut first = [0; MCAP.len()];
    let read = fs::File::open(path).and_then(|mut file| file.read_exact(&mut first));
    let is_named = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"));
    is_named || read.is_ok() && first == MCAP
}

/// True for `-`, which stands for standard input.
pub fn is_stdin(path: &Path) -> bool {
    path == Path::new("-")
}

/// Standard input to its end. It can be read once only, and is kept for later calls.
fn standard_input() -> Result<Vec<u8>, InputError> {
    static READ: OnceLock<Result<Vec<u8>, String>> = OnceLock::new();
    let path = Path::new(STDIN);
    let read = READ.get_or_init(|| {
        let mut bytes = Vec::new();
        let most = LARGEST_MODEL_BYTES + 1;
        let read = io::stdin().lock().take(most).read_to_end(&mut bytes);
        read.map(|_| bytes).map_err(|error| error.to_string())
    });
    match read {
        Ok(bytes) if bytes.len() as u64 > LARGEST_MODEL_BYTES => {
            let what =
                format!("is longer than {LARGEST_MODEL_BYTES} bytes, which a model may have");
            Err(InputError::NoModel { path: path.to_owned(), what })
        }
        Ok(bytes) => Ok(bytes.clone()),
        Err(error) => {
            let what = format!("cannot be read: {error}");
            Err(InputError::File { path: path.to_owned(), what, help: None })
        }
    }
}

/// The name of standard input in messages.
pub(crate) const STDIN: &str = "<stdin>";
