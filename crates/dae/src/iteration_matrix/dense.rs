//! Dense LU of real matrices, `P A = L U`, column after column.
//!
//! Columns are kept in chunks of a register's width; those of `L` hold zeros down to the diagonal,
//! those of `U` from there on, so that every inner loop runs over whole chunks. Two columns are
//! subtracted at a time, which halves the traffic of the third.

#![expect(clippy::inline_always, reason = "kernels are compiled with the registers of `run`")]

use pulp::{Simd, WithSimd};

use super::{DenseKernel, Singular};
use crate::lanes::{self, Chunk, LANES, chunks, subtract};
use crate::system::Pattern;

/// See the module.
pub(crate) struct RealLu {
    n: usize,
    /// Chunks of a column.
    height: usize,
    /// Where the entries of the pattern lie.
    places: Vec<usize>,
    /// The matrix, then `U` above the diagonal, zero elsewhere.
    u: Vec<Chunk>,
    diagonal: Vec<f64>,
    /// `L` below the diagonal, zero elsewhere.
    l: Vec<Chunk>,
    /// Row exchanged with row `k` at elimination step `k`.
    pivot: Vec<usize>,
    /// Original row of each row of `P A`.
    row: Vec<usize>,
    x: Vec<Chunk>,
}

/// Where the entries of a pattern lie in columns of so many chunks.
pub(super) fn places(pattern: &Pattern, height: usize) -> Vec<usize> {
    pattern.entries().map(|(row, col)| col * height * LANES + row).collect()
}

impl DenseKernel<f64> for RealLu {
    fn new(pattern: &Pattern) -> Self {
        let n = pattern.n();
        let height = chunks(n);
        let zeros = |columns: usize| vec![[0.0; LANES]; columns * height];
        Self {
            n,
            height,
            places: places(pattern, height),
            u: zeros(n),
            diagonal: vec![0.0; n],
            l: zeros(n),
            pivot: vec![0; n],
            row: vec![0; n],
            x: zeros(1),
        }
    }

    fn factor(&mut self, values: &[f64]) -> Result<(), Singular> {
        let u = self.u.as_flattened_mut();
        u.fill(0.0);
        for (&place, &value) in self.places.iter().zip(values) {
            u[place] = value;
        }
        self.row.iter_mut().enumerate().for_each(|(i, row)| *row = i);
        lanes::run(Elimination(self))
    }

    fn solve_in_place(&mut self, x: &mut [f64]) {
        for (own, &row) in self.x.as_flattened_mut().iter_mut().zip(&self.row) {
            *own = x[row];
        }
        lanes::run(Substitution(self));
        x.copy_from_slice(&self.x.as_flattened()[..self.n]);
    }
}

struct Elimination<'a>(&'a mut RealLu);

impl WithSimd for Elimination<'_> {
    type Output = Result<(), Singular>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let RealLu { n, height, u, diagonal, l, pivot, row, .. } = self.0;
        let (n, height) = (*n, *height);
        for (k, column) in u.chunks_exact_mut(height).enumerate() {
            // What was done to the columns before.
            let numbers = column.as_flattened_mut();
            for (i, &p) in pivot[..k].iter().enumerate() {
                numbers.swap(i, p);
            }
            forward(simd, &l[..k * height], column);

            // The largest entry becomes the pivot, its row changes places.
            let numbers = column.as_flattened_mut();
            let p = pivot_row(&numbers[..n], k)?;
            pivot[k] = p;
            if p != k {
                numbers.swap(k, p);
                row.swap(k, p);
                for done in l[..k * height].chunks_exact_mut(height) {
                    done.as_flattened_mut().swap(k, p);
                }
            }

            // Dividing, where multiplying by the inverse is faster, eliminates equal rows exactly:
            // a repeated equation then leaves a zero, not a rounding error, to be found as pivot.
            let divisor = numbers[k];
            diagonal[k] = divisor;
            let first = k / LANES;
            let l = &mut l[k * height..(k + 1) * height];
            for (l, value) in l[first..].iter_mut().zip(&column[first..]) {
                *l = value.map(|x| x / divisor);
            }
            l.as_flattened_mut()[first * LANES..=k].fill(0.0);
            column.as_flattened_mut()[k..].fill(0.0);
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
        let RealLu { n, height, u, diagonal, l, x, .. } = self.0;
        forward(simd, l, x);
        let mut left = *n;
        while left >= 2 {
            // The last two unknowns that are left, then what they do to those above.
            let (i, k) = (left - 2, left - 1);
            let [a, b] = [k, i].map(|k| &u[k * *height..(k + 1) * *height]);
            let numbers = x.as_flattened_mut();
            let second = numbers[k] / diagonal[k];
            let first = (numbers[i] - second * a.as_flattened()[i]) / diagonal[i];
            let whole = ..chunks(i);
            subtract(simd, &mut x[whole], (&a[whole], second), (&b[whole], first));
            let numbers = x.as_flattened_mut();
            (numbers[i], numbers[k]) = (first, second);
            left -= 2;
        }
        if left == 1 {
            x[0][0] /= diagonal[0];
        }
    }
}

/// Solves with the first columns of `L`, as many as `l` holds.
#[inline(always)]
fn forward<S: Simd>(simd: S, l: &[Chunk], x: &mut [Chunk]) {
    let height = x.len();
    let pairs = l.chunks_exact(2 * height);
    let rest = pairs.remainder();
    for (i, pair) in pairs.enumerate() {
        let k = 2 * i;
        let (a, b) = pair.split_at(height);
        let numbers = x.as_flattened();
        let f = numbers[k];
        let g = numbers[k + 1] - f * a.as_flattened()[k + 1];
        let whole = k / LANES..;
        subtract(simd, &mut x[whole.clone()], (&a[whole.clone()], f), (&b[whole], g));
    }
    if !rest.is_empty() {
        let k = l.len() / height - 1;
        let whole = k / LANES..;
        let f = x.as_flattened()[k];
        subtract(simd, &mut x[whole.clone()], (&rest[whole.clone()], f), (&rest[whole], 0.0));
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
