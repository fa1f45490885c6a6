//! Dense LU with partial pivoting, by columns, in buffers that are kept.
//!
//! For the sizes of single mechanisms this plain loop is faster than a blocked library kernel, and
//! it sees a vanishing pivot when it meets one.

use super::{Scalar, Singular};
use crate::Pattern;

/// `L⁻¹ A = U`, stored over `A` by columns; `L` is the product of the elementary exchanges and
/// eliminations in the order made, so columns of `L` are not exchanged afterwards.
pub(super) struct DenseLu<T> {
    n: usize,
    lu: Vec<T>,
    /// Row exchanged with row `k` at elimination step `k`.
    pivot: Vec<usize>,
}

impl<T: Scalar> DenseLu<T> {
    pub(super) fn new(n: usize) -> Self {
        Self { n, lu: vec![T::ZERO; n * n], pivot: vec![0; n] }
    }

    /// Factors the matrix whose `values` follow the entries of `pattern`.
    pub(super) fn factor(
        &mut self,
        pattern: &Pattern,
        values: impl Iterator<Item = T>,
    ) -> Result<(), Singular> {
        self.lu.fill(T::ZERO);
        for ((row, col), value) in pattern.entries().zip(values) {
            self.lu[col * self.n + row] = value;
        }
        (0..self.n).try_for_each(|k| self.eliminate(k))
    }

    /// Column `k`: choose the pivot, divide, update the columns to its right.
    fn eliminate(&mut self, k: usize) -> Result<(), Singular> {
        let n = self.n;
        let (done, right) = self.lu.split_at_mut((k + 1) * n);
        let column = &mut done[k * n..];

        let p = pivot_row(column, k)?;
        self.pivot[k] = p;
        column.swap(k, p);
        // Dividing, where multiplying by the inverse is faster, eliminates equal rows exactly: a
        // repeated equation then leaves a zero, not a rounding error, to be found as pivot.
        let pivot = column[k];
        for l in &mut column[k + 1..] {
            *l /= pivot;
        }

        for other in right.chunks_exact_mut(n) {
            other.swap(k, p);
            let factor = other[k];
            if factor == T::ZERO {
                continue;
            }
            for (a, &l) in other[k + 1..].iter_mut().zip(&column[k + 1..]) {
                *a -= l * factor;
            }
        }
        Ok(())
    }

    pub(super) fn solve_in_place(&self, x: &mut [T]) {
        let n = self.n;
        for k in 0..n {
            x.swap(k, self.pivot[k]);
            subtract_multiple(&mut x[k..], &self.lu[k * n + k..(k + 1) * n]);
        }
        for k in (0..n).rev() {
            let column = &self.lu[k * n..=k * n + k];
            x[k] /= column[k];
            let factor = x[k];
            for (x, &u) in x[..k].iter_mut().zip(column) {
                *x -= u * factor;
            }
        }
    }
}

/// `x[1..] −= x[0] · l[1..]`.
fn subtract_multiple<T: Scalar>(x: &mut [T], l: &[T]) {
    let (first, rest) = x.split_at_mut(1);
    for (x, &l) in rest.iter_mut().zip(&l[1..]) {
        *x -= l * first[0];
    }
}

/// The row, from `k` on, of the largest entry of a column.
fn pivot_row<T: Scalar>(column: &[T], k: usize) -> Result<usize, Singular> {
    let mut best = (k, 0.0);
    for (row, value) in column.iter().enumerate().skip(k) {
        let magnitude = value.magnitude();
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
