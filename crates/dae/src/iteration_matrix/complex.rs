//! Dense LU of complex matrices, as `dense`, with real and imaginary parts apart: a product of a
//! vector by a number then fills registers, which pairs of numbers side by side do not.

#![expect(clippy::inline_always, reason = "kernels are compiled with the registers of `run`")]

use faer::c64;
use pulp::{Simd, WithSimd};

use super::{DenseKernel, Scalar, Singular};
use crate::lanes::{self, ComplexChunk, LANES, chunks, subtract_complex};
use crate::system::Pattern;

/// See [`super::dense::RealLu`].
pub(crate) struct ComplexLu {
    n: usize,
    height: usize,
    /// Chunk and place within it of the pattern's entries.
    places: Vec<(usize, usize)>,
    u: Vec<ComplexChunk>,
    diagonal: Vec<c64>,
    l: Vec<ComplexChunk>,
    pivot: Vec<usize>,
    row: Vec<usize>,
    x: Vec<ComplexChunk>,
}

const ZEROS: ComplexChunk = [[0.0; LANES]; 2];

/// Entry `i` of a column.
fn get(x: &[ComplexChunk], i: usize) -> c64 {
    let [re, im] = &x[i / LANES];
    c64::new(re[i % LANES], im[i % LANES])
}

fn set(x: &mut [ComplexChunk], i: usize, value: c64) {
    let [re, im] = &mut x[i / LANES];
    (re[i % LANES], im[i % LANES]) = (value.re, value.im);
}

fn swap(x: &mut [ComplexChunk], i: usize, k: usize) {
    let (a, b) = (get(x, i), get(x, k));
    set(x, i, b);
    set(x, k, a);
}

impl DenseKernel<c64> for ComplexLu {
    fn new(pattern: &Pattern) -> Self {
        let n = pattern.n();
        let height = chunks(n);
        let place = |(row, col): (usize, usize)| (col * height + row / LANES, row % LANES);
        Self {
            n,
            height,
            places: pattern.entries().map(place).collect(),
            u: vec![ZEROS; n * height],
            diagonal: vec![c64::ZERO; n],
            l: vec![ZEROS; n * height],
            pivot: vec![0; n],
            row: vec![0; n],
            x: vec![ZEROS; height],
        }
    }

    fn factor(&mut self, values: &[c64]) -> Result<(), Singular> {
        self.u.fill(ZEROS);
        for (&(chunk, k), &value) in self.places.iter().zip(values) {
            let [re, im] = &mut self.u[chunk];
            (re[k], im[k]) = (value.re, value.im);
        }
        self.row.iter_mut().enumerate().for_each(|(i, row)| *row = i);
        lanes::run(Elimination(self))
    }

    fn solve_in_place(&mut self, x: &mut [c64]) {
        for (i, &row) in self.row.iter().enumerate() {
            set(&mut self.x, i, x[row]);
        }
        lanes::run(Substitution(self));
        x.iter_mut().enumerate().for_each(|(i, x)| *x = get(&self.x, i));
    }
}

struct Elimination<'a>(&'a mut ComplexLu);

impl WithSimd for Elimination<'_> {
    type Output = Result<(), Singular>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let ComplexLu { n, height, u, diagonal, l, pivot, row, .. } = self.0;
        let (n, height) = (*n, *height);
        for (k, column) in u.chunks_exact_mut(height).enumerate() {
            for (i, &p) in pivot[..k].iter().enumerate() {
                if p != i {
                    swap(column, i, p);
                }
            }
            forward(simd, &l[..k * height], column);

            let p = pivot_row(column, k, n)?;
            pivot[k] = p;
            if p != k {
                swap(column, k, p);
                row.swap(k, p);
                l[..k * height].chunks_exact_mut(height).for_each(|done| swap(done, k, p));
            }

            let divisor = get(column, k);
            diagonal[k] = divisor;
            let first = k / LANES;
            let l = &mut l[k * height..(k + 1) * height];
            for (l, value) in l[first..].iter_mut().zip(&column[first..]) {
                *l = divide_chunk(value, divisor);
            }
            (first * LANES..=k).for_each(|i| set(l, i, c64::ZERO));
            (k..height * LANES).for_each(|i| set(column, i, c64::ZERO));
        }
        Ok(())
    }
}

/// Forward and backward, on the right side in `x`.
struct Substitution<'a>(&'a mut ComplexLu);

impl WithSimd for Substitution<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let ComplexLu { n, height, u, diagonal, l, x, .. } = self.0;
        forward(simd, l, x);
        let mut left = *n;
        while left >= 2 {
            let (i, k) = (left - 2, left - 1);
            let [a, b] = [k, i].map(|k| &u[k * *height..(k + 1) * *height]);
            let second = divide(get(x, k), diagonal[k]);
            let first = divide(get(x, i) - second * get(a, i), diagonal[i]);
            let whole = ..chunks(i);
            let (f, g) = ((second.re, second.im), (first.re, first.im));
            subtract_complex(simd, &mut x[whole], (&a[whole], f), (&b[whole], g));
            set(x, i, first);
            set(x, k, second);
            left -= 2;
        }
        if left == 1 {
            let first = divide(get(x, 0), diagonal[0]);
            set(x, 0, first);
        }
    }
}

/// Solves with the first columns of `L`, as many as `l` holds.
#[inline(always)]
fn forward<S: Simd>(simd: S, l: &[ComplexChunk], x: &mut [ComplexChunk]) {
    let height = x.len();
    let pairs = l.chunks_exact(2 * height);
    let rest = pairs.remainder();
    for (i, pair) in pairs.enumerate() {
        let k = 2 * i;
        let (a, b) = pair.split_at(height);
        let f = get(x, k);
        let g = get(x, k + 1) - f * get(a, k + 1);
        let whole = k / LANES..;
        let (a, b) = (&a[whole.clone()], &b[whole.clone()]);
        subtract_complex(simd, &mut x[whole], (a, (f.re, f.im)), (b, (g.re, g.im)));
    }
    if !rest.is_empty() {
        let k = l.len() / height - 1;
        let whole = k / LANES..;
        let f = get(x, k);
        let rest = &rest[whole.clone()];
        subtract_complex(simd, &mut x[whole], (rest, (f.re, f.im)), (rest, (0.0, 0.0)));
    }
}

/// The row, from `k` on, of the largest of the `n` entries of a column.
fn pivot_row(column: &[ComplexChunk], k: usize, n: usize) -> Result<usize, Singular> {
    let mut best = (k, 0.0);
    for row in k..n {
        let magnitude = get(column, row).magnitude();
        if !magnitude.is_finite() {
            return Err(Singular);
        }
        if magnitude > best.1 {
            best = (row, magnitude);
        }
    }
    if best.1 > 0.0 { Ok(best.0) } else { Err(Singular) }
}

/// `a / b` by the product with the conjugate, which gives 1 exactly for equal numbers.
fn divide(a: c64, b: c64) -> c64 {
    let square = b.re * b.re + b.im * b.im;
    c64::new((a.re * b.re + a.im * b.im) / square, (a.im * b.re - a.re * b.im) / square)
}

/// As [`divide`], for a chunk of numbers.
fn divide_chunk([re, im]: &ComplexChunk, b: c64) -> ComplexChunk {
    let square = b.re * b.re + b.im * b.im;
    let real = std::array::from_fn(|i| (re[i] * b.re + im[i] * b.im) / square);
    let imaginary = std::array::from_fn(|i| (im[i] * b.re - re[i] * b.im) / square);
    [real, imaginary]
}
