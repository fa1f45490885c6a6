//! Exponential, logarithm and hyperbolic tangent of numbers in SIMD lanes.
//!
//! ```text
//! e^x      2^k e^r                 x = k ln 2 + r,   |r| ≤ ½ ln 2,   e^r = 1 + r + r² E(r)
//! ln x     k ln 2 + ln(1 + f)      x = 2^k (1 + f),  √½ ≤ 1 + f < √2
//!          ln(1 + f) = f − f²/2 + s (f²/2 + s² L(s²)),   s = f/(2 + f)
//! tanh x   m/(m + 2)               m = e^(2x) − 1
//! ```
//!
//! The argument of the exponential is reduced with ln 2 in two parts (W. J. Cody and W. Waite, *Software manual for the
//! elementary functions*, 1980, ch. 6); the logarithm in s is that of fdlibm (K. C. Ng, Sun Microsystems, 1993). E and L are
//! minimax polynomials by the exchange algorithm of E. Ya. Remez (1934). The first two terms of every sum keep their
//! rounding error, so that results are within 0.65 units in the last place, those of tanh within 0.85.
//!
//! Every lane goes through the same operations, none of them fused, so that neither the number of lanes nor the
//! instruction set changes a bit of any result. Where a lane overflows, underflows or has no value, all are computed
//! again, one by one, by what needs more operations.
//!
//! Measured in batches that are interpreted with AVX2, in ns per point: exp 2.6, ln 3.2, tanh 5.9 and arctangents of two
//! numbers 4.4, where `std` takes 6.0, 5.1, 13 and 16. One number alone takes longer than by `std`, up to 9 ns in machine
//! code and 20 interpreted: there are no tables, which lanes would have to gather.

#![expect(clippy::inline_always, reason = "the caller's instruction set must reach every loop")]

use std::f64::consts::LOG2_E;

/// Adding 1.5 · 2⁵² rounds to an integer and leaves it in the lowest bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// Bits of the fraction, below those of the exponent.
const FRACTION_BITS: u32 = 52;

/// ln 2 = the sum of these; 40 bits in the first, so that its products with k are exact.
const LN_2: [f64; 2] = [0.693_147_180_559_208_2, 7.371_002_565_167_799e-13];

/// E(r), by 2⁻⁶¹ on |r| ≤ ½ ln 2.
const E: [f64; 11] = [
    0.5,
    0.166_666_666_666_666_7,
    4.166_666_666_666_668_5e-2,
    8.333_333_333_326_112e-3,
    1.388_888_888_887_436e-3,
    1.984_126_987_490_295_8e-4,
    2.480_158_734_743_662_6e-5,
    2.755_725_529_591_766e-6,
    2.755_725_281_711_194e-7,
    2.510_526_033_698_549e-8,
    2.092_162_198_506_651_8e-9,
];

/// L(s²), by 2⁻⁵⁸ of ln(1 + f).
const L: [f64; 7] = [
    0.666_666_666_666_673_5,
    0.399_999_999_994_128_7,
    0.285_714_287_428_276_65,
    0.222_221_985_243_421_85,
    0.181_835_670_446_678_37,
    0.153_139_766_200_890_3,
    0.147_967_313_584_243_73,
];

/// Largest exponent that neither overflows nor leaves fewer than 53 bits.
const LARGEST_EXPONENT: f64 = 708.0;

/// e^x.
pub(crate) fn exp(x: f64) -> f64 {
    if has_normal_exp(x) { normal_exp(x) } else { extreme_exp(x) }
}

/// Exponentials of `N` numbers.
#[inline(always)]
pub(crate) fn exp_lanes<const N: usize>(x: [f64; N]) -> [f64; N] {
    in_lanes(x, has_normal_exp, normal_exp, exp)
}

/// The natural logarithm.
pub(crate) fn ln(x: f64) -> f64 {
    if is_moderate(x) { moderate_ln(x) } else { extreme_ln(x) }
}

/// Logarithms of `N` numbers.
#[inline(always)]
pub(crate) fn ln_lanes<const N: usize>(x: [f64; N]) -> [f64; N] {
    in_lanes(x, is_moderate, moderate_ln, ln)
}

/// The hyperbolic tangent.
pub(crate) fn tanh(x: f64) -> f64 {
    tanh_of(x)
}

/// Hyperbolic tangents of `N` numbers.
#[inline(always)]
pub(crate) fn tanh_lanes<const N: usize>(x: [f64; N]) -> [f64; N] {
    let mut out = [0.0; N];
    for lane in 0..N {
        out[lane] = tanh_of(x[lane]);
    }
    out
}

/// `usual` in all lanes, or `any` one by one where one of them is not usual.
#[inline(always)]
fn in_lanes<const N: usize>(
    x: [f64; N],
    is_usual: impl Fn(f64) -> bool,
    usual: impl Fn(f64) -> f64,
    any: fn(f64) -> f64,
) -> [f64; N] {
    let mut out = [0.0; N];
    for lane in 0..N {
        out[lane] = usual(x[lane]);
    }
    let are_usual = x.iter().fold(true, |all, &x| all & is_usual(x));
    if are_usual { out } else { one_by_one(x, any) }
}

#[cold]
#[inline(never)]
fn one_by_one<const N: usize>(x: [f64; N], function: fn(f64) -> f64) -> [f64; N] {
    x.map(function)
}

/// x = k ln 2 + `hi` − lo, and e^(hi − lo) = 1 + `hi` + `rest`.
struct Reduced {
    /// k in its lowest bits.
    rounded: f64,
    hi: f64,
    rest: f64,
}

#[inline(always)]
fn reduced(x: f64) -> Reduced {
    let rounded = x * LOG2_E + ROUND;
    let k = rounded - ROUND;
    let (hi, lo) = (x - k * LN_2[0], k * LN_2[1]);
    let r = hi - lo;
    Reduced { rounded, hi, rest: r * r * polynomial(&E, r) - lo }
}

impl Reduced {
    /// e^(hi − lo), with the rounding error of the sum's first terms.
    #[inline(always)]
    fn exp(&self) -> f64 {
        let sum = 1.0 + self.hi;
        sum + ((self.hi - (sum - 1.0)) + self.rest)
    }
}

#[inline(always)]
fn has_normal_exp(x: f64) -> bool {
    x.abs() <= LARGEST_EXPONENT
}

#[inline(always)]
fn normal_exp(x: f64) -> f64 {
    let reduced = reduced(x);
    let k = reduced.rounded.to_bits() << FRACTION_BITS;
    f64::from_bits(reduced.exp().to_bits().wrapping_add(k))
}

/// Exponentials near the ends of the numbers, or beyond them.
#[cold]
fn extreme_exp(x: f64) -> f64 {
    if x.is_nan() {
        return x;
    }
    // Beyond these everything is 0 or infinite.
    let reduced = reduced(x.clamp(-746.0, 710.0));
    #[expect(clippy::cast_possible_truncation, reason = "an integer of at most 1077")]
    let k = (reduced.rounded - ROUND) as i32;
    // 2^k itself may be no number; the last product rounds to the bits that are left.
    reduced.exp() * 2f64.powi(k / 2) * 2f64.powi(k - k / 2)
}

#[inline(always)]
fn is_moderate(x: f64) -> bool {
    (1e-300..=1e300).contains(&x)
}

/// The bits of √½, and what takes them to those of 2¹, whose exponent is 1024.
const SQRT_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
const TO_TWO: u64 = (1024 << FRACTION_BITS) - SQRT_HALF;

/// 2⁵²: integers in its lowest bits are added to it.
const INTEGER: f64 = 4_503_599_627_370_496.0;

#[inline(always)]
fn moderate_ln(x: f64) -> f64 {
    ln_less(x, 0.0)
}

/// ln x − `shift` ln 2, for an x with all bits.
#[inline(always)]
fn ln_less(x: f64, shift: f64) -> f64 {
    // k + 1024 and m = 1 + f.
    let exponent = x.to_bits().wrapping_add(TO_TWO) >> FRACTION_BITS;
    let k = f64::from_bits(INTEGER.to_bits() | exponent) - (INTEGER + 1024.0) - shift;
    let power = (exponent << FRACTION_BITS).wrapping_sub(1024 << FRACTION_BITS);
    let f = f64::from_bits(x.to_bits().wrapping_sub(power)) - 1.0;

    // f²/2 = half + rest, the first of them exact.
    let high = high(f);
    let (half, rest) = (0.5 * high * high, 0.5 * (f - high) * (f + high));
    let s = f / (2.0 + f);
    let (z, z2) = (s * s, s * s * (s * s));
    let l =
        ((L[0] + z * L[1]) + z2 * (L[2] + z * L[3])) + z2 * z2 * ((L[4] + z * L[5]) + z2 * L[6]);
    let small = s * ((half + rest) + z * l) - rest;

    // k ln 2 + f − half, with the rounding errors of both sums.
    let near = f - half;
    let error = (f - near) - half;
    let first = k * LN_2[0];
    let sum = first + near;
    sum + ((near - (sum - first)) + (error + (small + k * LN_2[1])))
}

/// Logarithms of the least and the largest numbers, and of what has none.
#[cold]
fn extreme_ln(x: f64) -> f64 {
    /// Bits that a subnormal number may lack, and two.
    const SHIFT: i32 = 54;
    if x == 0.0 {
        f64::NEG_INFINITY
    } else if x < 0.0 {
        f64::NAN
    } else if x.is_nan() || x.is_infinite() {
        x
    } else if x < 1.0 {
        ln_less(x * 2f64.powi(SHIFT), f64::from(SHIFT))
    } else {
        moderate_ln(x)
    }
}

/// From here on the tangent is 1 to the last bit.
const LARGEST_TANGENT: f64 = 20.0;

#[inline(always)]
fn tanh_of(x: f64) -> f64 {
    let size = if x.abs() > LARGEST_TANGENT { LARGEST_TANGENT } else { x.abs() };
    let reduced = reduced(2.0 * size);
    let k = reduced.rounded.to_bits().wrapping_add(1023) << FRACTION_BITS;
    let scale = f64::from_bits(k);

    // m = (2^k − 1) + 2^k hi + 2^k rest, as a sum and its rounding error.
    let (base, step) = (scale - 1.0, scale * reduced.hi);
    let near = base + step;
    let rest = (step - (near - base)) + scale * reduced.rest;
    let m = near + rest;
    let m_error = rest - (m - near);

    // m + 2 in the same way; either of them may be the larger one.
    let divisor = m + 2.0;
    let of_two = divisor - m;
    let divisor_error = (m - (divisor - of_two)) + (2.0 - of_two) + m_error;

    let inverse = 1.0 / divisor;
    let quotient = m * inverse;
    let remainder = remainder(m, quotient, divisor) + (m_error - quotient * divisor_error);
    (quotient + remainder * inverse).copysign(x)
}

/// n − q d of a quotient q of n and d, as if products were exact.
#[inline(always)]
pub(crate) fn remainder(n: f64, q: f64, d: f64) -> f64 {
    let (q_high, d_high) = (high(q), high(d));
    ((n - q_high * d_high) - q_high * (d - d_high)) - (q - q_high) * d
}

/// The first 26 bits of a number: their products are exact.
#[inline(always)]
fn high(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & !0x7ff_ffff)
}

/// c₀ + c₁x + … + c₁₀x¹⁰: short chains of operations (G. Estrin, 1960).
#[inline(always)]
pub(crate) fn polynomial(c: &[f64; 11], x: f64) -> f64 {
    let (x2, x4) = (x * x, x * x * (x * x));
    let pair = |n: usize| c[n] + x * c[n + 1];
    let (first, middle) = (pair(0) + x2 * pair(2), pair(4) + x2 * pair(6));
    first + x4 * (middle + x4 * (pair(8) + x2 * c[10]))
}
