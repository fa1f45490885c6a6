//! Angles of points, and the arctangent, in SIMD lanes.
//!
//! ```text
//! a, b      the smaller and the larger one of |x| and |y|
//! n/d       a/b, or (a − b)/(a + b) where a/b > tan π/8: in size at most tan π/8
//! u + e     the quotient n/d and its error
//! φ         arctan(n/d) = u + e (1 − u²) − u³ A(u²)
//! angle     j π/4 + φ or j π/4 − φ, by the eighth of the plane in which the point lies
//! ```
//!
//! A is the minimax polynomial by the exchange algorithm of E. Ya. Remez (1934). The sum keeps the rounding error of its
//! first terms; results are within 0.65 units in the last place, exact at the axes, and have the signs of IEEE 754.
//!
//! As in [`elementary`](crate::elementary) neither the number of lanes nor the instruction set changes a bit. Points at
//! the origin, beyond 10^±120, or at infinity are computed again, one by one, from moderate ones of the same angle.

#![expect(clippy::inline_always, reason = "the caller's instruction set must reach every loop")]

use crate::elementary::{polynomial, remainder};
use std::f64::consts::{FRAC_PI_4, SQRT_2};

/// tan π/8, nearly.
const TAN_PI_8: f64 = SQRT_2 - 1.0;

/// π/4 = the sum of these; the first has 50 bits, so that its products with j are exact.
const PI_4: [f64; 2] = [FRAC_PI_4, 3.061_616_997_868_383e-17];

/// A(u²), by 2⁻⁵⁹ of arctan u on |u| ≤ tan π/8.
const A: [f64; 11] = [
    0.333_333_333_333_332,
    -0.199_999_999_999_538_3,
    0.142_857_142_802_217_8,
    -0.111_111_107_847_414_39,
    9.090_897_794_753_817e-2,
    -7.692_060_870_611_865e-2,
    6.663_111_412_474_365e-2,
    -5.847_941_899_449_48e-2,
    5.039_536_250_830_958e-2,
    -3.807_028_995_582_277e-2,
    1.791_330_539_733_118e-2,
];

const SIGN: u64 = 1 << 63;

/// The angle of the point (x, y), from −π to π.
pub(crate) fn atan2(y: f64, x: f64) -> f64 {
    if is_moderate(y, x) { moderate(y, x) } else { extreme(y, x) }
}

/// Angles of `N` points.
#[inline(always)]
pub(crate) fn atan2_lanes<const N: usize>(y: [f64; N], x: [f64; N]) -> [f64; N] {
    let mut out = [0.0; N];
    let mut are_moderate = true;
    for lane in 0..N {
        out[lane] = moderate(y[lane], x[lane]);
    }
    for lane in 0..N {
        are_moderate &= is_moderate(y[lane], x[lane]);
    }
    if are_moderate { out } else { one_by_one(y, x) }
}

#[cold]
#[inline(never)]
fn one_by_one<const N: usize>(y: [f64; N], x: [f64; N]) -> [f64; N] {
    std::array::from_fn(|lane| atan2(y[lane], x[lane]))
}

/// The smaller size of two numbers, then the larger.
#[inline(always)]
fn sizes(y: f64, x: f64) -> (f64, f64) {
    let (y, x) = (y.abs(), x.abs());
    if y > x { (x, y) } else { (y, x) }
}

/// True where no product or quotient on the way to the angle overflows, underflows, or loses bits.
#[expect(clippy::needless_bitwise_bool, reason = "no branches within the lanes")]
#[expect(clippy::manual_range_contains, reason = "no branches within the lanes")]
#[inline(always)]
fn is_moderate(y: f64, x: f64) -> bool {
    let (a, b) = sizes(y, x);
    (b >= 1e-120) & (b <= 1e120) & ((a == 0.0) | (a >= 1e-250))
}

/// The angle of a moderate point; without branches, for the lanes.
#[inline(always)]
fn moderate(y: f64, x: f64) -> f64 {
    let (a, b) = sizes(y, x);
    let (is_steep, is_wide) = (y.abs() > x.abs(), a > TAN_PI_8 * b);

    // n and d with their rounding errors.
    let (less, more) = if is_wide { (b, a) } else { (0.0, 0.0) };
    let (n, d) = (a - less, b + more);
    let (n_error, d_error) = (a - (n + less), more - (d - b));

    // The quotient, what it leaves, and the arctangent less the quotient.
    let inverse = 1.0 / d;
    let u = n * inverse;
    let e = (remainder(n, u, d) + (n_error - u * d_error)) * inverse;
    let z = u * u;
    let rest = e * (1.0 - z) - u * z * polynomial(&A, z);

    // Steep angles are measured back from π/2, those of negative x from π.
    let is_back = x.to_bits() & SIGN != 0;
    let j = if is_wide { 1.0 } else { 0.0 };
    let j = if is_steep { 2.0 - j } else { j };
    let j = if is_back { 4.0 - j } else { j };
    let sign = (x.to_bits() & SIGN) ^ if is_steep { SIGN } else { 0 };
    let (u, rest) = (f64::from_bits(u.to_bits() ^ sign), f64::from_bits(rest.to_bits() ^ sign));

    let base = j * PI_4[0];
    let sum = base + u;
    let angle = sum + ((u - (sum - base)) + (j * PI_4[1] + rest));
    f64::from_bits(angle.to_bits() ^ (y.to_bits() & SIGN))
}

/// The angle of any point, as that of a moderate one.
#[cold]
fn extreme(y: f64, x: f64) -> f64 {
    if y.is_nan() || x.is_nan() {
        return f64::NAN;
    }
    let (a, b) = sizes(y, x);
    let (y, x) = if b.is_infinite() {
        let unit = |x: f64| if x.is_infinite() { 1f64 } else { 0.0 }.copysign(x);
        (unit(y), unit(x))
    } else if b == 0.0 {
        (y, 1f64.copysign(x))
    } else if a >= 1e-30 * b {
        let scale = 2f64.powi(if b < 1.0 { 600 } else { -600 });
        (y * scale, x * scale)
    } else if y.abs() > x.abs() {
        // So near to an axis that only the axis counts, or that the angle is its tangent.
        (1f64.copysign(y), 0f64.copysign(x))
    } else if x < 0.0 {
        (0f64.copysign(y), -1.0)
    } else {
        return y / x;
    };
    moderate(y, x)
}
