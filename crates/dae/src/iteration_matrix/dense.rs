//! Dense LU of real matrices, by columns.
//!
//! Columns are padded to whole chunks, and those of `L` hold zeros down to the diagonal, so that
//! every inner loop runs over whole chunks and becomes vector code.

use super::{DenseKernel, Singular};
use crate::Pattern;

/// Rows that are worked on together.
pub(super) const CHUNK: usize = 4;

/// A row count that fills whole chunks.
pub(super) fn padded(n: usize) -> usize {
    n.next_multiple_of(CHUNK)
}

/// Where the entries of a pattern lie in columns of height `height`.
pub(super) fn places(pattern: &Pattern, height: usize) -> Vec<usize> {
    pattern.entries().map(|(row, col)| col * height + row).collect()
}

/// `L⁻¹ A = U`; `L` is the product of the elementary exchanges and eliminations in the order made,
/// so columns of `L` are not exchanged afterwards.
pub(crate) struct RealLu {
    n: usize,
    /// Length of a column.
    height: usize,
    places: Vec<usize>,
    /// The matrix, then `U` above and on the diagonal.
    u: Vec<f64>,
    /// `L` below the diagonal, zero elsewhere.
    l: Vec<f64>,
    /// Row exchanged with row `k` at elimination step `k`.
    pivot: Vec<usize>,
    x: Vec<f64>,
}

impl DenseKernel<f64> for RealLu {
    fn new(pattern: &Pattern) -> Self {
        let n = pattern.n();
        let height = padded(n);
        Self {
            n,
            height,
            places: places(pattern, height),
            u: vec![0.0; n * height],
            l: vec![0.0; n * height],
            pivot: vec![0; n],
            x: vec![0.0; height],
        }
    }

    fn factor(&mut self, values: &[f64]) -> Result<(), Singular> {
        self.u.fill(0.0);
        for (&place, &value) in self.places.iter().zip(values) {
            self.u[place] = value;
        }
        (0..self.n).try_for_each(|k| self.eliminate(k))
    }

    fn solve_in_place(&mut self, x: &mut [f64]) {
        let Self { n, height, .. } = *self;
        self.x[..n].copy_from_slice(x);
        let b = &mut self.x;
        for k in 0..n {
            b.swap(k, self.pivot[k]);
            let factor = b[k];
            subtract(&mut b[floor(k)..], &self.l[k * height + floor(k)..(k + 1) * height], factor);
        }
        for k in (0..n).rev() {
            let column = &self.u[k * height..(k + 1) * height];
            let value = b[k] / column[k];
            // Below the diagonal the column holds what is of no use: only whole rows above count.
            subtract_above(b, column, k, value);
            b[k] = value;
        }
        x.copy_from_slice(&b[..n]);
    }
}

impl RealLu {
    /// Column `k`: choose the pivot, divide, update the columns to its right.
    fn eliminate(&mut self, k: usize) -> Result<(), Singular> {
        let (n, height) = (self.n, self.height);
        let (done, right) = self.u.split_at_mut((k + 1) * height);
        let column = &mut done[k * height..];

        let p = pivot_row(&column[..n], k)?;
        self.pivot[k] = p;
        column.swap(k, p);
        // Dividing, where multiplying by the inverse is faster, eliminates equal rows exactly: a
        // repeated equation then leaves a zero, not a rounding error, to be found as pivot.
        let pivot = column[k];
        let l = &mut self.l[k * height..(k + 1) * height];
        for (l, value) in l[k + 1..n].iter_mut().zip(&column[k + 1..n]) {
            *l = value / pivot;
        }

        let l = &l[floor(k)..];
        for other in right.chunks_exact_mut(height) {
            other.swap(k, p);
            let factor = other[k];
            if factor != 0.0 {
                subtract(&mut other[floor(k)..], l, factor);
            }
        }
        Ok(())
    }
}

/// Start of the chunk that holds row `k`.
pub(super) fn floor(k: usize) -> usize {
    k / CHUNK * CHUNK
}

/// `x −= factor · l`, in whole chunks.
fn subtract(x: &mut [f64], l: &[f64], factor: f64) {
    for (x, l) in x.as_chunks_mut::<CHUNK>().0.iter_mut().zip(l.as_chunks::<CHUNK>().0) {
        for i in 0..CHUNK {
            x[i] -= factor * l[i];
        }
    }
}

/// `x_i −= factor · u_i` for `i < k`.
fn subtract_above(x: &mut [f64], u: &[f64], k: usize, factor: f64) {
    subtract(&mut x[..floor(k)], &u[..floor(k)], factor);
    for i in floor(k)..k {
        x[i] -= factor * u[i];
    }
}

/// The row, from `k` on, of the largest entry of a column.
fn pivot_row(column: &[f64], k: usize) -> Result<usize, Singular> {
    let mut best = (k, 0.0);
    for (row, value) in column.iter().enumerate().skip(k) {
        let magnitude = value.abs();
        // Comparisons with NaN are false: it must be refused by name.
        if !magnitude.is_finite() {
            return Err(Singular);
        }
        if magnitude > best.1 {
            best = (row, magnitude);
        }
    }
    if best.1 > 0.0 { Ok(best.0) } else { Err(Singular) }
}
