//! Times on the command line.

use bksim::analysis::quantity;

/// A time: `2` in seconds, or with a unit as in a model, `2 s`, `500ms`.
pub(super) fn time(text: &str) -> Result<f64, String> {
    // A bare number is taken as it is; whoever uses it knows its range.
    let bare = text.trim().parse::<f64>().ok();
    bare.or_else(|| quantity(text, "s").ok()).ok_or_else(|| {
        "expected a time, in seconds or with its unit, such as 2, `2 s` or `500 ms`".to_owned()
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
        for text in ["2 m", "s", "", "2 s s", "2 parsecs", "1..2"] {
            assert!(time(text).is_err(), "{text}");
        }
    }
}
