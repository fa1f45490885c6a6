//! Numbers as people read them.

use bksim_model::message::plain;

/// A number for a report: nine significant digits, no trailing zeros.
pub fn number(value: f64) -> String {
    plain(value, 9, 1e9).unwrap_or_else(|| format!("{value:.3e}"))
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
