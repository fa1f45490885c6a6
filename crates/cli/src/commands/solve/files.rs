//! The file of a log: its name, and whether it may be written.

use std::fs;
use std::path::{Path, PathBuf};

use crate::exit::Failure;

/// A file in the working directory that is called after a model.
pub fn named_after(model_name: &str, ending: &str) -> PathBuf {
    let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    PathBuf::from(format!("{}.{ending}", model_name.chars().map(plain).collect::<String>()))
}

pub(super) fn is_same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// Refuses an output that exists, is the model itself, or has no directory to lie in.
///
/// # Errors
/// The first of these faults.
pub fn check_output(path: &Path, inputs: &[&Path], force: bool) -> Result<(), Failure> {
    let nothing_solved = "nothing was solved";
    let directory = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if !directory.is_dir() {
        let there = directory.display();
        let what = format!("cannot be written: there is no directory `{there}`; {nothing_solved}");
        let help = format!("make it with `mkdir -p {}`", directory.display());
        return Err(Failure::file(path, what, Some(help)));
    }
    if inputs.iter().any(|input| is_same_file(path, input)) {
        let what = format!("is the model itself and would be overwritten; {nothing_solved}");
        return Err(Failure::file(path, what, Some("name another file with -o".to_owned())));
    }
    if let Ok(known) = fs::metadata(path) {
        if known.is_dir() {
            let what = format!("is a directory; {nothing_solved}");
            return Err(Failure::file(path, what, Some("name a file in it".to_owned())));
        }
        if !force {
            let written = known.modified().ok().map_or_else(String::new, |time| {
                format!(", written {}", humantime::format_rfc3339_seconds(time))
            });
            let what = format!("exists ({} bytes{written}); {nothing_solved}", known.len());
            let help = "add --force to overwrite it, or name another file with -o".to_owned();
            return Err(Failure::file(path, what, Some(help)));
        }
    }
    Ok(())
}
