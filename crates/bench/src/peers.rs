//! Other programs: Python scripts that read and write JSON, and C programs compiled here.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::error::BenchError;
use crate::timing::Effort;

/// Folder of the scripts and the C sources.
const HOME: &str = env!("CARGO_MANIFEST_DIR");

/// Surroundings of a suite: programs to compare with, our own, and how long to measure.
#[derive(Debug)]
pub(crate) struct Context {
    pub(crate) peers: Peers,
    /// The command `bksim`.
    pub(crate) program: PathBuf,
    pub(crate) effort: Effort,
}

/// The programs to compare with.
#[derive(Debug)]
pub(crate) struct Peers {
    python: Option<String>,
    cc: Option<String>,
}

/// Reason that a peer has no numbers, for the report's notes.
pub(crate) type Absent = String;

impl Peers {
    /// Peers that are run by these programs, as far as they are installed.
    pub(crate) fn new(python: &str, cc: &str) -> Self {
        Self { python: Some(python.to_owned()), cc: Some(cc.to_owned()) }
    }

    /// No peers.
    pub(crate) fn none() -> Self {
        Self { python: None, cc: None }
    }

    /// Runs `peers/<script>.py`: JSON in, JSON out. A script prints `{"missing": "…"}` if a package
    /// it needs cannot be imported.
    pub(crate) fn python(&self, script: &str, input: &Value) -> Result<Value, Absent> {
        let python = self.python.as_deref().ok_or("peers are switched off")?;
        let path = Path::new(HOME).join("peers").join(format!("{script}.py"));
        let output = run(Command::new(python).arg(path), &input.to_string())?;
        let value: Value = serde_json::from_str(&output)
            .map_err(|error| format!("{script}.py printed no JSON: {error}"))?;
        match value["missing"].as_str() {
            Some(missing) => Err(format!("{missing} is missing")),
            None => Ok(value),
        }
    }

    /// Compiles `sources` into a program at `target`, with `libraries` as the linker names them.
    pub(crate) fn compile(
        &self,
        sources: &[&Path],
        flags: &[&str],
        libraries: &[&str],
        target: &Path,
    ) -> Result<(), Absent> {
        let cc = self.cc.as_deref().ok_or("peers are switched off")?;
        let mut command = Command::new(cc);
        command.args(flags).args(sources).arg("-o").arg(target).args(libraries).arg("-lm");
        run(&mut command, "").map(|_| ())
    }

    /// The compiled code of a package of R.
    pub(crate) fn r_library(&self, package: &str) -> Result<PathBuf, Absent> {
        // Without Python, peers are switched off.
        self.python.as_deref().ok_or("peers are switched off")?;
        let query = format!("cat(system.file('libs/{package}.so', package = '{package}'))");
        let answer = run(Command::new("Rscript").args(["-e", &query]), "")?;
        match answer.trim() {
            "" => Err(format!("R's package {package} is missing")),
            path => Ok(PathBuf::from(path)),
        }
    }
}

/// Runs a compiled program.
pub(crate) fn program(program: &Path, input: &str) -> Result<String, Absent> {
    run(&mut Command::new(program), input)
}

/// A file of `native/`.
pub(crate) fn native(name: &str) -> PathBuf {
    Path::new(HOME).join("native").join(name)
}

/// A fresh folder for compiled programs, removed when dropped.
#[derive(Debug)]
pub(crate) struct Workbench(PathBuf);

impl Workbench {
    /// Makes the folder.
    pub(crate) fn new() -> Result<Self, BenchError> {
        let path = std::env::temp_dir().join(format!("bksim-bench-{}", std::process::id()));
        std::fs::create_dir_all(&path).map_err(|source| BenchError::io(&path, source))?;
        Ok(Self(path))
    }

    /// A file in it.
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Writes a file in it.
    pub(crate) fn write(&self, name: &str, text: &str) -> Result<PathBuf, BenchError> {
        let path = self.file(name);
        std::fs::write(&path, text).map_err(|source| BenchError::io(&path, source))?;
        Ok(path)
    }
}

impl Drop for Workbench {
    fn drop(&mut self) {
        // A folder that stays in the temporary directory does no harm.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Runs a command with `input` on its standard input; returns its output, or the reason of its
/// failure.
fn run(command: &mut Command, input: &str) -> Result<String, Absent> {
    let name = command.get_program().to_string_lossy().into_owned();
    let failed = |error: std::io::Error| format!("`{name}` cannot be run: {error}");
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(failed)?;
    // The whole input is read before anything is printed, so the pipes cannot block each other.
    if let Some(mut stdin) = child.stdin.take() {
        stdin.write_all(input.as_bytes()).map_err(failed)?;
    }
    let output = child.wait_with_output().map_err(failed)?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let errors = String::from_utf8_lossy(&output.stderr);
    let last = errors.lines().last().unwrap_or("it printed no error");
    Err(format!("`{name}` failed: {last}"))
}
