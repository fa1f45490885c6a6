//! Sine and cosine of one angle together, of several angles in SIMD lanes.
//!
//! ```text
//! x = k π/2 + y − e        |y| ≤ π/4, k an integer, e the rounding error of y
//! sin x, cos x             ± sin(y − e) or ± cos(y − e), by k modulo 4
//! ```
//!
//! The angle is reduced with π/2 in three parts (W. J. Cody and W. Waite, *Software manual for the
//! elementary functions*, 1980, ch. 8); the polynomials are the minimax polynomials of fdlibm
//! (K. C. Ng, Sun Microsystems, 1993: errors below 2⁻⁵⁸ on |y| ≤ π/4). Results are within 0.8
//! units in the last place, also near multiples of π/2. Every lane goes through the same
//! operations, none of them fused, so that neither the number of lanes nor the instruction set
//! changes a bit of any result. Lanes beyond [`LARGEST`], infinite or NaN are left to `std`.
//!
//! Measured against `wide` 1.7 and `std` at four angles with SSE2: about 5, 8 and 8 ns per angle,
//! and 3 ns with AVX2. `wide` is off by 1.5 units, near multiples of π/2 by a thousand.

#![expect(clippy::disallowed_methods, reason = "large angles are left to `std`")]
#![expect(clippy::inline_always, reason = "the caller's instruction set must reach every loop")]

use pulp::{Arch, Simd, WithSimd};
use std::f64::consts::FRAC_2_PI;

/// Largest angle that is reduced here: k has at most 20 bits, so that its products with the first
/// two parts of π/2 are exact.
pub(crate) const LARGEST: f64 = 1e6;

/// π/2 = the sum of these; 33 bits each in the first two.
pub(crate) const HALF_PI: [f64; 3] =
    [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];

/// π/2 less the first of its parts.
pub(crate) const REST_OF_HALF_PI: f64 = 6.077_100_506_506_192e-11;

/// Adding 1.5 · 2⁵² rounds to an integer and leaves it in the lowest bits.
pub(crate) const ROUND: f64 = 6_755_399_441_055_744.0;

/// sin y = y + S₁y³ + S₂y⁵ + …
pub(crate) const S: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];

/// cos y = 1 − y²/2 + C₁y⁴ + C₂y⁶ + …
pub(crate) const C: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// Sine and cosine of one angle.
#[inline]
pub(crate) fn sin_cos(x: f64) -> (f64, f64) {
    if x.abs() <= LARGEST { reduced(x) } else { x.sin_cos() }
}

/// Most angles that [`sin_cos_few`] takes.
pub(crate) const FEW: usize = 4;

/// Sines and cosines of up to four angles: as many as there are results.
///
/// The rest of the angles may be anything. Inlined, so that the angles stay in registers: a vector
/// that is read from memory right after its parts were written would have to wait for them.
#[inline(always)]
pub(crate) fn sin_cos_few(angles: [f64; FEW], sines: &mut [f64], cosines: &mut [f64]) {
    let [a, b, ..] = angles;
    match (sines, cosines) {
        ([sine], [cosine]) => (*sine, *cosine) = sin_cos(a),
        // Every x86-64 has two lanes.
        ([s0, s1], [c0, c1]) => ([*s0, *s1], [*c0, *c1]) = sin_cos_lanes([a, b]),
        (sines, cosines) => {
            let (mut s, mut c) = ([0.0; FEW], [0.0; FEW]);
            Arch::new().dispatch(Few { angles, sines: &mut s, cosines: &mut c });
            sines.iter_mut().zip(s).for_each(|(to, sine)| *to = sine);
            cosines.iter_mut().zip(c).for_each(|(to, cosine)| *to = cosine);
        }
    }
}

/// Four angles, compiled for every instruction set there may be.
struct Few<'a> {
    angles: [f64; FEW],
    sines: &'a mut [f64; FEW],
    cosines: &'a mut [f64; FEW],
}

impl WithSimd for Few<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        (*self.sines, *self.cosines) = sin_cos_lanes(self.angles);
    }
}

/// Sines and cosines of `N` angles; inlined, so that the caller's instruction set is used.
#[inline(always)]
pub(crate) fn sin_cos_lanes<const N: usize>(angles: [f64; N]) -> ([f64; N], [f64; N]) {
    let are_small = angles.iter().fold(true, |all, x| all & (x.abs() <= LARGEST));
    if are_small { each(angles, reduced) } else { each(angles, any) }
}

#[inline(always)]
fn each<const N: usize>(
    angles: [f64; N],
    sin_cos: impl Fn(f64) -> (f64, f64),
) -> ([f64; N], [f64; N]) {
    let (mut sines, mut cosines) = ([0.0; N], [0.0; N]);
    for lane in 0..N {
        (sines[lane], cosines[lane]) = sin_cos(angles[lane]);
    }
    (sines, cosines)
}

/// [`sin_cos`], seldom needed. It takes one angle: results of a call that takes all of them are in memory, and those of
/// small angles would be put there too.
#[cold]
#[inline(never)]
fn any(x: f64) -> (f64, f64) {
    sin_cos(x)
}

/// Sine and cosine of an angle of at most [`LARGEST`]; without branches, for the lanes. Machine code has the same
/// operations in the same order: `eval/lanes/turn.rs`.
#[inline(always)]
fn reduced(x: f64) -> (f64, f64) {
    let rounded = x * FRAC_2_PI + ROUND;
    let quadrant = rounded.to_bits();
    let k = rounded - ROUND;

    // y − e = x − k π/2, each part's rounding error carried into the next.
    let first = x - k * HALF_PI[0];
    let part = k * HALF_PI[1];
    let second = first - part;
    let part = k * HALF_PI[2] - ((first - second) - part);
    let y = second - part;
    let e = part - (second - y);

    // The polynomials need y to fewer digits, and sooner.
    let near = first - k * REST_OF_HALF_PI;
    let (y2, y4) = (near * near, near * near * (near * near));
    let (y3, y8) = (y2 * near, y4 * y4);
    let half = 0.5 * y2;
    let lead = 1.0 - half;
    // The order of the differences keeps the sign of a zero.
    let sine = y - (e * lead - y3 * polynomial(&S, y2, y4, y8));
    let cosine = lead + (((1.0 - lead) - half) + (y4 * polynomial(&C, y2, y4, y8) + y * e));

    // Odd quadrants swap the two; the sine is negative in quadrants 2, 3, the cosine in 1, 2.
    let (sine, cosine) = (sine.to_bits(), cosine.to_bits());
    let swapped = (sine ^ cosine) & (quadrant & 1).wrapping_neg();
    let (sine_sign, cosine_sign) = ((quadrant & 2) << 62, (quadrant.wrapping_add(1) & 2) << 62);
    (f64::from_bits(sine ^ swapped ^ sine_sign), f64::from_bits(cosine ^ swapped ^ cosine_sign))
}

/// c₀ + c₁x + … + c₅x⁵ from x, x² and x⁴: short chains of operations (G. Estrin, 1960).
#[inline(always)]
fn polynomial(c: &[f64; 6], x: f64, x2: f64, x4: f64) -> f64 {
    ((c[0] + x * c[1]) + x2 * (c[2] + x * c[3])) + x4 * (c[4] + x * c[5])
}
