//! Numbers as people read them.

/// A number for a report: nine significant digits, no trailing zeros.
pub fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let magnitude = value.abs();
    if !(1e-4..1e9).contains(&magnitude) {
        return format!("{value:.3e}");
    }
    #[expect(clippy::cast_possible_truncation, reason = "the exponent is between -4 and 9")]
    let decimals = usize::try_from(8 - magnitude.log10().floor() as i32).unwrap_or(0);
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_nine_digits_and_no_zeros() {
        let cases = [
            (0.0, "0"),
            (25.0, "25"),
            (1.0 / 3.0, "0.333333333"),
            (-1_963.210_17, "-1963.21017"),
            (2e-5, "2.000e-5"),
            (-0.0, "0"),
        ];
        for (value, expected) in cases {
            assert_eq!(number(value), expected);
        }
    }
}
