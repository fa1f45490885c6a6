//! Dense LU of real and complex matrices, `P A = L U`, column after column.
//!
//! Columns are kept in chunks of a register's width; those of `L` hold zeros down to the diagonal,
//! those of `U` from there on, so that every inner loop runs over whole chunks. Two columns are
//! subtracted at a time, which halves the traffic of the third.
//!
//! For the sizes of single mechanisms this is faster than a blocked library kernel, and it sees a
//! vanishing pivot when it meets one.

#![expect(clippy::inline_always, reason = "kernels are compiled with the registers of `run`")]

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::packed::{clear, swap};
use super::{Scalar, Singular};
use crate::lanes::{LANES, chunks, run};
use crate::system::Pattern;

/// One dense matrix and its factors; the buffers are allocated once.
pub(super) struct DenseLu<T: Scalar> {
    n: usize,
    /// Chunks of a column.
    height: usize,
    /// First chunk of the column, and the row, of the pattern's entries.
    entries: Vec<(usize, usize)>,
    /// The matrix, then `U` above the diagonal, zero elsewhere.
    u: Vec<T::Chunk>,
    diagonal: Vec<T>,
    /// `L` below the diagonal, zero elsewhere.
    l: Vec<T::Chunk>,
    /// Row exchanged with row `k` at elimination step `k`.
    pivot: Vec<usize>,
    /// Original row of each row of `P A`.
    row: Vec<usize>,
    x: Vec<T::Chunk>,
}

impl<T: Scalar> DenseLu<T> {
    /// For matrices with the given pattern.
    pub(super) fn new(pattern: &Pattern) -> Self {
        let n = pattern.n();
        let height = chunks(n);
        let zeros = |columns: usize| vec![T::ZEROS; columns * height];
        Self {
            n,
            height,
            entries: pattern.entries().map(|(row, col)| (col * height, row)).collect(),
            u: zeros(n),
            diagonal: vec![T::ZERO; n],
            l: zeros(n),
            pivot: vec![0; n],
            row: vec![0; n],
            x: zeros(1),
        }
    }

    /// Factors the matrix whose `values` follow the entries of the pattern.
    pub(super) fn factor(&mut self, values: &[T]) -> Result<(), Singular> {
        self.u.fill(T::ZEROS);
        for (&(column, row), &value) in self.entries.iter().zip(values) {
            value.set(&mut self.u[column..], row);
        }
        self.row.iter_mut().enumerate().for_each(|(i, row)| *row = i);
        run(Factorisation(self))
    }

    /// Only valid after a successful [`DenseLu::factor`].
    pub(super) fn solve_in_place(&mut self, x: &mut [T]) {
        for (i, &row) in self.row.iter().enumerate() {
            x[row].set(&mut self.x, i);
        }
        run(Substitution(self));
        x.iter_mut().enumerate().for_each(|(i, x)| *x = T::get(&self.x, i));
    }
}

struct Factorisation<'a, T: Scalar>(&'a mut DenseLu<T>);

impl<T: Scalar> WithSimd for Factorisation<'_, T> {
    type Output = Result<(), Singular>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let DenseLu { n, height, u, diagonal, l, pivot, row, .. } = self.0;
        let (n, height) = (*n, *height);
        for (k, column) in u.chunks_exact_mut(height).enumerate() {
            // The exchanges and subtractions of the columns before.
            for (i, &p) in pivot[..k].iter().enumerate() {
                if p != i {
                    swap::<T>(column, i, p);
                }
            }
            forward::<T, S>(simd, &l[..k * height], column);

            // The largest entry becomes the pivot, its row changes places with row k.
            let p = pivot_row::<T>(column, k..n)?;
            pivot[k] = p;
            if p != k {
                swap::<T>(column, k, p);
                row.swap(k, p);
                l[..k * height].chunks_exact_mut(height).for_each(|done| swap::<T>(done, k, p));
            }

            // Dividing, where multiplying by the inverse is faster, eliminates equal rows exactly:
            // a repeated equation then leaves a zero, not a rounding error, to be found as pivot.
            let divisor = T::get(column, k);
            diagonal[k] = divisor;
            let first = k / LANES;
            let l = &mut l[k * height..(k + 1) * height];
            for (l, value) in l[first..].iter_mut().zip(&column[first..]) {
                *l = T::divide_chunk(value, divisor);
            }
            clear::<T>(l, first * LANES..k + 1);
            clear::<T>(column, k..height * LANES);
        }
        Ok(())
    }
}

/// Forward and backward, on the right side in `x`.
struct Substitution<'a, T: Scalar>(&'a mut DenseLu<T>);

impl<T: Scalar> WithSimd for Substitution<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let DenseLu { n, height, u, diagonal, l, x, .. } = self.0;
        forward::<T, S>(simd, l, x);
        let mut left = *n;
        while left >= 2 {
            // The last two unknowns that are left, then their part in those above.
            let (i, k) = (left - 2, left - 1);
            let [a, b] = [k, i].map(|k| &u[k * *height..(k + 1) * *height]);
            let second = T::get(x, k).divide(diagonal[k]);
            let first = (T::get(x, i) - second * T::get(a, i)).divide(diagonal[i]);
            let whole = ..chunks(i);
            T::subtract(simd, &mut x[whole], (&a[whole], second), (&b[whole], first));
            first.set(x, i);
            second.set(x, k);
            left -= 2;
        }
        if left == 1 {
            T::get(x, 0).divide(diagonal[0]).set(x, 0);
        }
    }
}

/// Solves with the first columns of `L`, as many as `l` holds.
#[inline(always)]
fn forward<T: Scalar, S: Simd>(simd: S, l: &[T::Chunk], x: &mut [T::Chunk]) {
    let height = x.len();
    let pairs = l.chunks_exact(2 * height);
    let rest = pairs.remainder();
    for (i, pair) in pairs.enumerate() {
        let k = 2 * i;
        let (a, b) = pair.split_at(height);
        let f = T::get(x, k);
        let g = T::get(x, k + 1) - f * T::get(a, k + 1);
        let whole = k / LANES..;
        T::subtract(simd, &mut x[whole.clone()], (&a[whole.clone()], f), (&b[whole], g));
    }
    if !rest.is_empty() {
        let k = l.len() / height - 1;
        let whole = k / LANES..;
        let f = T::get(x, k);
        let rest = &rest[whole.clone()];
        T::subtract(simd, &mut x[whole], (rest, f), (rest, T::ZERO));
    }
}

/// The row of the largest entry of a column among some rows.
#[inline(always)]
fn pivot_row<T: Scalar>(column: &[T::Chunk], rows: Range<usize>) -> Result<usize, Singular> {
    let mut best = (rows.start, 0.0);
    for row in rows {
        let magnitude = T::get(column, row).magnitude();
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
