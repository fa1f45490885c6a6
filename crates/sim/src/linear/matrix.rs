//! [`Matrix`]: a matrix that is dense where the mechanism is small, else sparse.

use nalgebra::{DMatrix, DVector};

use crate::linear::rows::{LARGEST_DENSE, SparseRows};

/// A matrix of as many columns as there are coordinates.
#[derive(Clone, PartialEq, Debug)]
pub(crate) enum Matrix {
    /// Of at most [`LARGEST_DENSE`] columns.
    Dense(DMatrix<f64>),
    /// Of more.
    Sparse(SparseRows),
}

impl Matrix {
    /// The form that suits the size.
    pub(crate) fn of(rows: SparseRows) -> Self {
        if rows.n_columns > LARGEST_DENSE { Self::Sparse(rows) } else { Self::Dense(rows.dense()) }
    }

    /// The product with a column.
    pub(crate) fn times(&self, x: &DVector<f64>) -> DVector<f64> {
        match self {
            Self::Dense(matrix) => matrix * x,
            Self::Sparse(rows) => DVector::from_vec(rows.times(x.as_slice())),
        }
    }
}
