//! Dense LU of real matrices, by columns.
//!
//! Columns are padded to whole registers; those of `L` hold zeros down to the diagonal, those of
//! `U` from there on, so that every inner loop runs over whole registers.

use pulp::{Simd, WithSimd};

use super::{DenseKernel, Singular};
use crate::Pattern;
use crate::lanes::{self, floor, padded, subtract};

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
    /// The matrix, then `U` above the diagonal, zero elsewhere.
    u: Vec<f64>,
    diagonal: Vec<f64>,
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
            diagonal: vec![0.0; n],
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
        lanes::run(Elimination(self))
    }

    fn solve_in_place(&mut self, x: &mut [f64]) {
        self.x[..self.n].copy_from_slice(x);
        lanes::run(Substitution(self));
        x.copy_from_slice(&self.x[..self.n]);
    }
}

/// Column after column: choose the pivot, divide, update the columns to the right.
struct Elimination<'a>(&'a mut RealLu);

impl WithSimd for Elimination<'_> {
    type Output = Result<(), Singular>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let RealLu { n, height, u, diagonal, l, pivot, .. } = self.0;
        let (n, height) = (*n, *height);
        for k in 0..n {
            let (done, right) = u.split_at_mut((k + 1) * height);
            let column = &mut done[k * height..];
            let l = &mut l[k * height..(k + 1) * height];

            let p = pivot_row(&column[..n], k)?;
            pivot[k] = p;
            column.swap(k, p);
            // Dividing, where multiplying by the inverse is faster, eliminates equal rows exactly:
            // a repeated equation then leaves a zero, not a rounding error, to be found as pivot.
            diagonal[k] = column[k];
            let first = floor(k);
            for (l, value) in l[first..].iter_mut().zip(&column[first..]) {
                *l = value / diagonal[k];
            }
            l[first..=k].fill(0.0);
            column[k..].fill(0.0);

            let l = &l[first..];
            for other in right.chunks_exact_mut(height) {
                other.swap(k, p);
                let factor = other[k];
                if factor != 0.0 {
                    subtract(simd, &mut other[first..], l, factor);
                }
            }
        }
        Ok(())
    }
}

/// Forward and backward, on the right side in `x`.
struct Substitution<'a>(&'a mut RealLu);

impl WithSimd for Substitution<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let RealLu { height, u, diagonal, l, pivot, x, .. } = self.0;
        let x = x.as_mut_slice();
        for (k, (column, &p)) in l.chunks_exact(*height).zip(&*pivot).enumerate() {
            x.swap(k, p);
            let factor = x[k];
            subtract(simd, &mut x[floor(k)..], &column[floor(k)..], factor);
        }
        for (k, (column, d)) in u.chunks_exact(*height).zip(&*diagonal).enumerate().rev() {
            let value = x[k] / d;
            let whole = padded(k);
            subtract(simd, &mut x[..whole], &column[..whole], value);
            x[k] = value;
        }
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
