//! Files that the commands of drawings write.

use std::path::Path;

use serde_json::{Value, json};

use crate::args::draw::Destination;
use crate::exit::{Failure, Status};
use crate::origin::{is_of_model, may_be_own, stamped};
use crate::output;
use crate::output_file::{check_ending, put};

/// Refuses a file that is read.
pub(super) fn refuse_inputs(path: &Path, read: &[&Path]) -> Result<(), Failure> {
    let own = path.canonicalize().ok();
    if own.is_some() && read.iter().any(|other| other.canonicalize().ok() == own) {
        let what = "is read by this command; nothing was written".to_owned();
        return Err(Failure::file(path, what, Some("name another file with -o".to_owned())));
    }
    Ok(())
}

/// Refuses a file that exists and is none of bksim's, or that is read.
pub(super) fn check(written: &Destination, read: &[&Path]) -> Result<(), Failure> {
    let path = &written.output;
    refuse_inputs(path, read)?;
    check_ending(path, &["dxf"])?;
    if path.exists() && !written.force && !may_be_own(path) {
        return Err(exists(path));
    }
    Ok(())
}

/// A file that somebody else has made.
pub(super) fn exists(path: &Path) -> Failure {
    let help = Some("add --force to overwrite it".to_owned());
    Failure::file(path, "exists already; nothing was written".to_owned(), help)
}

/// Writes a file of this model; what was there is replaced if it is one, too.
pub(super) fn put_own(
    path: &Path,
    (force, label): (bool, &str),
    bytes: Vec<u8>,
) -> Result<(), Failure> {
    if path.is_file() && !force && !is_of_model(path, label) {
        return Err(exists(path));
    }
    put(path, &stamped(path, bytes, label))
}

/// Writes a drawing of this model and says so.
pub(super) fn write(
    command: &str,
    (written, label): (&Destination, &str),
    bytes: Vec<u8>,
    diagnostics: &Value,
    as_json: bool,
) -> Result<Status, Failure> {
    let path = &written.output;
    put_own(path, (written.force, label), bytes)?;
    if as_json {
        let output = path.display().to_string();
        output::json(command, json!({ "output": output, "diagnostics": diagnostics }))?;
    } else {
        output::report(&format!("wrote {}", path.display()))?;
    }
    Ok(Status::Done)
}
