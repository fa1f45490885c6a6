//! Numbers in a window: few digits, and of constant width.

/// Significant digits of a value.
const DIGITS: i32 = 5;

/// Decimals of an instant, which resolve a thousandth of the span.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 9")]
pub(super) fn decimals(span: [f64; 2]) -> usize {
    let length = (span[1] - span[0]).abs();
    if length > 0.0 { (3.0 - length.log10().floor()).clamp(0.0, 9.0) as usize } else { 3 }
}

/// A value with five significant digits.
pub(super) fn value(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.abs().to_string();
    }
    if !(1e-4..1e6).contains(&x.abs()) {
        return format!("{x:.3e}");
    }
    #[expect(clippy::cast_possible_truncation, reason = "-4 to 6")]
    let magnitude = x.abs().log10().floor() as i32;
    let decimals = (DIGITS - 1 - magnitude).max(0).unsigned_abs() as usize;
    format!("{x:.decimals$}")
}

/// A speed: `0.05×`, `1×`, `20×`.
pub(super) fn speed(factor: f64) -> String {
    format!("{factor}×")
}

/// The largest of 1, 2 and 5 times a power of ten that is at most `x`.
pub(super) fn round_below(x: f64) -> f64 {
    if !(x.is_finite() && x > 0.0) {
        return 0.0;
    }
    let power = 10f64.powf(x.log10().floor());
    let slack = 1.0 + 1e-9;
    let steps = [10.0, 5.0, 2.0, 1.0];
    let step = steps.into_iter().find(|step| step * power <= x * slack);
    step.unwrap_or(1.0) * power
}

/// A round number with the prefix of its unit: `20 mm`, `0.5 m`, `50 N`, `2 kN`.
pub(super) fn quantity(x: f64, unit: &str) -> String {
    let prefixes = [(1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ")];
    let (factor, prefix) = prefixes
        .into_iter()
        .find(|(factor, _)| x.abs() >= factor * (1.0 - 1e-9))
        .unwrap_or((1e-9, "n"));
    // Rounds away errors of the division: 0.3 of 1e-3 is 300.00000000000006.
    let number = (x / factor * 1e6).round() / 1e6;
    format!("{number} {prefix}{unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_have_the_decimals_that_their_span_needs() {
        let cases = [
            ([0.0, 2.0], 3),
            ([0.0, 100.0], 1),
            ([5.0, 0.0], 3),
            ([0.0, 1e-3], 6),
            ([1.0, 1.0], 3),
        ];
        for (span, expected) in cases {
            assert_eq!(decimals(span), expected, "{span:?}");
        }
    }

    #[test]
    fn values_keep_five_digits() {
        let cases = [
            (0.0, "0"),
            (-1.5, "-1.5000"),
            (123.456_78, "123.46"),
            (1.0 / 3.0, "0.33333"),
            (2e-7, "2.000e-7"),
            (-3e7, "-3.000e7"),
            (f64::NAN, "NaN"),
        ];
        for (x, expected) in cases {
            assert_eq!(value(x), expected);
        }
    }

    #[test]
    fn scales_are_round_and_written_with_prefixes() {
        let cases = [
            (0.0237, "20 mm"),
            (0.05, "50 mm"),
            (9.99, "5 m"),
            (1.0, "1 m"),
            (1234.0, "1 km"),
            (3e-5, "20 µm"),
        ];
        for (x, expected) in cases {
            assert_eq!(quantity(round_below(x), "m"), expected, "{x}");
        }
        for x in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(round_below(x), 0.0);
        }
    }
}
