//! Sums over the derivatives of the stages, in registers.
//!
//! Unknowns come in blocks as wide as the widest registers; the last block is filled up with zeros. Every
//! unknown is summed by itself in the order of the terms, so that no bit depends on the width of registers.

#![expect(clippy::inline_always, reason = "kernels are compiled with the registers of `run`")]

use pulp::{Simd, WithSimd};

use super::coefficients::Term;
use crate::lanes::run;

/// Unknowns of a block.
pub(super) const WIDTH: usize = 8;

pub(super) type Block = [f64; WIDTH];

/// A number for every unknown, or several such columns, in blocks.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    blocks: Vec<Block>,
    n: usize,
    /// Blocks of a column.
    n_blocks: usize,
}

impl Columns {
    pub(super) fn new(n: usize, n_columns: usize) -> Self {
        let n_blocks = n.div_ceil(WIDTH);
        Self { blocks: vec![[0.0; WIDTH]; n_columns * n_blocks], n, n_blocks }
    }

    /// The numbers of a column.
    pub(super) fn column(&self, j: usize) -> &[f64] {
        &self.blocks[j * self.n_blocks..].as_flattened()[..self.n]
    }

    /// Column to be overwritten.
    pub(super) fn column_mut(&mut self, j: usize) -> &mut [f64] {
        &mut self.blocks[j * self.n_blocks..].as_flattened_mut()[..self.n]
    }

    /// The numbers of the only column.
    pub(super) fn values(&self) -> &[f64] {
        self.column(0)
    }

    /// Values to be overwritten.
    pub(super) fn values_mut(&mut self) -> &mut [f64] {
        self.column_mut(0)
    }
}

/// `out = y + h Σ factor_j k_j`; without `y`, the sum alone. A row has terms.
pub(super) fn combine(h: f64, row: &[Term], k: &Columns, y: Option<&Columns>, out: &mut Columns) {
    run(Combine { h, row, k, y, out });
}

struct Combine<'a> {
    h: f64,
    row: &'a [Term],
    k: &'a Columns,
    y: Option<&'a Columns>,
    out: &'a mut Columns,
}

impl WithSimd for Combine<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { h, row, k, y, out } = self;
        let Some((&(first, first_factor), others)) = row.split_first() else { return };
        for (b, out) in out.blocks.iter_mut().enumerate() {
            let block = |j: usize| &k.blocks[j * k.n_blocks + b];
            let (factor, k) = (h * first_factor, block(first));
            let mut sum = [0.0; WIDTH];
            for lane in 0..WIDTH {
                sum[lane] = factor * k[lane];
            }
            for &(j, factor) in others {
                let (factor, k) = (h * factor, block(j));
                for lane in 0..WIDTH {
                    sum[lane] += factor * k[lane];
                }
            }
            if let Some(y) = y {
                let y = &y.blocks[b];
                for lane in 0..WIDTH {
                    sum[lane] += y[lane];
                }
            }
            *out = sum;
        }
    }
}
