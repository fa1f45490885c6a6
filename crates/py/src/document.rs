//! The text of a model as data, and back. What goes between is JSON, which both sides read.

use pyo3::prelude::*;

use crate::fault::{Fault, guard};

/// The text of a model whose tables are given as a JSON object.
#[pyfunction]
pub(crate) fn to_toml(py: Python<'_>, json: String) -> PyResult<String> {
    guard(py, move || {
        let bad = |error: &dyn std::fmt::Display| {
            Fault::Value(format!("this cannot be written as a model: {error}"))
        };
        let value: toml::Value = serde_json::from_str(&json).map_err(|e| bad(&e))?;
        toml::to_string(&value).map_err(|e| bad(&e))
    })
}

/// The tables of a model's text as a JSON object.
#[pyfunction]
pub(crate) fn from_toml(py: Python<'_>, text: String) -> PyResult<String> {
    guard(py, move || {
        let bad = |error: &dyn std::fmt::Display| Fault::Value(format!("this is no TOML: {error}"));
        let value: toml::Table = toml::from_str(&text).map_err(|e| bad(&e))?;
        serde_json::to_string(&value).map_err(|e| bad(&e))
    })
}
