//! Inner loops over whole registers, whose width is found at run time. Every lane is multiplied
//! and added on its own, without fused operations, so that all widths give the same bits.

#![expect(clippy::inline_always, reason = "kernels are compiled with the registers of `run`")]

use pulp::{Arch, Simd, WithSimd};

/// The widest register, in numbers.
pub(crate) const LANES: usize = 4;

/// Numbers that fill the widest register.
pub(crate) type Chunk = [f64; LANES];

/// Real parts, then imaginary parts.
pub(crate) type ComplexChunk = [Chunk; 2];

/// Chunks that hold `n` numbers.
pub(crate) fn chunks(n: usize) -> usize {
    n.div_ceil(LANES)
}

/// Runs a kernel with the widest registers there are.
pub(crate) fn run<K: WithSimd>(kernel: K) -> K::Output {
    Arch::new().dispatch(kernel)
}

/// `x −= f a + g b`, all of the same length.
#[inline(always)]
pub(crate) fn subtract<S: Simd>(
    simd: S,
    x: &mut [Chunk],
    (a, f): (&[Chunk], f64),
    (b, g): (&[Chunk], f64),
) {
    let (f, g) = (simd.splat_f64s(f), simd.splat_f64s(g));
    for ((x, a), b) in x.iter_mut().zip(a).zip(b) {
        let (a, b) = (S::as_simd_f64s(a).0, S::as_simd_f64s(b).0);
        for ((x, &a), &b) in S::as_mut_simd_f64s(x).0.iter_mut().zip(a).zip(b) {
            *x = simd.sub_f64s(*x, simd.mul_f64s(f, a));
            *x = simd.sub_f64s(*x, simd.mul_f64s(g, b));
        }
    }
}

/// `x −= f a + g b` for complex numbers, `f` and `g` as real and imaginary part.
#[inline(always)]
pub(crate) fn subtract_complex<S: Simd>(
    simd: S,
    x: &mut [ComplexChunk],
    (a, f): (&[ComplexChunk], (f64, f64)),
    (b, g): (&[ComplexChunk], (f64, f64)),
) {
    let splat = |z: (f64, f64)| (simd.splat_f64s(z.0), simd.splat_f64s(z.1));
    let (f, g) = (splat(f), splat(g));
    for (([x_re, x_im], a), b) in x.iter_mut().zip(a).zip(b) {
        let parts =
            |z: &ComplexChunk, k: usize| (S::as_simd_f64s(&z[0]).0[k], S::as_simd_f64s(&z[1]).0[k]);
        let (x_re, x_im) = (S::as_mut_simd_f64s(x_re).0, S::as_mut_simd_f64s(x_im).0);
        for k in 0..x_re.len() {
            let (mut re, mut im) = (x_re[k], x_im[k]);
            for (z, factor) in [(parts(a, k), f), (parts(b, k), g)] {
                re = simd.sub_f64s(re, simd.mul_f64s(factor.0, z.0));
                re = simd.add_f64s(re, simd.mul_f64s(factor.1, z.1));
                im = simd.sub_f64s(im, simd.mul_f64s(factor.0, z.1));
                im = simd.sub_f64s(im, simd.mul_f64s(factor.1, z.0));
            }
            (x_re[k], x_im[k]) = (re, im);
        }
    }
}

/// `out = (factor · m ⊗ I) x` for an `s × s` matrix `m` by rows and `s` vectors of length `n`, one
/// after the other; `s` is odd and at most seven.
pub(crate) fn multiply_blocks(m: &[f64], factor: f64, n: usize, x: &[f64], out: &mut [f64]) {
    match m.len() {
        1 => run(Blocks::<1> { m, factor, n, x, out }),
        9 => run(Blocks::<3> { m, factor, n, x, out }),
        25 => run(Blocks::<5> { m, factor, n, x, out }),
        49 => run(Blocks::<7> { m, factor, n, x, out }),
        entries => unreachable!("no method has a matrix of {entries} entries"),
    }
}

/// See [`multiply_blocks`]; sums stay in registers.
struct Blocks<'a, const S: usize> {
    m: &'a [f64],
    factor: f64,
    n: usize,
    x: &'a [f64],
    out: &'a mut [f64],
}

impl<const N: usize> WithSimd for Blocks<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { m, factor, n, x, out } = self;
        let x: [&[f64]; N] = std::array::from_fn(|j| &x[j * n..(j + 1) * n]);
        let wide = x.map(|x| S::as_simd_f64s(x).0);
        for (out, m) in out.chunks_exact_mut(n).zip(m.as_chunks::<N>().0) {
            let m = m.map(|m| factor * m);
            let (head, tail) = S::as_mut_simd_f64s(out);
            for (k, out) in head.iter_mut().enumerate() {
                let mut sum = simd.mul_f64s(simd.splat_f64s(m[0]), wide[0][k]);
                for j in 1..N {
                    sum = simd.add_f64s(sum, simd.mul_f64s(simd.splat_f64s(m[j]), wide[j][k]));
                }
                *out = sum;
            }
            let done = n - tail.len();
            for (k, out) in tail.iter_mut().enumerate() {
                let mut sum = m[0] * x[0][done + k];
                for j in 1..N {
                    sum += m[j] * x[j][done + k];
                }
                *out = sum;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_multiplied_for_every_number_of_stages_and_length() {
        for s in [1, 3, 5, 7] {
            for n in 1..11 {
                let m: Vec<f64> = (0..s * s).map(|k| (k as f64).sin()).collect();
                let x: Vec<f64> = (0..s * n).map(|k| (k as f64).cos()).collect();
                let mut out = vec![f64::NAN; s * n];
                multiply_blocks(&m, 2.0, n, &x, &mut out);
                for i in 0..s {
                    for k in 0..n {
                        let sum: f64 = (0..s).map(|j| 2.0 * m[i * s + j] * x[j * n + k]).sum();
                        assert!((out[i * n + k] - sum).abs() < 1e-14, "s = {s}, n = {n}");
                    }
                }
            }
        }
    }
}
