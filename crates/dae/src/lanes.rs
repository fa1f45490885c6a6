//! Inner loops over whole registers, whose width is found at run time. Every lane is multiplied
//! and added on its own, without fused operations, so that all widths give the same bits.

use pulp::{Arch, Simd, WithSimd};

/// The widest register, in numbers; arrays are padded to it.
pub(crate) const LANES: usize = 4;

/// A count that fills whole registers.
pub(crate) fn padded(n: usize) -> usize {
    n.next_multiple_of(LANES)
}

/// Start of the register that holds entry `k`.
pub(crate) fn floor(k: usize) -> usize {
    k / LANES * LANES
}

/// Runs a kernel with the widest registers there are.
pub(crate) fn run<K: WithSimd>(kernel: K) -> K::Output {
    Arch::new().dispatch(kernel)
}

/// `x −= factor · l`; both padded, of the same length.
#[expect(clippy::inline_always, reason = "it must be compiled with the registers of its caller")]
#[inline(always)]
pub(crate) fn subtract<S: Simd>(simd: S, x: &mut [f64], l: &[f64], factor: f64) {
    let (x, l) = (S::as_mut_simd_f64s(x).0, S::as_simd_f64s(l).0);
    let factor = simd.splat_f64s(factor);
    for (x, &l) in x.iter_mut().zip(l) {
        *x = simd.sub_f64s(*x, simd.mul_f64s(factor, l));
    }
}

/// `x −= factor · l` for complex numbers, real and imaginary parts apart.
#[expect(clippy::inline_always, reason = "it must be compiled with the registers of its caller")]
#[inline(always)]
pub(crate) fn subtract_complex<S: Simd>(
    simd: S,
    (x_re, x_im): (&mut [f64], &mut [f64]),
    (l_re, l_im): (&[f64], &[f64]),
    (re, im): (f64, f64),
) {
    let x = S::as_mut_simd_f64s(x_re).0.iter_mut().zip(S::as_mut_simd_f64s(x_im).0);
    let l = S::as_simd_f64s(l_re).0.iter().zip(S::as_simd_f64s(l_im).0);
    let (re, im) = (simd.splat_f64s(re), simd.splat_f64s(im));
    for ((x_re, x_im), (&l_re, &l_im)) in x.zip(l) {
        *x_re = simd.sub_f64s(*x_re, simd.mul_f64s(re, l_re));
        *x_re = simd.add_f64s(*x_re, simd.mul_f64s(im, l_im));
        *x_im = simd.sub_f64s(*x_im, simd.mul_f64s(re, l_im));
        *x_im = simd.sub_f64s(*x_im, simd.mul_f64s(im, l_re));
    }
}
