//! Exact rational numbers of any length, and floats where one was given.
//!
//! Sums, products and quotients of exact numbers are exact: a decimal literal is a fraction, and no
//! digit is dropped on the way. Parts within 63 bits are stored in place, longer ones behind a
//! shared pointer, so that usual numbers stay small and fast. An operation on parts of more than
//! [`MAX_BITS`] bits, and a product both of whose parts have more than [`MAX_FACTOR_BITS`], gives the nearest
//! float; a power of that length is not computed at all.

mod decimal;
mod near;
mod nearest;
#[cfg(test)]
mod tests;
mod text;

pub(crate) use text::MAX_DIGITS;

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::{BigRational, Ratio};
use num_traits::{Signed, ToPrimitive};
use std::borrow::{Borrow, Cow};
use std::cmp::Ordering;
use std::sync::Arc;

/// A number inside an expression.
#[derive(Clone, Debug)]
pub struct Number(Kind);

/// The ways a number is stored; each exact value has one way only.
#[derive(Clone, Debug)]
enum Kind {
    /// A fraction in lowest terms with a positive denominator; no part is `i64::MIN`.
    Short { numerator: i64, denominator: i64 },
    /// A fraction in lowest terms with a positive denominator, one part of which is longer.
    Long(Arc<BigRational>),
    /// A float: given as one, or the result of an operation with one.
    Float(f64),
}

use Kind::{Float, Long, Short};

/// Longest part of an exact fraction, in bits: about 20 000 digits.
pub(crate) const MAX_BITS: u64 = 1 << 16;
/// Bits of both parts of a product, about 77 digits, above which it is a float: factors of so many digits
/// are decimals with errors of their own, and their products would take more work than all else.
const MAX_FACTOR_BITS: u64 = 1 << 8;
/// Longest part of a power that is computed, in bits: as large as a float can be. Longer powers stay
/// powers, which are shorter to read: `10^400`.
const MAX_POWER_BITS: u64 = 1 << 10;

/// Two numbers are the same when they are interchangeable in every expression: floats by their
/// bits, so that −0 differs from 0 and a NaN equals itself.
impl PartialEq for Number {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Short { numerator: p, denominator: q }, Short { numerator: r, denominator: s }) => {
                p == r && q == s
            }
            // In lowest terms, part by part: the order of fractions is found by divisions.
            (Long(a), Long(b)) => a.numer() == b.numer() && a.denom() == b.denom(),
            (Float(a), Float(b)) => a.to_bits() == b.to_bits(),
            _ => false,
        }
    }
}

impl Eq for Number {}

impl std::hash::Hash for Number {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        match &self.0 {
            Short { numerator, denominator } => (numerator, denominator).hash(state),
            Long(fraction) => (fraction.numer(), fraction.denom()).hash(state),
            Float(value) => value.to_bits().hash(state),
        }
    }
}

impl From<i64> for Number {
    fn from(value: i64) -> Self {
        if value == i64::MIN {
            Self::from_big(BigInt::from(value).into())
        } else {
            Self::integer(value)
        }
    }
}

impl Number {
    /// The number 0.
    pub const ZERO: Self = Self::integer(0);
    /// The number 1.
    pub const ONE: Self = Self::integer(1);
    /// The number −1.
    pub const MINUS_ONE: Self = Self::integer(-1);

    /// An integer above `i64::MIN`.
    pub(crate) const fn integer(value: i64) -> Self {
        Self(Short { numerator: value, denominator: 1 })
    }

    /// The fraction `numerator / denominator`; a zero denominator gives the float quotient
    /// (an infinity or NaN).
    pub fn rational(numerator: i64, denominator: i64) -> Self {
        if denominator == 0 {
            return Self(Float(numerator as f64 / 0.0));
        }
        Self::of_wide(i128::from(numerator), i128::from(denominator))
    }

    /// A float; integers below 2⁵³ become exact.
    pub fn float(value: f64) -> Self {
        let exact_limit = 2f64.powi(53);
        let is_negative_zero = value == 0.0 && value.is_sign_negative();
        if value.fract() == 0.0 && value.abs() < exact_limit && !is_negative_zero {
            #[expect(clippy::cast_possible_truncation, reason = "an integer below 2^53")]
            return Self::integer(value as i64);
        }
        Self(Float(value))
    }

    /// The exact value of a finite float.
    pub(crate) fn exact_float(value: f64) -> Option<Self> {
        BigRational::from_float(value).map(Self::from_big)
    }

    /// A fraction with a denominator that is not zero.
    fn of_wide(numerator: i128, denominator: i128) -> Self {
        let (numerator, denominator) = Ratio::new(numerator, denominator).into_raw();
        Self::of_wide_parts(numerator, denominator)
    }

    /// A fraction in lowest terms with a positive denominator.
    fn of_wide_parts(numerator: i128, denominator: i128) -> Self {
        let part = |n: i128| i64::try_from(n).ok().filter(|&n| n != i64::MIN);
        match (part(numerator), part(denominator)) {
            (Some(numerator), Some(denominator)) => Self(Short { numerator, denominator }),
            _ => Self(Long(Arc::new(BigRational::new_raw(numerator.into(), denominator.into())))),
        }
    }

    /// A fraction in lowest terms with a positive denominator.
    fn from_big(fraction: BigRational) -> Self {
        let part = |n: &BigInt| n.to_i64().filter(|&n| n != i64::MIN);
        if let (Some(numerator), Some(denominator)) =
            (part(fraction.numer()), part(fraction.denom()))
        {
            return Self(Short { numerator, denominator });
        }
        if fraction.numer().bits().max(fraction.denom().bits()) > MAX_BITS {
            return Self::float(nearest::nearest(fraction.numer(), fraction.denom()));
        }
        Self(Long(Arc::new(fraction)))
    }

    /// The product of two fractions in lowest terms.
    fn from_product(a: &BigRational, b: &BigRational) -> Self {
        if let Some((numerator, denominator)) = decimal::product(a, b) {
            return Self::from_factors(numerator, denominator);
        }
        let [first, second] = [a.numer().gcd(b.denom()), b.numer().gcd(a.denom())];
        Self::from_factors(
            (a.numer() / &first) * (b.numer() / &second),
            (a.denom() / second) * (b.denom() / first),
        )
    }

    /// The sum of two fractions in lowest terms.
    fn from_sum(a: &BigRational, b: &BigRational) -> Self {
        match decimal::sum(a, b) {
            Some((numerator, denominator)) => {
                Self::from_big(BigRational::new_raw(numerator, denominator))
            }
            None => Self::from_big(a + b),
        }
    }

    /// A product, its parts without a divisor in common; the denominator is positive.
    fn from_factors(numerator: BigInt, denominator: BigInt) -> Self {
        let fraction = BigRational::new_raw(numerator, denominator);
        let shorter = fraction.numer().bits().min(fraction.denom().bits());
        if shorter > MAX_FACTOR_BITS {
            return Self::float(nearest::nearest(fraction.numer(), fraction.denom()));
        }
        Self::from_big(fraction)
    }

    /// The exact value with long parts; `None` for a float.
    fn to_big(&self) -> Option<Cow<'_, BigRational>> {
        match &self.0 {
            Short { numerator, denominator } => {
                let fraction = BigRational::new_raw((*numerator).into(), (*denominator).into());
                Some(Cow::Owned(fraction))
            }
            Long(fraction) => Some(Cow::Borrowed(fraction)),
            Float(_) => None,
        }
    }

    /// Numerator and positive denominator in lowest terms; `None` for a float.
    pub(crate) fn parts(&self) -> Option<(BigInt, BigInt)> {
        self.to_big().map(|fraction| fraction.into_owned().into_raw())
    }

    /// The fraction of two integers; the denominator is not zero.
    pub(crate) fn of_parts(numerator: BigInt, denominator: BigInt) -> Self {
        Self::from_big(BigRational::new(numerator, denominator))
    }

    /// True of an exact fraction with a part of more than 63 bits, whose sums and products take long.
    pub(crate) fn is_long(&self) -> bool {
        matches!(self.0, Long(_))
    }

    /// Numerator and denominator, if both are short.
    pub(crate) fn short_parts(&self) -> Option<(i64, i64)> {
        match self.0 {
            Short { numerator, denominator } => Some((numerator, denominator)),
            _ => None,
        }
    }

    /// A hash that depends on the value alone, made by mixing two words at a time.
    pub(crate) fn mixed(&self, mix: &dyn Fn(u64, u64) -> u64) -> u64 {
        // Sign extended to two words.
        let short = |n: i64| mix(n.cast_unsigned(), (n >> 63).cast_unsigned());
        let long = |n: &BigInt| {
            let sign = u64::from(n.is_negative());
            n.iter_u64_digits().fold(sign, mix)
        };
        match &self.0 {
            Short { numerator, denominator } => mix(short(*numerator), short(*denominator)),
            Long(fraction) => mix(long(fraction.numer()), long(fraction.denom())),
            Float(value) => mix(mix(value.to_bits(), 0), mix(0, 0)),
        }
    }

    /// The nearest float.
    pub fn to_f64(&self) -> f64 {
        match &self.0 {
            Short { numerator, denominator } => nearest::nearest_short(*numerator, *denominator),
            Long(fraction) => nearest::nearest(fraction.numer(), fraction.denom()),
            Float(value) => *value,
        }
    }

    /// The value, if it is a float.
    pub fn as_float(&self) -> Option<f64> {
        match self.0 {
            Float(value) => Some(value),
            _ => None,
        }
    }

    /// True if this is an exact fraction.
    pub fn is_exact(&self) -> bool {
        !matches!(self.0, Float(_))
    }

    /// The value as an integer, when it is an exact one of at most 63 bits.
    pub fn as_integer(&self) -> Option<i64> {
        match self.0 {
            Short { numerator, denominator: 1 } => Some(numerator),
            _ => None,
        }
    }

    /// True if this is exactly 0 (a float zero too).
    pub fn is_zero(&self) -> bool {
        match self.0 {
            Short { numerator, .. } => numerator == 0,
            Long(_) => false,
            Float(value) => value == 0.0,
        }
    }

    /// True if this is the exact 1.
    pub fn is_one(&self) -> bool {
        matches!(self.0, Short { numerator: 1, denominator: 1 })
    }

    /// True if this is below zero.
    pub fn is_negative(&self) -> bool {
        match &self.0 {
            Short { numerator, .. } => *numerator < 0,
            Long(fraction) => fraction.is_negative(),
            Float(value) => *value < 0.0,
        }
    }

    /// True if this is neither infinite nor NaN.
    pub fn is_finite(&self) -> bool {
        self.as_float().is_none_or(f64::is_finite)
    }

    /// Sum.
    #[must_use]
    pub fn plus(&self, other: impl Borrow<Self>) -> Self {
        let other = other.borrow();
        if let (Some((p, q)), Some((r, s))) = (self.short_parts(), other.short_parts()) {
            if are_tiny([p, q, r, s]) {
                return Self::reduced(p * s + r * q, q * s);
            }
            let [p, q, r, s] = [p, q, r, s].map(i128::from);
            return Self::of_wide(p * s + r * q, q * s);
        }
        match (self.to_big(), other.to_big()) {
            (Some(a), Some(b)) => Self::from_sum(&a, &b),
            _ => Self::float(self.to_f64() + other.to_f64()),
        }
    }

    /// Product.
    #[must_use]
    pub fn times(&self, other: impl Borrow<Self>) -> Self {
        let other = other.borrow();
        if let (Some((p, q)), Some((r, s))) = (self.short_parts(), other.short_parts()) {
            // What numerators and denominators of lowest terms have in common stands crosswise alone.
            let (first, second) = (common_divisor(p, s), common_divisor(r, q));
            return Self::of_coprime([p / first, r / second], [q / second, s / first]);
        }
        match (self.to_big(), other.to_big()) {
            (Some(a), Some(b)) => Self::from_product(&a, &b),
            _ => Self::float(self.to_f64() * other.to_f64()),
        }
    }

    /// Product of powers of one number, whose parts have no divisor in common.
    fn times_power(&self, other: &Self) -> Self {
        if let (Some((p, q)), Some((r, s))) = (self.short_parts(), other.short_parts()) {
            return Self::of_coprime([p, r], [q, s]);
        }
        match (self.to_big(), other.to_big()) {
            (Some(a), Some(b)) => Self::from_factors(a.numer() * b.numer(), a.denom() * b.denom()),
            _ => self.times(other),
        }
    }

    /// The fraction of two products that have no divisor in common; the denominator is positive.
    fn of_coprime([p, r]: [i64; 2], [q, s]: [i64; 2]) -> Self {
        let (numerator, denominator) =
            (i128::from(p) * i128::from(r), i128::from(q) * i128::from(s));
        Self::of_wide_parts(numerator, denominator)
    }

    /// The fraction in lowest terms; the denominator is positive.
    fn reduced(numerator: i64, denominator: i64) -> Self {
        let divisor = common_divisor(numerator, denominator);
        Self(Short { numerator: numerator / divisor, denominator: denominator / divisor })
    }

    /// Negation.
    #[must_use]
    pub fn negated(&self) -> Self {
        match &self.0 {
            Short { numerator, denominator } => {
                Self(Short { numerator: -numerator, denominator: *denominator })
            }
            Long(fraction) => Self(Long(Arc::new(-(**fraction).clone()))),
            Float(value) => Self(Float(-value)),
        }
    }

    /// Absolute value.
    #[must_use]
    pub fn magnitude(&self) -> Self {
        if self.is_negative() { self.negated() } else { self.clone() }
    }

    /// Quotient; division by zero follows floats.
    #[must_use]
    pub fn over(&self, other: impl Borrow<Self>) -> Self {
        let other = other.borrow();
        match &other.0 {
            Short { numerator: 0, .. } | Float(_) => Self::float(self.to_f64() / other.to_f64()),
            Short { numerator, denominator } => {
                let sign = numerator.signum();
                let inverse = Short { numerator: sign * denominator, denominator: numerator.abs() };
                self.times(Self(inverse))
            }
            Long(fraction) => self.times(Self::from_big(fraction.recip())),
        }
    }

    /// Integer power by repeated squaring; 0 to a negative power follows floats. `None` for an
    /// exact power with a part of more than 1024 bits that is neither the number nor its inverse.
    #[must_use]
    pub fn power(&self, exponent: i64) -> Option<Self> {
        // Plus and minus one have powers of one digit.
        let n_bits = match &self.0 {
            Short { numerator, denominator } => {
                let longest = numerator.unsigned_abs().max(denominator.unsigned_abs());
                u64::from(longest.checked_ilog2().unwrap_or(0))
            }
            Long(fraction) => fraction.numer().bits().max(fraction.denom().bits()) - 1,
            Float(_) => 0,
        };
        let n_factors = exponent.unsigned_abs();
        if n_factors > 1 && n_bits.saturating_mul(n_factors) > MAX_POWER_BITS {
            return None;
        }
        let mut square = if exponent < 0 { Self::ONE.over(self) } else { self.clone() };
        let mut left = exponent.unsigned_abs();
        let mut result = Self::ONE;
        while left > 0 {
            if left & 1 == 1 {
                result = result.times_power(&square);
            }
            left >>= 1;
            if left > 0 {
                square = square.times_power(&square);
            }
        }
        Some(result)
    }

    /// The exact square root of a non-negative rational whose parts are perfect squares.
    pub fn exact_sqrt(&self) -> Option<Self> {
        if let Some((numerator, denominator)) = self.short_parts() {
            let root = |n: i64| n.checked_isqrt().filter(|root| root * root == n);
            let (numerator, denominator) = (root(numerator)?, root(denominator)?);
            return Some(Self(Short { numerator, denominator }));
        }
        let (numerator, denominator) = self.parts().filter(|parts| !parts.0.is_negative())?;
        let root = |n: BigInt| {
            let root = n.sqrt();
            (&root * &root == n).then_some(root)
        };
        Some(Self::of_parts(root(numerator)?, root(denominator)?))
    }

    /// Order by value; NaN compares equal to everything.
    pub fn order(&self, other: impl Borrow<Self>) -> Ordering {
        let other = other.borrow();
        if let (Some((p, q)), Some((r, s))) = (self.short_parts(), other.short_parts()) {
            return (i128::from(p) * i128::from(s)).cmp(&(i128::from(r) * i128::from(q)));
        }
        match (self.to_big(), other.to_big()) {
            (Some(a), Some(b)) => a.as_ref().cmp(b.as_ref()),
            _ => self.to_f64().partial_cmp(&other.to_f64()).unwrap_or(Ordering::Equal),
        }
    }

    /// Largest integer that is not above the value; `None` for a float.
    pub(crate) fn floor(&self) -> Option<Self> {
        match &self.0 {
            Short { numerator, denominator } => {
                Some(Self::integer(numerator.div_euclid(*denominator)))
            }
            Long(fraction) => Some(Self::from_big(fraction.floor())),
            Float(_) => None,
        }
    }

    /// The greatest number of which both are integer multiples; `None` where one is a float.
    pub(crate) fn gcd(&self, other: &Self) -> Option<Self> {
        // In lowest terms, gcd(p/q, r/s) = gcd(p, r) / lcm(q, s).
        if let (Some((p, q)), Some((r, s))) = (self.short_parts(), other.short_parts()) {
            let multiple = i128::from(q / common_divisor(q, s)) * i128::from(s);
            return Some(Self::of_wide_parts(i128::from(p.gcd(&r)), multiple));
        }
        let (a, b) = (self.to_big()?, other.to_big()?);
        let (numerator, denominator) = (a.numer().gcd(b.numer()), a.denom().lcm(b.denom()));
        Some(Self::from_big(BigRational::new_raw(numerator, denominator)))
    }

    /// True if the two differ by their sign at most.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Short { numerator: p, denominator: q }, Short { numerator: r, denominator: s }) => {
                p.unsigned_abs() == r.unsigned_abs() && q == s
            }
            (Long(a), Long(b)) => {
                a.numer().magnitude() == b.numer().magnitude() && a.denom() == b.denom()
            }
            (Short { .. }, Long(_)) | (Long(_), Short { .. }) => false,
            _ => self.over(other).magnitude().is_one(),
        }
    }

    /// True if it divides no number of 63 bits into an integer: its denominator is longer.
    pub(crate) fn has_long_denominator(&self) -> bool {
        matches!(&self.0, Long(fraction) if fraction.denom().bits() > 63)
    }
}

/// The greatest common divisor of an integer above `i64::MIN` and a positive one.
fn common_divisor(a: i64, b: i64) -> i64 {
    if b == 1 { 1 } else { a.gcd(&b) }
}

/// True if products of any two of these, and the sum of two such products, fit 64 bits: most do,
/// and 64-bit division is much faster.
fn are_tiny(parts: [i64; 4]) -> bool {
    parts.iter().all(|part| part.unsigned_abs() < 1 << 31)
}
