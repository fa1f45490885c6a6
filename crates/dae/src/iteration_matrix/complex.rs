//! Dense LU of complex matrices, as `dense`, with real and imaginary parts apart: a product of a
//! vector by a number then fills registers, which pairs of numbers side by side do not.

use faer::c64;
use pulp::{Simd, WithSimd};

use super::dense::places;
use super::{DenseKernel, Scalar, Singular};
use crate::Pattern;
use crate::lanes::{self, floor, padded, subtract_complex};

/// See [`super::dense::RealLu`]; every array twice.
pub(crate) struct ComplexLu {
    n: usize,
    height: usize,
    places: Vec<usize>,
    u: Parts,
    diagonal: Vec<c64>,
    l: Parts,
    pivot: Vec<usize>,
    x: Parts,
}

/// Real and imaginary parts.
struct Parts {
    re: Vec<f64>,
    im: Vec<f64>,
}

impl Parts {
    fn zeros(n: usize) -> Self {
        Self { re: vec![0.0; n], im: vec![0.0; n] }
    }

    fn get(&self, i: usize) -> c64 {
        c64::new(self.re[i], self.im[i])
    }

    fn set(&mut self, i: usize, value: c64) {
        (self.re[i], self.im[i]) = (value.re, value.im);
    }

    fn swap(&mut self, i: usize, j: usize) {
        self.re.swap(i, j);
        self.im.swap(i, j);
    }

    fn fill(&mut self, range: std::ops::Range<usize>) {
        self.re[range.clone()].fill(0.0);
        self.im[range].fill(0.0);
    }
}

impl DenseKernel<c64> for ComplexLu {
    fn new(pattern: &Pattern) -> Self {
        let n = pattern.n();
        let height = padded(n);
        Self {
            n,
            height,
            places: places(pattern, height),
            u: Parts::zeros(n * height),
            diagonal: vec![c64::ZERO; n],
            l: Parts::zeros(n * height),
            pivot: vec![0; n],
            x: Parts::zeros(height),
        }
    }

    fn factor(&mut self, values: &[c64]) -> Result<(), Singular> {
        self.u.fill(0..self.n * self.height);
        for (&place, &value) in self.places.iter().zip(values) {
            self.u.set(place, value);
        }
        lanes::run(Elimination(self))
    }

    fn solve_in_place(&mut self, x: &mut [c64]) {
        x.iter().enumerate().for_each(|(i, &x)| self.x.set(i, x));
        lanes::run(Substitution(self));
        x.iter_mut().enumerate().for_each(|(i, x)| *x = self.x.get(i));
    }
}

/// Column after column: choose the pivot, divide, update the columns to the right.
struct Elimination<'a>(&'a mut ComplexLu);

impl WithSimd for Elimination<'_> {
    type Output = Result<(), Singular>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let ComplexLu { n, height, u, diagonal, l, pivot, .. } = self.0;
        let (n, height) = (*n, *height);
        for k in 0..n {
            let at = k * height;
            let p = pivot_row(&u.re[at..at + n], &u.im[at..at + n], k)?;
            pivot[k] = p;
            u.swap(at + k, at + p);
            diagonal[k] = u.get(at + k);
            for i in at + k + 1..at + n {
                l.set(i, divide(u.get(i), diagonal[k]));
            }
            u.fill(at + k..at + height);

            let first = floor(k);
            let column = at + first..at + height;
            let l = (&l.re[column.clone()], &l.im[column]);
            let right = u.re[at + height..].chunks_exact_mut(height);
            for (re, im) in right.zip(u.im[at + height..].chunks_exact_mut(height)) {
                re.swap(k, p);
                im.swap(k, p);
                let factor = (re[k], im[k]);
                if factor != (0.0, 0.0) {
                    subtract_complex(simd, (&mut re[first..], &mut im[first..]), l, factor);
                }
            }
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
        let ComplexLu { height, u, diagonal, l, pivot, x, .. } = self.0;
        let (re, im) = (x.re.as_mut_slice(), x.im.as_mut_slice());
        let columns = l.re.chunks_exact(*height).zip(l.im.chunks_exact(*height));
        for (k, ((l_re, l_im), &p)) in columns.zip(&*pivot).enumerate() {
            re.swap(k, p);
            im.swap(k, p);
            let (factor, first) = ((re[k], im[k]), floor(k));
            let x = (&mut re[first..], &mut im[first..]);
            subtract_complex(simd, x, (&l_re[first..], &l_im[first..]), factor);
        }
        let columns = u.re.chunks_exact(*height).zip(u.im.chunks_exact(*height));
        for (k, ((u_re, u_im), &d)) in columns.zip(&*diagonal).enumerate().rev() {
            let value = divide(c64::new(re[k], im[k]), d);
            let whole = padded(k);
            let x = (&mut re[..whole], &mut im[..whole]);
            subtract_complex(simd, x, (&u_re[..whole], &u_im[..whole]), (value.re, value.im));
            (re[k], im[k]) = (value.re, value.im);
        }
    }
}

/// The row, from `k` on, of the largest entry of a column.
fn pivot_row(re: &[f64], im: &[f64], k: usize) -> Result<usize, Singular> {
    let mut best = (k, 0.0);
    for (row, (&re, &im)) in re.iter().zip(im).enumerate().skip(k) {
        let magnitude = c64::new(re, im).magnitude();
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
