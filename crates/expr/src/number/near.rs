//! Numbers as a person writes them: 1/75 in place of 0.013333333333333334.

use super::Number;

/// Significant digits from which a number looks like the result of a computation.
const COMPUTED_DIGITS: usize = 15;
/// Relative distance that a few roundings of a float explain: nine units of its last place.
const FEW_ROUNDINGS: f64 = 2e-15;
/// Largest product of numerator and denominator: a float that is no fraction has one as near as
/// [`FEW_ROUNDINGS`] with a chance of about one in 50 000, and a decimal of ten digits with one in 100 000.
const LARGEST_PRODUCT: f64 = 1e10;

impl Number {
    /// The decimal of at most ten digits, or else the small fraction, that a number of many digits
    /// is within rounding; `None` where it has few digits, or nothing is so near.
    pub(crate) fn as_written(&self) -> Option<Self> {
        let text = self.magnitude().to_string();
        let digits = text.split('e').next().unwrap_or_default().replace('.', "");
        let value = self.to_f64();
        let is_computed = digits.trim_matches('0').len() >= COMPUTED_DIGITS;
        if !is_computed || digits.contains('/') || !value.is_finite() {
            return None;
        }
        let is_near = |other: f64| (other - value).abs() <= FEW_ROUNDINGS * value.abs();
        let decimal = format!("{:.9e}", value.abs());
        let decimal = Self::parse(&decimal).filter(|n| is_near(n.to_f64().copysign(value)));
        let written = decimal.or_else(|| fraction_of(value.abs()))?;
        Some(if value < 0.0 { written.negated() } else { written })
    }
}

/// The first convergent of the continued fraction of a positive number that is within rounding of it.
fn fraction_of(value: f64) -> Option<Number> {
    let (mut before, mut now) = ([0.0, 1.0], [1.0, 0.0]);
    let mut rest = value;
    loop {
        let whole = rest.floor();
        let next = [0, 1].map(|i| whole * now[i] + before[i]);
        let [numerator, denominator] = next;
        if numerator * denominator > LARGEST_PRODUCT {
            return None;
        }
        if (numerator / denominator - value).abs() <= FEW_ROUNDINGS * value {
            #[expect(clippy::cast_possible_truncation, reason = "integers below LARGEST_PRODUCT")]
            return Some(Number::rational(numerator as i64, denominator as i64));
        }
        (before, now) = (now, next);
        rest = 1.0 / (rest - whole);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn computed_digits_become_short_decimals_and_fractions() {
        let written = |value: f64| Number::float(value).as_written().map(|n| n.to_string());
        for (value, expected) in [
            (73.0 / 2400.0, "73/2400"),
            (-1.0 / 75.0, "-1/75"),
            (0.036_450_000_000_000_024, "0.03645"),
            (213_499.999_999_999_97, "213500"),
            (0.999_999_999_999_999_9, "1"),
            (1.0 / 12_000.0, "1/12000"),
        ] {
            assert_eq!(written(value).as_deref(), Some(expected), "{value}");
        }
        // What was measured, and what is no fraction.
        for value in [
            0.0137,
            9.81,
            1.234_567_891_23,
            0.123_456_789_012_345,
            std::f64::consts::FRAC_PI_4,
            std::f64::consts::SQRT_2,
        ] {
            assert_eq!(written(value), None, "{value}");
        }
        let long = Number::parse("0.03041666666666666633").expect("a decimal");
        assert_eq!(long.as_written(), Some(Number::rational(73, 2400)));
        assert_eq!(Number::rational(3541, 96000).as_written(), None);
    }

    #[test]
    fn hardly_a_random_float_is_near_a_small_fraction() {
        let mut bits = 1u64;
        let hits = (0..20_000).filter(|_| {
            // Xorshift: G. Marsaglia, J. Stat. Softw. 8 (2003).
            bits ^= bits << 13;
            bits ^= bits >> 7;
            bits ^= bits << 17;
            let value = f64::from_bits((1023 << 52) | (bits >> 12));
            Number::float(value).as_written().is_some()
        });
        assert!(hits.count() <= 3);
    }
}
