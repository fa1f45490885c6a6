//! Times on the command line.

use bksim::analysis::quantity;

/// A time: `2` in seconds, or with a unit as in a model, `2 s`, `500ms`.
pub(super) fn time(text: &str) -> Result<f64, String> {
    // A bare number is taken as it is; its user knows the range.
    let bare = text.trim().parse::<f64>().ok();
    bare.or_else(|| quantity(text, "s").ok()).ok_or_else(|| {
        let point = if text.contains(',') { "; decimals have a point" } else { "" };
        format!("expected a time, in seconds or with its unit, such as 2, `2 s` or `500 ms`{point}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_has_a_unit_as_in_a_model_or_is_in_seconds() {
        for (text, expected) in [
            ("2", 2.0),
            ("2s", 2.0),
            ("2 s", 2.0),
            ("500ms", 0.5),
            ("-1 min", -60.0),
            ("1e-3", 1e-3),
        ] {
            assert_eq!(time(text), Ok(expected), "{text}");
        }
        assert!(time("0,5 s").expect_err("a comma").ends_with("decimals have a point"));
        for text in ["2 m", "s", "", "2 s s", "2 parsecs", "1..2"] {
            assert!(time(text).is_err(), "{text}");
        }
    }
}
