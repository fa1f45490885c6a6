//! Numbers and names as messages write them.

use std::fmt::Display;

/// A number for a message: six significant digits, no trailing zeros.
pub fn short(value: f64) -> String {
    plain(value, 6, 1e7).unwrap_or_else(|| {
        let text = format!("{value:.5e}");
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
        format!("{mantissa}e{exponent}")
    })
}

/// A number with this many significant digits, no trailing zeros and no power of ten; `None` where its size is less
/// than 1e-4 or not less than `most`, at most 1e15.
pub fn plain(value: f64, digits: i32, most: f64) -> Option<String> {
    if value == 0.0 {
        return Some("0".into());
    }
    if !value.is_finite() {
        return Some(value.to_string());
    }
    let magnitude = value.abs();
    if !(1e-4..most).contains(&magnitude) {
        return None;
    }
    #[expect(clippy::cast_possible_truncation, reason = "the exponent is between -4 and 15")]
    let decimals = usize::try_from(digits - 1 - magnitude.log10().floor() as i32).unwrap_or(0);
    let text = format!("{value:.decimals$}");
    let shorter = || text.trim_end_matches('0').trim_end_matches('.').to_owned();
    Some(if text.contains('.') { shorter() } else { text })
}

/// `a`, `b` and `c`, each in backticks.
pub fn listed(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.as_slice() {
        [] => String::new(),
        [only] => only.clone(),
        [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
    }
}

/// Number of things in words: `1 body`, `3 bodies`.
pub fn counted<N: Copy + Display + PartialEq + From<u8>>(n: N, one: &str, many: &str) -> String {
    let what = if n == N::from(1) { one } else { many };
    format!("{n} {what}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_thing_is_no_plural() {
        assert_eq!(
            [0_u64, 1, 2].map(|n| counted(n, "body", "bodies")),
            ["0 bodies", "1 body", "2 bodies"]
        );
    }

    #[test]
    fn numbers_of_messages_are_short() {
        let cases = [(0.4, "0.4"), (0.399_999_999_999, "0.4"), (123_456.0, "123456"), (0.0, "0")];
        for (value, expected) in cases {
            assert_eq!(short(value), expected);
        }
        assert_eq!(short(1.25e-9), "1.25e-9");
        assert_eq!(short(f64::INFINITY), "inf");
    }
}
