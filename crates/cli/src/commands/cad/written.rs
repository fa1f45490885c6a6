//! Files that the commands of drawings write.

use std::path::Path;

use serde_json::{Value, json};

use crate::args::draw::Destination;
use crate::exit::{Failure, Status};
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

/// Refuses a file that exists, or that is read.
pub(super) fn check(written: &Destination, read: &[&Path]) -> Result<(), Failure> {
    let path = &written.output;
    refuse_inputs(path, read)?;
    check_ending(path, &["dxf"])?;
    if path.exists() && !written.force {
        let help = Some("add --force to overwrite it".to_owned());
        return Err(Failure::file(path, "exists already; nothing was written".to_owned(), help));
    }
    Ok(())
}

/// Writes the file and says so.
pub(super) fn write(
    command: &str,
    written: &Destination,
    bytes: &[u8],
    diagnostics: &Value,
    as_json: bool,
) -> Result<Status, Failure> {
    let path = &written.output;
    put(path, bytes)?;
    if as_json {
        let output = path.display().to_string();
        output::json(command, json!({ "output": output, "diagnostics": diagnostics }))?;
    } else {
        output::text(&format!("wrote {}", path.display()))?;
    }
    Ok(Status::Done)
}
