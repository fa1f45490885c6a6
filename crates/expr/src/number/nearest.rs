//! The float nearest to a fraction.

use num_bigint::{BigInt, BigUint};
use num_traits::{Signed, ToPrimitive, Zero};

/// Bits of a quotient from which a float is rounded: those of a float, and more to round by.
const BITS: i64 = 66;
/// Powers of two up to this are floats of full precision, in both directions.
const STEP: i64 = 1000;

/// The float nearest to a fraction of short parts with a positive denominator.
pub(super) fn nearest_short(numerator: i64, denominator: i64) -> f64 {
    const EXACT: u64 = 1 << 53;
    // One rounding, where both parts are exact.
    if numerator.unsigned_abs() <= EXACT && denominator.unsigned_abs() <= EXACT {
        return numerator as f64 / denominator as f64;
    }
    nearest(&numerator.into(), &denominator.into())
}

/// The float nearest to a fraction with a positive denominator; an infinity beyond the range.
pub(super) fn nearest(numerator: &BigInt, denominator: &BigInt) -> f64 {
    let (n, d) = (numerator.magnitude(), denominator.magnitude());
    if n.is_zero() {
        return 0.0;
    }
    // A quotient of enough bits; a remainder makes the last bit odd, so that a tie is one only if
    // it is.
    let length = |n: &BigUint| i64::try_from(n.bits()).unwrap_or(i64::MAX);
    let shift = BITS - (length(n) - length(d));
    let (n, d) = if shift >= 0 { (n << shift, d.clone()) } else { (n.clone(), d << -shift) };
    let quotient = &n / &d;
    let is_rounded = &quotient * &d != n;
    let bits = quotient.to_u128().expect("a quotient of 66 or 67 bits") | u128::from(is_rounded);
    let mut magnitude = bits as f64;

    // The power of two in steps, each of which is exact within the range.
    let mut exponent = -shift;
    while exponent != 0 && magnitude.is_finite() && magnitude != 0.0 {
        let step = exponent.clamp(-STEP, STEP);
        magnitude *= 2f64.powi(i32::try_from(step).expect("a step is short"));
        exponent -= step;
    }
    if numerator.is_negative() { -magnitude } else { magnitude }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_fractions_round_once() {
        let power = |n: u32| BigInt::from(10).pow(n);
        let check = |n: BigInt, d: BigInt, expected: f64| {
            assert_eq!(nearest(&n, &d).to_bits(), expected.to_bits(), "{n}/{d}");
            assert_eq!(nearest(&-&n, &d).to_bits(), (-expected).to_bits(), "-{n}/{d}");
        };
        check(power(40), power(17), 1e23);
        check(BigInt::from(3), power(300), 3e-300);
        check(power(400), BigInt::from(1), f64::INFINITY);
        check(BigInt::from(1), power(400), 0.0);
        // A tie goes to the even neighbour, anything above it up.
        let tie: BigInt = (BigInt::from(1) << 70) + (BigInt::from(1) << 17);
        check(tie.clone(), BigInt::from(1), 2f64.powi(70));
        check(tie + 1, BigInt::from(1), 2f64.powi(70) + 2f64.powi(18));
    }
}
