//! Numbers as NumPy arrays. What is computed here becomes an array without a copy, and cannot be
//! written to: several arrays are views of one.

use numpy::ndarray::Array2;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

/// Number of samples that stay in the cache while their columns are written.
const BLOCK: usize = 64;

/// Samples one after another as rows of quantities: `n_columns` numbers per sample become `n_columns`
/// rows with a number per sample, each contiguous.
pub(crate) fn transposed(values: &[f64], n_columns: usize) -> Array2<f64> {
    let n_samples = values.len().checked_div(n_columns).unwrap_or(0);
    let mut table = Array2::zeros((n_columns, n_samples));
    if let Some(out) = table.as_slice_mut() {
        for (block_idx, block) in values.chunks(BLOCK * n_columns.max(1)).enumerate() {
            for column in 0..n_columns {
                let first = column * n_samples + block_idx * BLOCK;
                let of_column = block[column..].iter().step_by(n_columns);
                for (out, &value) in out[first..].iter_mut().zip(of_column) {
                    *out = value;
                }
            }
        }
    }
    table
}

/// A table that cannot be written to.
pub(crate) fn table(py: Python<'_>, values: Array2<f64>) -> Bound<'_, PyArray2<f64>> {
    let array = PyArray2::from_owned_array(py, values);
    let _ = array.readwrite().make_nonwriteable();
    array
}

/// A vector that cannot be written to.
pub(crate) fn vector(py: Python<'_>, values: Vec<f64>) -> Bound<'_, PyArray1<f64>> {
    let array = PyArray1::from_vec(py, values);
    let _ = array.readwrite().make_nonwriteable();
    array
}
