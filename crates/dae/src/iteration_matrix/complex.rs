//! Dense LU of complex matrices, as `dense`, with real and imaginary parts apart: products of
//! vectors by a number then become vector code, which pairs of numbers side by side do not.

use faer::c64;

use super::dense::{CHUNK, floor, padded, places};
use super::{DenseKernel, Scalar, Singular};
use crate::Pattern;

/// See [`super::dense::RealLu`]; every array twice.
pub(crate) struct ComplexLu {
    n: usize,
    height: usize,
    places: Vec<usize>,
    u: Parts,
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
            l: Parts::zeros(n * height),
            pivot: vec![0; n],
            x: Parts::zeros(height),
        }
    }

    fn factor(&mut self, values: &[c64]) -> Result<(), Singular> {
        self.u.re.fill(0.0);
        self.u.im.fill(0.0);
        for (&place, &value) in self.places.iter().zip(values) {
            self.u.set(place, value);
        }
        (0..self.n).try_for_each(|k| self.eliminate(k))
    }

    fn solve_in_place(&mut self, x: &mut [c64]) {
        let Self { n, height, .. } = *self;
        let b = &mut self.x;
        x.iter().enumerate().for_each(|(i, &x)| b.set(i, x));
        for k in 0..n {
            b.swap(k, self.pivot[k]);
            let factor = b.get(k);
            let column = k * height + floor(k)..(k + 1) * height;
            let x = (&mut b.re[floor(k)..], &mut b.im[floor(k)..]);
            subtract(x, (&self.l.re[column.clone()], &self.l.im[column]), factor);
        }
        for k in (0..n).rev() {
            let value = divide(b.get(k), self.u.get(k * height + k));
            let (whole, column) = (floor(k), k * height);
            let u = (&self.u.re[column..column + whole], &self.u.im[column..column + whole]);
            subtract((&mut b.re[..whole], &mut b.im[..whole]), u, value);
            for i in whole..k {
                let rest = b.get(i) - value * self.u.get(column + i);
                b.set(i, rest);
            }
            b.set(k, value);
        }
        x.iter_mut().enumerate().for_each(|(i, x)| *x = b.get(i));
    }
}

impl ComplexLu {
    fn eliminate(&mut self, k: usize) -> Result<(), Singular> {
        let (n, height) = (self.n, self.height);
        let at = k * height;
        let p = self.pivot_row(k)?;
        self.pivot[k] = p;
        self.u.swap(at + k, at + p);
        let pivot = self.u.get(at + k);
        for i in k + 1..n {
            self.l.set(at + i, divide(self.u.get(at + i), pivot));
        }

        let from = at + floor(k);
        let l = (&self.l.re[from..at + height], &self.l.im[from..at + height]);
        let right = self.u.re[at + height..].chunks_exact_mut(height);
        for (re, im) in right.zip(self.u.im[at + height..].chunks_exact_mut(height)) {
            re.swap(k, p);
            im.swap(k, p);
            let factor = c64::new(re[k], im[k]);
            if factor != c64::ZERO {
                subtract((&mut re[floor(k)..], &mut im[floor(k)..]), l, factor);
            }
        }
        Ok(())
    }

    /// The row, from `k` on, of the largest entry of column `k`.
    fn pivot_row(&self, k: usize) -> Result<usize, Singular> {
        let mut best = (k, 0.0);
        for row in k..self.n {
            let magnitude = self.u.get(k * self.height + row).magnitude();
            if !magnitude.is_finite() {
                return Err(Singular);
            }
            if magnitude > best.1 {
                best = (row, magnitude);
            }
        }
        if best.1 > 0.0 { Ok(best.0) } else { Err(Singular) }
    }
}

/// `a / b` by the product with the conjugate, which gives 1 exactly for equal numbers.
fn divide(a: c64, b: c64) -> c64 {
    let square = b.re * b.re + b.im * b.im;
    c64::new((a.re * b.re + a.im * b.im) / square, (a.im * b.re - a.re * b.im) / square)
}

/// `x −= factor · l`, in whole chunks.
fn subtract(x: (&mut [f64], &mut [f64]), l: (&[f64], &[f64]), factor: c64) {
    let x = x.0.as_chunks_mut::<CHUNK>().0.iter_mut().zip(x.1.as_chunks_mut::<CHUNK>().0);
    let l = l.0.as_chunks::<CHUNK>().0.iter().zip(l.1.as_chunks::<CHUNK>().0);
    for ((x_re, x_im), (l_re, l_im)) in x.zip(l) {
        for i in 0..CHUNK {
            x_re[i] -= factor.re * l_re[i] - factor.im * l_im[i];
            x_im[i] -= factor.re * l_im[i] + factor.im * l_re[i];
        }
    }
}
