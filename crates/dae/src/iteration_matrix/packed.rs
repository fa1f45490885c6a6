//! Columns in chunks of a register's width: of real numbers, and of complex ones with real and
//! imaginary parts apart. A product of such a column by a number fills registers, which pairs of
//! numbers side by side do not.

#![expect(clippy::inline_always, reason = "kernels are compiled with the registers of `run`")]

use std::ops::Range;

use faer::c64;
use pulp::Simd;

use super::Scalar;
use crate::lanes::{Chunk, ComplexChunk, LANES, subtract, subtract_complex};

/// The chunks of a column, and arithmetic on them.
pub(crate) trait Column: 'static + Copy {
    /// Numbers that fill the widest register.
    type Chunk: Copy;
    /// A chunk of zeros.
    const ZEROS: Self::Chunk;

    /// Entry `i` of a column.
    fn get(column: &[Self::Chunk], i: usize) -> Self;

    /// Overwrites entry `i` of a column.
    fn set(self, column: &mut [Self::Chunk], i: usize);

    /// `self / b`, which is 1 exactly for equal numbers.
    fn divide(self, b: Self) -> Self;

    /// [`Column::divide`] for a chunk of numbers.
    fn divide_chunk(chunk: &Self::Chunk, b: Self) -> Self::Chunk;

    /// `x −= f a + g b`, all columns of the same length.
    fn subtract<S: Simd>(
        simd: S,
        x: &mut [Self::Chunk],
        a: (&[Self::Chunk], Self),
        b: (&[Self::Chunk], Self),
    );
}

impl Column for f64 {
    type Chunk = Chunk;
    const ZEROS: Chunk = [0.0; LANES];

    #[inline(always)]
    fn get(column: &[Chunk], i: usize) -> Self {
        column.as_flattened()[i]
    }

    #[inline(always)]
    fn set(self, column: &mut [Chunk], i: usize) {
        column.as_flattened_mut()[i] = self;
    }

    #[inline(always)]
    fn divide(self, b: Self) -> Self {
        self / b
    }

    #[inline(always)]
    fn divide_chunk(chunk: &Chunk, b: Self) -> Chunk {
        chunk.map(|a| a / b)
    }

    #[inline(always)]
    fn subtract<S: Simd>(simd: S, x: &mut [Chunk], a: (&[Chunk], Self), b: (&[Chunk], Self)) {
        subtract(simd, x, a, b);
    }
}

impl Column for c64 {
    type Chunk = ComplexChunk;
    const ZEROS: ComplexChunk = [[0.0; LANES]; 2];

    #[inline(always)]
    fn get(column: &[ComplexChunk], i: usize) -> Self {
        let [re, im] = &column[i / LANES];
        c64::new(re[i % LANES], im[i % LANES])
    }

    #[inline(always)]
    fn set(self, column: &mut [ComplexChunk], i: usize) {
        let [re, im] = &mut column[i / LANES];
        (re[i % LANES], im[i % LANES]) = (self.re, self.im);
    }

    /// By the product with the conjugate.
    #[inline(always)]
    fn divide(self, b: Self) -> Self {
        let square = b.re * b.re + b.im * b.im;
        let re = (self.re * b.re + self.im * b.im) / square;
        c64::new(re, (self.im * b.re - self.re * b.im) / square)
    }

    #[inline(always)]
    fn divide_chunk([re, im]: &ComplexChunk, b: Self) -> ComplexChunk {
        let square = b.re * b.re + b.im * b.im;
        let real = std::array::from_fn(|i| (re[i] * b.re + im[i] * b.im) / square);
        let imaginary = std::array::from_fn(|i| (im[i] * b.re - re[i] * b.im) / square);
        [real, imaginary]
    }

    #[inline(always)]
    fn subtract<S: Simd>(
        simd: S,
        x: &mut [ComplexChunk],
        (a, f): (&[ComplexChunk], Self),
        (b, g): (&[ComplexChunk], Self),
    ) {
        subtract_complex(simd, x, (a, (f.re, f.im)), (b, (g.re, g.im)));
    }
}

/// Exchanges two entries of a column.
#[inline(always)]
pub(super) fn swap<T: Column>(column: &mut [T::Chunk], i: usize, k: usize) {
    let (a, b) = (T::get(column, i), T::get(column, k));
    b.set(column, i);
    a.set(column, k);
}

/// Sets some entries of a column to zero, whole chunks at once.
#[inline(always)]
pub(super) fn clear<T: Scalar>(column: &mut [T::Chunk], entries: Range<usize>) {
    let whole = entries.start.div_ceil(LANES)..entries.end / LANES;
    if whole.start >= whole.end {
        entries.for_each(|i| T::ZERO.set(column, i));
        return;
    }
    (entries.start..whole.start * LANES).for_each(|i| T::ZERO.set(column, i));
    (whole.end * LANES..entries.end).for_each(|i| T::ZERO.set(column, i));
    column[whole].fill(T::ZEROS);
}
