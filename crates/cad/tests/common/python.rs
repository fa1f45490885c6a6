//! Runs Python scripts with the packages of `tests/requirements.txt`: the independent library that
//! draws the drawings of the tests and judges those that are written.

#![allow(dead_code, reason = "every test file uses its own part of it")]

use std::path::{Path, PathBuf};
use std::process::Command;

/// The root of the repository.
pub(crate) fn workspace() -> &'static Path {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    root.into_iter().find(|p| p.join("tests/requirements.txt").is_file()).expect("the repository")
}

/// The interpreter: `BKSIM_PYTHON`, or the one of `target/venv`.
fn interpreter() -> PathBuf {
    std::env::var_os("BKSIM_PYTHON")
        .map_or_else(|| workspace().join("target/venv/bin/python"), PathBuf::from)
}

/// Runs a script and returns what it prints on stdout.
///
/// # Panics
/// When there is no interpreter, saying how to make it, and when the script fails, with its stderr.
pub(crate) fn python(script: &Path, args: &[&str]) -> String {
    let interpreter = interpreter();
    assert!(
        interpreter.is_file(),
        "there is no {}: make it with `tests/setup.sh`, or name an interpreter that has the packages \
         of tests/requirements.txt in BKSIM_PYTHON",
        interpreter.display()
    );
    // No bytecode next to the scripts: the working tree stays as it is.
    let run = Command::new(&interpreter).arg("-B").arg(script).args(args).output();
    let output = run.unwrap_or_else(|e| panic!("{} does not run: {e}", interpreter.display()));
    assert!(
        output.status.success(),
        "{} {args:?}: {}\n{}",
        script.display(),
        output.status,
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).expect("scripts print UTF-8")
}
