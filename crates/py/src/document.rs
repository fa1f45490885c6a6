//! The text of a model as data, and back. What goes between is JSON, which both sides read.

use bksim_cli::examples::{EXAMPLES, Example};
use pyo3::prelude::*;

use crate::fault::{Fault, guard};

/// The text of a model whose tables are given as a JSON object.
#[pyfunction]
pub(crate) fn to_toml(py: Python<'_>, json: String) -> PyResult<String> {
    guard(py, move || {
        let bad = |error: &dyn std::fmt::Display| {
            Fault::Value(format!("this cannot be written as a model: {error}"))
        };
        let value: serde_json::Value = serde_json::from_str(&json).map_err(|e| bad(&e))?;
        toml_edit::ser::to_string_pretty(&value).map_err(|e| bad(&e))
    })
}

/// The tables of a model's text as a JSON object.
#[pyfunction]
pub(crate) fn from_toml(py: Python<'_>, text: String) -> PyResult<String> {
    guard(py, move || {
        let bad = |error: &dyn std::fmt::Display| Fault::Value(format!("this is no TOML: {error}"));
        // This reader keeps the order of the text.
        let value: serde_json::Value = toml_edit::de::from_str(&text).map_err(|e| bad(&e))?;
        serde_json::to_string(&value).map_err(|e| bad(&e))
    })
}

/// The text of a model with other values of some parameters.
#[pyfunction]
pub(crate) fn with_values(
    py: Python<'_>,
    text: String,
    values: Vec<(String, String)>,
) -> PyResult<String> {
    guard(py, move || {
        let bad = |error: &dyn std::fmt::Display| Fault::Value(format!("this is no TOML: {error}"));
        let mut document: toml_edit::DocumentMut = text.parse().map_err(|e| bad(&e))?;
        let parameters =
            document.get_mut("parameters").and_then(toml_edit::Item::as_table_like_mut);
        let Some(parameters) = parameters else { return Ok(text) };
        for (name, value) in values {
            if let Some(known) = parameters.get_mut(&name).and_then(toml_edit::Item::as_value_mut) {
                // What stands around it, a comment after it, stays.
                let around = known.decor().clone();
                *known = value.into();
                *known.decor_mut() = around;
            }
        }
        Ok(document.to_string())
    })
}

/// Names of the models that come with bksim and their texts.
#[pyfunction]
pub(crate) fn examples() -> Vec<(&'static str, &'static str)> {
    let text = |example: &Example| {
        let file = example.files.iter().find(|(name, _)| *name == "model.toml")?;
        Some((example.name, std::str::from_utf8(file.1).ok()?))
    };
    EXAMPLES.iter().filter_map(text).collect()
}
