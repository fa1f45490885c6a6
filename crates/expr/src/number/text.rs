//! Numbers from text and back.

use super::{MAX_BITS, Number};
use num_bigint::BigInt;
use num_traits::{Signed, Zero};

/// Decimals printed before a fraction is preferred.
const DECIMALS: u32 = 12;
/// Digits of numerator or denominator from which a number is long: twice the decimals are printed,
/// or a power of ten.
const LONG_DIGITS: usize = 19;
/// Decimal digits that have at most [`MAX_BITS`] bits: a digit has less than 3.33 of them.
pub(crate) const MAX_DIGITS: u64 = MAX_BITS * 3 / 10;

/// The parts of a decimal literal.
struct Literal<'t> {
    whole: &'t str,
    fraction: &'t str,
    /// Sign and digits; empty where there is no exponent.
    exponent: &'t str,
}

impl<'t> Literal<'t> {
    fn of(text: &'t str) -> Option<Self> {
        let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, ""));
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let are_digits = |part: &str| part.bytes().all(|b| b.is_ascii_digit());
        let power = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
        let is_number = !(whole.is_empty() && fraction.is_empty())
            && [whole, fraction, power].into_iter().all(are_digits)
            && (mantissa.len() == text.len() || !power.is_empty());
        is_number.then_some(Self { whole, fraction, exponent })
    }
}

impl Number {
    /// True if text is an unsigned decimal literal, however long.
    pub(crate) fn is_literal(text: &str) -> bool {
        Literal::of(text).is_some()
    }

    /// Reads an unsigned decimal literal such as `12`, `0.125` or `6.7e-11`, exactly; `None` when
    /// the text is no number, or has more than some 19 000 digits written out.
    pub fn parse(text: &str) -> Option<Self> {
        let Literal { whole, fraction, exponent } = Literal::of(text)?;
        let exponent = if exponent.is_empty() { 0 } else { exponent.parse::<i64>().ok()? };
        let fraction = fraction.trim_end_matches('0');
        let digits = format!("{whole}{fraction}");
        let digits = digits.trim_start_matches('0');
        if digits.is_empty() {
            return Some(Self::ZERO);
        }
        let shift = exponent.checked_sub(i64::try_from(fraction.len()).ok()?)?;
        if (digits.len() as u64).checked_add(shift.unsigned_abs())? > MAX_DIGITS {
            return None;
        }
        let scale = u32::try_from(shift.unsigned_abs()).ok()?;
        // Usual literals fit 64 bits.
        let small = || Some((digits.parse::<i64>().ok()?, 10i64.checked_pow(scale)?));
        if let Some((digits, scale)) = small()
            && (shift < 0 || digits.checked_mul(scale).is_some())
        {
            let scale = Self::integer(scale);
            let digits = Self::integer(digits);
            return Some(if shift < 0 { digits.over(scale) } else { digits.times(scale) });
        }
        let (digits, scale) = (digits.parse::<BigInt>().ok()?, BigInt::from(10).pow(scale));
        let one = BigInt::from(1);
        let value = if shift < 0 {
            Self::of_parts(digits, scale)
        } else {
            Self::of_parts(digits * scale, one)
        };
        Some(value)
    }

    /// All of the number: `-3`, `22/7`, or the sixteen hexadecimal digits of a float, `#3ff8000000000000`.
    pub(crate) fn listed(&self) -> String {
        let Some((numerator, denominator)) = self.parts() else {
            return format!("#{:016x}", self.to_f64().to_bits());
        };
        if denominator == BigInt::from(1) {
            return numerator.to_string();
        }
        format!("{numerator}/{denominator}")
    }

    /// Reads what [`Number::listed`] writes; `None` for any other text.
    pub(crate) fn of_listed(text: &str) -> Option<Self> {
        if let Some(bits) = text.strip_prefix('#') {
            return u64::from_str_radix(bits, 16)
                .ok()
                .map(|bits| Self::float(f64::from_bits(bits)));
        }
        if text.len() as u64 > 2 * MAX_DIGITS {
            return None;
        }
        let (numerator, denominator) = text.split_once('/').unwrap_or((text, "1"));
        let (numerator, denominator) =
            (numerator.parse::<BigInt>().ok()?, denominator.parse::<BigInt>().ok()?);
        (denominator.is_positive()).then(|| Self::of_parts(numerator, denominator))
    }

    /// Digits of a terminating decimal of at most [`DECIMALS`] decimals, or of more where the
    /// fraction would be no shorter; otherwise `None`.
    fn decimal(&self) -> Option<String> {
        let Some((numerator, denominator)) = self.short_parts() else {
            return self.long_decimal();
        };
        if denominator == 1 {
            return Some(numerator.to_string());
        }
        let is_long = numerator.unsigned_abs() >= 10u64.pow(DECIMALS);
        let most = if is_long { 2 * DECIMALS } else { DECIMALS };
        let (n, d) = (i128::from(numerator), i128::from(denominator));
        let n_decimals = (0..=most).find(|&n| 10i128.pow(n) % d == 0)?;
        let scaled = n.checked_mul(10i128.pow(n_decimals) / d)?;
        Some(with_point(scaled < 0, &scaled.unsigned_abs().to_string(), n_decimals as usize))
    }

    /// A long number as an integer or decimal, with a power of ten where that is shorter; `None`
    /// where a fraction is.
    fn long_decimal(&self) -> Option<String> {
        let (numerator, denominator) = self.parts()?;
        // The denominator divides a power of ten if it has the prime factors 2 and 5 alone.
        let twos = denominator.trailing_zeros().unwrap_or(0);
        let mut rest: BigInt = &denominator >> twos;
        let mut fives = 0;
        while (&rest % 5u32).is_zero() {
            rest /= 5u32;
            fives += 1;
        }
        if rest != BigInt::from(1) {
            return None;
        }
        let n_decimals = u32::try_from(twos.max(fives)).ok()?;
        let scaled = &numerator * (BigInt::from(10).pow(n_decimals) / &denominator);
        let (is_negative, digits) = (scaled.is_negative(), scaled.magnitude().to_string());
        let n_decimals = n_decimals as usize;
        let sign = if is_negative { "-" } else { "" };

        // The shortest of the digits with a power of ten, the decimal, and the fraction.
        let significant = digits.trim_end_matches('0');
        let exponent = (digits.len() - 1).cast_signed() - n_decimals.cast_signed();
        let scientific = match significant.split_at(1) {
            (first, "") => format!("{sign}{first}e{exponent}"),
            (first, rest) => format!("{sign}{first}.{rest}e{exponent}"),
        };
        let decimal = with_point(is_negative, &digits, n_decimals);
        let is_far = exponent.unsigned_abs() >= LONG_DIGITS;
        let fraction = if n_decimals == 0 {
            usize::MAX
        } else {
            numerator.to_string().len() + denominator.to_string().len() + 1
        };
        let best = if is_far && scientific.len() < decimal.len() { scientific } else { decimal };
        (best.len() <= fraction).then_some(best)
    }
}

/// Digits with a decimal point before the last `n_decimals` of them.
fn with_point(is_negative: bool, digits: &str, n_decimals: usize) -> String {
    let sign = if is_negative { "-" } else { "" };
    if n_decimals == 0 {
        return format!("{sign}{digits}");
    }
    let digits = format!("{digits:0>width$}", width = n_decimals + 1);
    let (whole, fraction) = digits.split_at(digits.len() - n_decimals);
    format!("{sign}{whole}.{fraction}")
}

/// Integers and short decimals as decimals, other rationals as `p/q`, floats in shortest form.
impl std::fmt::Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(value) = self.as_float() {
            return match value {
                value if value.is_finite() => write!(f, "{value:?}"),
                // The text form has no literal for these; the quotients read back as the same
                // value.
                value if value.is_nan() => f.write_str("0/0"),
                value => f.write_str(if value > 0.0 { "1/0" } else { "-1/0" }),
            };
        }
        match (self.decimal(), self.parts()) {
            (Some(decimal), _) => f.write_str(&decimal),
            (None, Some((numerator, denominator))) => write!(f, "{numerator}/{denominator}"),
            (None, None) => unreachable!("every number is a float or a fraction"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_literals_are_exact() {
        assert_eq!(Number::parse("0.125"), Some(Number::rational(1, 8)));
        assert_eq!(Number::parse("9.81"), Some(Number::rational(981, 100)));
        assert_eq!(Number::parse("2.5e-3"), Some(Number::rational(1, 400)));
        assert_eq!(Number::parse("1e400"), Number::parse("10e399"));
        assert_eq!(Number::parse("000.00e99"), Some(Number::ZERO));
        assert_eq!(Number::parse("1.2.3"), None);
        assert_eq!(Number::parse("."), None);
    }

    #[test]
    fn literals_too_long_to_write_out_are_refused() {
        for text in ["1e99999", "1e-99999", "1e999999999999999999", "1e99999999999999999999"] {
            assert_eq!(Number::parse(text), None, "{text}");
        }
    }

    #[test]
    fn numbers_print_as_decimals_when_they_terminate() {
        let text = |n, d| Number::rational(n, d).to_string();
        assert_eq!(text(1, 4), "0.25");
        assert_eq!(text(-1, 400), "-0.0025");
        assert_eq!(text(1, 3), "1/3");
        assert_eq!(text(-7, 1), "-7");
        let long = Number::parse("38.302222155949").expect("a decimal");
        assert_eq!(long.to_string(), "38.302222155949");
        assert_eq!(long.times(Number::rational(1, 500)).to_string(), "0.076604444311898");
    }

    #[test]
    fn long_numbers_print_in_the_shortest_way_and_read_back() {
        for (text, expected) in [
            ("1e400", "1e400"),
            ("1e20", "1e20"),
            ("10000000000000000001", "10000000000000000001"),
            ("1.0000000000000000000001", "1.0000000000000000000001"),
            ("12.5e-30", "1.25e-29"),
        ] {
            let number = Number::parse(text).expect(text);
            assert_eq!(number.to_string(), expected);
            assert_eq!(Number::parse(expected), Some(number.clone()));
            assert_eq!(number.negated().to_string(), format!("-{expected}"));
        }
        let half = Number::rational(3, 2).power(60).expect("short enough");
        assert_eq!(half.to_string(), "42391158275216203514294433201/1152921504606846976");
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
            let number = Number::parse(&text).map(|number| number.to_f64());
            assert_eq!(number.map(f64::to_bits), Some(value.to_bits()), "{text}");
        }
    }
}
