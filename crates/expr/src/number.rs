//! Exact rational numbers, and floats where they would be too long.
//!
//! Coefficients stay exact as long as numerator and denominator have at most 19 digits; an
//! operation that would need more gives the nearest float instead, which a person can still read. A
//! decimal literal is a rational.

use num_rational::Ratio;
use num_traits::{CheckedAdd, CheckedMul, Signed, Zero};
use std::cmp::Ordering;

/// A number inside an expression.
#[derive(Clone, Copy, Debug)]
pub enum Number {
    /// An exact fraction in lowest terms.
    Rational(Ratio<i128>),
    /// A float: given as one, or the result of an exact operation that overflowed.
    Float(f64),
}

/// Two numbers are the same when they are interchangeable in every expression: floats by their
/// bits, so that −0 differs from 0 and a NaN equals itself.
impl PartialEq for Number {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Rational(a), Self::Rational(b)) => a == b,
            (Self::Float(a), Self::Float(b)) => a.to_bits() == b.to_bits(),
            _ => false,
        }
    }
}

impl Eq for Number {}

impl From<i64> for Number {
    fn from(value: i64) -> Self {
        Self::integer(i128::from(value))
    }
}

impl Number {
    /// The number 0.
    pub const ZERO: Self = Self::integer(0);
    /// The number 1.
    pub const ONE: Self = Self::integer(1);
    /// The number −1.
    pub const MINUS_ONE: Self = Self::integer(-1);

    /// An integer.
    pub const fn integer(value: i128) -> Self {
        Self::Rational(Ratio::new_raw(value, 1))
    }

    /// The fraction `numerator / denominator`; a zero denominator gives the float quotient
    /// (an infinity or NaN).
    pub fn rational(numerator: i64, denominator: i64) -> Self {
        if denominator == 0 {
            return Self::Float(numerator as f64 / 0.0);
        }
        Self::Rational(Ratio::new(i128::from(numerator), i128::from(denominator)))
    }

    /// A float; integers below 2⁵³ become exact.
    pub fn float(value: f64) -> Self {
        let exact_limit = 2f64.powi(53);
        let is_negative_zero = value == 0.0 && value.is_sign_negative();
        if value.fract() == 0.0 && value.abs() < exact_limit && !is_negative_zero {
            #[expect(clippy::cast_possible_truncation, reason = "an integer below 2^53")]
            return Self::integer(value as i128);
        }
        Self::Float(value)
    }

    /// Reads an unsigned decimal literal such as `12`, `0.125` or `6.7e-11`, exactly where it
    /// fits; `None` when the text is no number.
    pub fn parse(text: &str) -> Option<Self> {
        let (mantissa, exponent) = match text.split_once(['e', 'E']) {
            Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
            None => (text, 0),
        };
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let all_digits = |part: &str| part.bytes().all(|b| b.is_ascii_digit());
        if whole.len() + fraction.len() == 0 || !all_digits(whole) || !all_digits(fraction) {
            return None;
        }
        let fraction = fraction.trim_end_matches('0');
        let shift = i32::try_from(fraction.len()).ok().and_then(|n| exponent.checked_sub(n));
        let exact = shift.and_then(|shift| {
            let digits = format!("{whole}{fraction}").parse::<i128>().ok()?;
            let scale = 10i128.checked_pow(shift.unsigned_abs())?;
            if shift < 0 {
                return Some(Ratio::new(digits, scale));
            }
            digits.checked_mul(scale).map(Ratio::from_integer)
        });
        match exact {
            Some(value) => Some(Self::Rational(value)),
            None => text.parse::<f64>().ok().map(Self::float),
        }
    }

    /// The nearest float.
    pub fn to_f64(self) -> f64 {
        match self {
            Self::Rational(r) => nearest(*r.numer(), *r.denom()),
            Self::Float(f) => f,
        }
    }

    /// The value as an integer, when it is an exact one.
    pub fn as_integer(self) -> Option<i64> {
        match self {
            Self::Rational(r) if *r.denom() == 1 => i64::try_from(*r.numer()).ok(),
            _ => None,
        }
    }

    /// The value as an exact fraction.
    pub fn as_rational(self) -> Option<Ratio<i128>> {
        match self {
            Self::Rational(r) => Some(r),
            Self::Float(_) => None,
        }
    }

    /// Whether this is exactly 0 (a float zero too).
    pub fn is_zero(self) -> bool {
        match self {
            Self::Rational(r) => r.is_zero(),
            Self::Float(f) => f == 0.0,
        }
    }

    /// Whether this is the exact 1.
    pub fn is_one(self) -> bool {
        self == Self::ONE
    }

    /// Whether this is below zero.
    pub fn is_negative(self) -> bool {
        match self {
            Self::Rational(r) => r.is_negative(),
            Self::Float(f) => f < 0.0,
        }
    }

    /// Whether this is neither infinite nor NaN.
    pub fn is_finite(self) -> bool {
        !matches!(self, Self::Float(f) if !f.is_finite())
    }

    /// Sum.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        if let (Self::Rational(a), Self::Rational(b)) = (self, other) {
            if let Some([p, q, r, s]) = small_parts(a, b) {
                return Self::reduced(p * s + r * q, q * s);
            }
            if let Some(sum) = a.checked_add(&b) {
                return Self::readable(sum);
            }
        }
        Self::float(self.to_f64() + other.to_f64())
    }

    /// Product.
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        if let (Self::Rational(a), Self::Rational(b)) = (self, other) {
            if let Some([p, q, r, s]) = small_parts(a, b) {
                return Self::reduced(p * r, q * s);
            }
            if let Some(product) = a.checked_mul(&b) {
                return Self::readable(product);
            }
        }
        Self::float(self.to_f64() * other.to_f64())
    }

    /// The fraction, or the nearest float where it has more digits than anybody reads.
    fn readable(fraction: Ratio<i128>) -> Self {
        let is_short = |part: &i128| part.unsigned_abs() < LONGEST;
        let exact = Self::Rational(fraction);
        if is_short(fraction.numer()) && is_short(fraction.denom()) {
            exact
        } else {
            Self::float(exact.to_f64())
        }
    }

    /// The fraction in lowest terms; the denominator is positive.
    fn reduced(numerator: i64, denominator: i64) -> Self {
        let (mut a, mut b) = (numerator.unsigned_abs(), denominator.unsigned_abs());
        if b != 1 {
            while a != 0 {
                (a, b) = (b % a, a);
            }
        }
        #[expect(clippy::cast_possible_wrap, reason = "a divisor of a positive i64")]
        let gcd = b as i64;
        Self::Rational(Ratio::new_raw((numerator / gcd).into(), (denominator / gcd).into()))
    }

    /// Negation.
    #[must_use]
    pub fn negated(self) -> Self {
        match self {
            Self::Rational(r) if *r.numer() != i128::MIN => Self::Rational(-r),
            _ => Self::Float(-self.to_f64()),
        }
    }

    /// Absolute value.
    #[must_use]
    pub fn magnitude(self) -> Self {
        if self.is_negative() { self.negated() } else { self }
    }

    /// Quotient; division by zero follows floats.
    #[must_use]
    pub fn over(self, other: Self) -> Self {
        match other {
            Self::Rational(r) if !r.is_zero() => self.times(Self::Rational(r.recip())),
            _ => Self::float(self.to_f64() / other.to_f64()),
        }
    }

    /// Integer power by repeated squaring; 0 to a negative power follows floats.
    #[must_use]
    pub fn power(self, exponent: i64) -> Self {
        let mut square = if exponent < 0 { Self::ONE.over(self) } else { self };
        let mut left = exponent.unsigned_abs();
        let mut result = Self::ONE;
        while left > 0 {
            if left & 1 == 1 {
                result = result.times(square);
            }
            left >>= 1;
            if left > 0 {
                square = square.times(square);
            }
        }
        result
    }

    /// The exact square root of a non-negative rational whose parts are perfect squares.
    pub fn exact_sqrt(self) -> Option<Self> {
        let r = self.as_rational().filter(|r| !r.is_negative())?;
        let root = |n: i128| {
            let root = n.isqrt();
            (root * root == n).then_some(root)
        };
        Some(Self::Rational(Ratio::new(root(*r.numer())?, root(*r.denom())?)))
    }

    /// Order by value; NaN compares equal to everything.
    pub fn order(self, other: Self) -> Ordering {
        match (self, other) {
            (Self::Rational(a), Self::Rational(b)) => a.cmp(&b),
            _ => self.to_f64().partial_cmp(&other.to_f64()).unwrap_or(Ordering::Equal),
        }
    }

    /// Digits of a terminating decimal of at most [`DECIMALS`] decimals, or of more where the
    /// fraction would be no shorter; otherwise `None`.
    fn decimal(self) -> Option<String> {
        let r = self.as_rational()?;
        let is_long = r.numer().unsigned_abs() >= 10u128.pow(DECIMALS);
        let most = if is_long { 2 * DECIMALS } else { DECIMALS };
        let n_decimals = (0..=most).find(|&n| 10i128.pow(n) % *r.denom() == 0)?;
        let scaled = r.numer().checked_mul(&(10i128.pow(n_decimals) / *r.denom()))?;
        if n_decimals == 0 {
            return Some(scaled.to_string());
        }
        let width = n_decimals as usize + 1;
        let digits = format!("{:0>width$}", scaled.unsigned_abs());
        let (whole, fraction) = digits.split_at(digits.len() - n_decimals as usize);
        Some(format!("{}{whole}.{fraction}", if scaled < 0 { "-" } else { "" }))
    }
}

/// Numerators and denominators of two fractions if products of any two of them, and the sum of two
/// such products, fit 64 bits: most do, and 64-bit division is much faster.
fn small_parts(a: Ratio<i128>, b: Ratio<i128>) -> Option<[i64; 4]> {
    let parts = [*a.numer(), *a.denom(), *b.numer(), *b.denom()];
    let are_small = parts.iter().all(|part| part.unsigned_abs() < 1 << 31);
    #[expect(clippy::cast_possible_truncation, reason = "below 2^31")]
    are_small.then(|| parts.map(|part| part as i64))
}

/// Numerators and denominators of exact fractions are below this.
const LONGEST: u128 = 10_000_000_000_000_000_000;

/// Decimals printed before a fraction is preferred.
const DECIMALS: u32 = 12;

/// Integers and short decimals as decimals, other rationals as `p/q`, floats in shortest form.
impl std::fmt::Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self, self.decimal()) {
            (_, Some(decimal)) => f.write_str(&decimal),
            (Self::Rational(r), None) => write!(f, "{}/{}", r.numer(), r.denom()),
            (Self::Float(value), None) if value.is_finite() => write!(f, "{value:?}"),
            // The text form has no literal for these; the quotients read back as the same value.
            (Self::Float(value), None) if value.is_nan() => f.write_str("0/0"),
            (Self::Float(value), None) => f.write_str(if *value > 0.0 { "1/0" } else { "-1/0" }),
        }
    }
}

/// The float nearest to a fraction with a positive denominator.
fn nearest(numer: i128, denom: i128) -> f64 {
    /// Bits of a float, and two more to round by.
    const ENOUGH: u128 = 1 << 54;
    const EXACT: u128 = 1 << 53;
    let (n, d) = (numer.unsigned_abs(), denom.unsigned_abs());
    // One rounding, where both parts are exact.
    if n <= EXACT && d <= EXACT {
        return numer as f64 / denom as f64;
    }
    // Long division, bit by bit, until there are enough; a remainder makes the last bit odd, so
    // that a tie is one only if it is.
    let (mut quotient, mut rest, mut shift) = (n / d, n % d, 0);
    while quotient < ENOUGH && n != 0 {
        rest <<= 1;
        quotient = (quotient << 1) | u128::from(rest >= d);
        rest -= if rest >= d { d } else { 0 };
        shift -= 1;
    }
    let magnitude = (quotient | u128::from(rest != 0)) as f64 * 2f64.powi(shift);
    if numer < 0 { -magnitude } else { magnitude }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_literals_are_exact() {
        assert_eq!(Number::parse("0.125"), Some(Number::rational(1, 8)));
        assert_eq!(Number::parse("9.81"), Some(Number::rational(981, 100)));
        assert_eq!(Number::parse("2.5e-3"), Some(Number::rational(1, 400)));
        assert_eq!(Number::parse("1e400"), Some(Number::Float(f64::INFINITY)));
        assert_eq!(Number::parse("1.2.3"), None);
        assert_eq!(Number::parse("."), None);
    }

    #[test]
    fn fractions_too_long_to_read_become_floats() {
        let long = Number::parse("38.302222155949").expect("a decimal");
        assert_eq!(long.to_string(), "38.302222155949");
        let product = long.times(long);
        assert!(matches!(product, Number::Float(_)), "{product}");
        assert_eq!(long.times(Number::rational(1, 500)).to_string(), "0.076604444311898");
    }

    #[test]
    fn overflow_falls_to_floats() {
        let big = Number::integer(i128::MAX);
        assert!(matches!(big.plus(big), Number::Float(_)));
        assert!(matches!(big.times(big), Number::Float(_)));
        assert_eq!(Number::integer(i128::MIN).negated().to_f64(), 2f64.powi(127));
    }

    #[test]
    fn small_and_large_fractions_follow_the_same_rules() {
        let parts = [0i128, 1, -1, 2, -6, 35, (1 << 31) - 1, 1 << 31, -(1 << 33), 1 << 40];
        for (a, b) in parts.iter().flat_map(|a| parts.iter().map(move |b| (*a, *b))) {
            for (c, d) in parts.iter().flat_map(|c| parts.iter().map(move |d| (*c, *d))) {
                if b == 0 || d == 0 {
                    continue;
                }
                let (x, y) = (Ratio::new(a, b), Ratio::new(c, d));
                let (sum, product) = (Number::readable(x + y), Number::readable(x * y));
                assert_eq!(Number::Rational(x).plus(Number::Rational(y)), sum, "{x} + {y}");
                assert_eq!(Number::Rational(x).times(Number::Rational(y)), product, "{x} * {y}");
            }
        }
    }

    #[test]
    fn numbers_print_as_decimals_when_they_terminate() {
        let text = |n, d| Number::rational(n, d).to_string();
        assert_eq!(text(1, 4), "0.25");
        assert_eq!(text(-1, 400), "-0.0025");
        assert_eq!(text(1, 3), "1/3");
        assert_eq!(text(-7, 1), "-7");
    }

    #[test]
    fn a_float_written_with_all_digits_reads_back_as_itself() {
        let mut bits = 1u64;
        for _ in 0..20_000 {
            // Xorshift: G. Marsaglia, J. Stat. Softw. 8 (2003).
            bits ^= bits << 13;
            bits ^= bits >> 7;
            bits ^= bits << 17;
            let exponent = 1023 - 40 + bits % 80;
            let value = f64::from_bits((exponent << 52) | (bits >> 12));
            let text = format!("{value:?}");
            let number = Number::parse(&text).map(Number::to_f64);
            assert_eq!(number.map(f64::to_bits), Some(value.to_bits()), "{text}");
        }
    }
}
