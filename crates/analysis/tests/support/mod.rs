//! Reference problems from files, and comparisons with them.
#![allow(dead_code, reason = "each program of tests uses a part of it")]

use std::f64::consts::TAU;
use std::path::Path;

use bksim_analysis::Table;
use bksim_model::Model;
use bksim_model::file::{Source, read};
use serde_json::Value;

/// A reference problem.
pub(crate) struct Problem(pub(crate) Value);

impl Problem {
    pub(crate) fn load(name: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/data/{name}.json"));
        let text = std::fs::read_to_string(&path).expect("a readable problem");
        Self(serde_json::from_str(&text).expect("a problem in JSON"))
    }

    /// The model, from its text.
    pub(crate) fn model(&self) -> Model {
        model(self.0["model"]["toml"].as_str().expect("text of a model"))
    }

    pub(crate) fn columns(&self) -> Vec<String> {
        let columns = self.0["columns"].as_array().expect("columns");
        columns.iter().map(|c| c.as_str().expect("a name").to_owned()).collect()
    }

    pub(crate) fn rows(&self) -> Vec<Vec<f64>> {
        self.rows_of("rows")
    }

    pub(crate) fn rows_of(&self, key: &str) -> Vec<Vec<f64>> {
        let rows = self.0[key].as_array().expect("rows");
        let row = |row: &Value| row.as_array().expect("a row").iter().map(number).collect();
        rows.iter().map(row).collect()
    }
}

pub(crate) fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

pub(crate) fn model(text: &str) -> Model {
    let reading = read(&Source::new(text, "model"));
    reading.model.unwrap_or_else(|| panic!("{:?}", reading.diagnostics))
}

/// A model without masses.
pub(crate) fn geometry(text: &str) -> Model {
    let reading = read(&Source { is_geometry: true, ..Source::new(text, "model") });
    reading.model.unwrap_or_else(|| panic!("{:?}", reading.diagnostics))
}

/// Largest difference of a column from its reference, over the largest value there; angles modulo 2π.
pub(crate) fn difference(found: &[f64], expected: &[f64], is_angle: bool) -> f64 {
    assert_eq!(found.len(), expected.len(), "as many rows");
    let size = expected.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let size = if is_angle || size == 0.0 { 1.0 } else { size };
    let off = |(a, b): (&f64, &f64)| {
        let off = a - b;
        (if is_angle { off - TAU * (off / TAU).round() } else { off }).abs()
    };
    let worst = found
        .iter()
        .zip(expected)
        .map(off)
        .fold(0.0, |a: f64, b| if b.is_nan() { b } else { a.max(b) });
    worst / size
}

/// Checks that the table has the reference's columns with the reference's values.
pub(crate) fn compare(table: &Table, columns: &[String], rows: &[Vec<f64>], tolerance: f64) {
    for (k, name) in columns.iter().enumerate() {
        let found = table.column(name).unwrap_or_else(|| panic!("no column {name}"));
        let expected: Vec<f64> = rows.iter().map(|row| row[k]).collect();
        let off = difference(&found, &expected, name.rsplit('.').next() == Some("angle"));
        assert!(off <= tolerance, "{name} differs by {off:e}");
    }
}
