//! Sizes of files on the command line.

/// Units of sizes, the longest first.
const UNITS: [(&str, f64); 9] = [
    ("kib", 1024.0),
    ("mib", 1_048_576.0),
    ("gib", 1_073_741_824.0),
    ("tib", 1_099_511_627_776.0),
    ("kb", 1e3),
    ("mb", 1e6),
    ("gb", 1e9),
    ("tb", 1e12),
    ("b", 1.0),
];

/// A size in bytes: `500000`, `500 kB`, `2GB`, `1.5 GiB`; at least 1 kB.
pub(super) fn log_size(text: &str) -> Result<u64, String> {
    const LEAST: f64 = 1e3;
    const MOST: f64 = 1e18;
    let small = text.trim().to_ascii_lowercase();
    let in_unit = |&(unit, size): &(&str, f64)| small.strip_suffix(unit).map(|rest| (rest, size));
    let (number, unit) = UNITS.iter().find_map(in_unit).unwrap_or((&small, 1.0));
    let bytes = number.trim().parse::<f64>().ok().map(|number| number * unit);
    match bytes.filter(|bytes| (LEAST..=MOST).contains(bytes)) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "up to 1e18")]
        Some(bytes) => Ok(bytes as u64),
        None => Err("expected a size from 1kB on, such as 500MB or 2GB".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_is_in_bytes_or_has_a_unit() {
        for (text, expected) in [
            ("500000", 500_000),
            ("500 kB", 500_000),
            ("2GB", 2_000_000_000),
            ("1.5 GiB", 1_610_612_736),
            ("64000b", 64_000),
            ("1e9", 1_000_000_000),
        ] {
            assert_eq!(log_size(text), Ok(expected), "{text}");
        }
        for text in ["", "GB", "-1GB", "10", "nan", "inf", "1e30", "2 parsecs", "0.9 kB"] {
            assert!(log_size(text).is_err(), "{text}");
        }
    }
}
