//! Errors and panics as Python's exceptions, and the one way to do work: without the interpreter
//! lock, and with panics caught.
//!
//! The classes are those of `bksim._errors` and `bksim._ended`, which makes the exceptions: here are the kinds.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::built::{self, json_all};
use crate::laws;
use bksim::answered::{Role, answered};
use bksim::messages::phrase;
use bksim::model::diagnostic::Diagnostic;
use bksim::translation::{Language, page, spoken};
use bksim_load::{InputError, Text};
use pyo3::exceptions::{PyKeyError, PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyString;

/// Why a call comes to nothing.
#[derive(Debug)]
pub(crate) enum Fault {
    /// The model is refused: message, diagnostics as JSON.
    Model(String, String),
    /// There is no consistent start.
    Assembly(String, String),
    /// A motion cannot go on at a time, s: message, diagnostics as JSON.
    Motion(f64, String, String),
    /// More was asked for than there may be.
    Limit(String),
    /// A log cannot be read or played.
    Log(String),
    /// Nothing can be drawn here.
    Drawing(String),
    /// A file cannot be read or written.
    File(String),
    /// An argument makes no sense.
    Value(String),
    /// Nothing has this name.
    Name(String),
    /// Something that bksim itself does wrong.
    Internal(String),
    /// Something of Python's own.
    Python(PyErr),
}

impl Fault {
    /// Faults of a model's text.
    pub(crate) fn model(source: &Text, diagnostics: &[Diagnostic]) -> Self {
        Self::Model(words(source, diagnostics), json_all(source, diagnostics).to_string())
    }

    /// A start that there is none of.
    pub(crate) fn assembly(source: &Text, diagnostics: &[Diagnostic]) -> Self {
        Self::Assembly(words(source, diagnostics), json_all(source, diagnostics).to_string())
    }

    /// A motion that cannot go on.
    pub(crate) fn motion(source: &Text, t: f64, fault: &Diagnostic) -> Self {
        let all = json_all(source, std::slice::from_ref(fault));
        Self::Motion(t, built::words(source, fault), all.to_string())
    }

    fn raised(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Motion(t, message, diagnostics) => {
                exception(py, "stopped", (t, message, diagnostics))
            }
            Self::Model(message, diagnostics) => made(py, "model", &message, &diagnostics),
            Self::Assembly(message, diagnostics) => made(py, "assembly", &message, &diagnostics),
            Self::Limit(message) => made(py, "limit", &phrase(&message), "[]"),
            Self::Log(message) => made(py, "log", &phrase(&message), "[]"),
            Self::Drawing(message) => made(py, "drawing", &phrase(&message), "[]"),
            Self::Internal(message) => made(py, "internal", &message, "[]"),
            Self::File(message) => PyOSError::new_err(phrase(&message)),
            Self::Value(message) => PyValueError::new_err(phrase(&message)),
            Self::Name(message) => PyKeyError::new_err(phrase(&message)),
            Self::Python(error) => error,
        }
    }
}

fn words(source: &Text, diagnostics: &[Diagnostic]) -> String {
    // What is wrong comes first.
    let (errors, warnings): (Vec<_>, Vec<_>) = diagnostics.iter().partition(|f| f.is_error());
    let words = errors.into_iter().chain(warnings).map(|fault| built::words(source, fault));
    words.collect::<Vec<_>>().join("\n\n")
}

impl From<InputError> for Fault {
    fn from(error: InputError) -> Self {
        match error {
            InputError::Model { source_text, diagnostics } => {
                Self::model(&source_text, &diagnostics)
            }
            InputError::File { .. } => Self::File(error.to_string()),
            InputError::NoModel { .. } => Self::Limit(error.to_string()),
            InputError::Unit { .. } => Self::Value(error.to_string()),
        }
    }
}

impl From<PyErr> for Fault {
    fn from(error: PyErr) -> Self {
        Self::Python(error)
    }
}

/// An exception of `bksim._errors` or `bksim._ended`.
fn made(py: Python<'_>, kind: &str, message: &str, diagnostics: &str) -> PyErr {
    exception(py, "made", (kind, message, diagnostics))
}

/// The exception that a function of `bksim._ended` makes of its arguments.
fn exception<'py, A>(py: Python<'py>, maker: &str, arguments: A) -> PyErr
where
    A: pyo3::call::PyCallArgs<'py>,
{
    let made = py
        .import("bksim._ended")
        .and_then(|errors| errors.getattr(maker))
        .and_then(|make| make.call1(arguments));
    made.map_or_else(|error| error, PyErr::from_value)
}

/// Warns of inputs that are hardly meant as they are written; whoever gave them called so many functions of the package.
pub(crate) fn warn(
    py: Python<'_>,
    source: &Text,
    warnings: &[Diagnostic],
    depth: usize,
) -> PyResult<()> {
    if warnings.is_empty() {
        return Ok(());
    }
    let diagnostics = json_all(source, warnings).to_string();
    py.import("bksim._errors")?.call_method1("warn", (diagnostics, depth)).map(drop)
}

/// Does work that other threads of Python need not wait for; a panic in it is an `InternalError`, and
/// what a law of Python's raises in it is raised.
pub(crate) fn guard<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Fault> + Send,
) -> PyResult<T> {
    let outcome = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    match (outcome, laws::raised()) {
        (Ok(_), Some(error)) => Err(error),
        (Ok(Ok(value)), None) => Ok(value),
        (Ok(Err(fault)), None) => Err(fault.raised(py)),
        (Err(panic), _) => Err(made(py, "internal", &panic_words(panic.as_ref()), "[]")),
    }
}

/// Does the work of one call of some microseconds, for which the interpreter lock is kept: as [`guard`], and
/// without what it takes to give the lock up.
pub(crate) fn brief<T>(py: Python<'_>, work: impl FnOnce() -> T) -> PyResult<T> {
    let outcome = catch_unwind(AssertUnwindSafe(work));
    match (outcome, laws::raised()) {
        (Ok(_), Some(error)) => Err(error),
        (Ok(value), None) => Ok(value),
        (Err(panic), _) => Err(made(py, "internal", &panic_words(panic.as_ref()), "[]")),
    }
}

fn panic_words(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default()
}

/// The meaning of a code and the way out, or `None` when there is no such code.
#[pyfunction]
#[pyo3(signature = (code, lang = "en"))]
pub(crate) fn explain(code: &str, lang: &str) -> Option<String> {
    page(code, Language::of_locale(lang))
}

/// Panics, so that tests can see what becomes of it.
#[pyfunction]
#[pyo3(name = "_panic")]
pub(crate) fn panic_for_tests(py: Python<'_>, words: Bound<'_, PyString>) -> PyResult<()> {
    let words = words.to_string();
    guard(py, move || -> Result<(), Fault> { std::panic::panic_any(words) })
}

/// Sets the language of what is shown for people, by a locale such as `vi_VN.UTF-8`.
#[pyfunction]
pub(crate) fn speak(locale: &str) {
    bksim::translation::speak(Language::of_locale(locale));
}

/// A heading, a label or a sentence in the language that is spoken; the text itself where it is English.
#[pyfunction]
pub(crate) fn said(text: &str) -> String {
    answered(text, Role::Heading, spoken())
}

/// An answer of several lines in the language that is spoken.
#[pyfunction]
pub(crate) fn said_answer(text: &str) -> String {
    bksim_cli::output::translated(text).into_owned()
}
