//! The command line, as the package brings it.

use std::ffi::OsString;

use pyo3::prelude::*;

use crate::fault::guard;

/// Does what the arguments of `bksim` say, and gives the exit status.
#[pyfunction]
pub(crate) fn command(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<u8> {
    guard(py, move || Ok(bksim_studio::run(&arguments)))
}
