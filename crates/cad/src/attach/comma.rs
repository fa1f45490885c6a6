//! Decimal commas: `9,81` is a number in half of the world's drawings, and a list in a model file.
//!
//! A comma between two digits, outside of parentheses, is taken for neither: the author is asked. Commas
//! that separate the parts of a vector or a list have a space after them, or stand in brackets.

use bksim_model::diagnostic::Diagnostic;

use crate::codes;
use crate::kind::Kind;

/// Keys that take a vector of two parts.
const VECTORS: [&str; 2] = ["vector", "acceleration"];

/// Keys that take a list of any length.
const LISTS: [&str; 1] = ["times"];

/// Keys whose values are names, which may have commas between them.
const NAMES: [&str; 13] = [
    "name",
    "body",
    "body1",
    "body2",
    "bodies",
    "point",
    "point1",
    "point2",
    "joint",
    "from",
    "about",
    "coordinate",
    "coordinates",
];

/// The fault of a value with a comma that may be a decimal comma.
pub(super) fn decimal_comma(kind: &Kind, key: &str, text: &str) -> Option<Diagnostic> {
    let commas = Commas::of(text);
    if commas.tight.is_empty() || NAMES.contains(&key) {
        return None;
    }
    // In brackets, or as three parts and more, commas that are all alike can be nothing but separators.
    let (is_vector, is_list) = (VECTORS.contains(&key), LISTS.contains(&key));
    let is_bracketed = text.trim().starts_with('[') && text.trim().ends_with(']');
    let is_plain = commas.n_loose == 0 && (is_bracketed || is_list && commas.tight.len() > 1);
    if (is_vector || is_list) && is_plain {
        return None;
    }

    let message = format!("`{key}` of {} is `{text}`, with a comma between digits", kind.name);
    let fault = Diagnostic::error(codes::DECIMAL_COMMA, message);
    let number = with_points(text.trim().trim_start_matches('[').trim_end_matches(']'));
    let is_pair = (is_vector || is_list) && commas.tight.len() == 1 && commas.n_loose == 0;
    Some(if is_pair {
        let spaced = text.trim().replacen(',', ", ", 1);
        let what = if is_vector { "a vector of two components" } else { "a list" };
        fault.help(format!("write `{number}` for a number, `[{spaced}]` for {what}"))
    } else {
        fault.help(format!("write `{number}`: decimals begin with a point"))
    })
}

/// The commas and semicolons of a text that stand in no parentheses.
struct Commas {
    /// Positions of those between two digits.
    tight: Vec<usize>,
    n_loose: usize,
}

impl Commas {
    fn of(text: &str) -> Self {
        let (mut tight, mut n_loose, mut depth) = (Vec::new(), 0, 0_usize);
        for (at, letter) in text.char_indices() {
            match letter {
                '(' => depth += 1,
                ')' => depth = depth.saturating_sub(1),
                ',' if depth == 0 && is_between_digits(text, at) => tight.push(at),
                ',' | ';' if depth == 0 => n_loose += 1,
                _ => (),
            }
        }
        Self { tight, n_loose }
    }
}

fn is_between_digits(text: &str, at: usize) -> bool {
    let is_digit = |letter: Option<char>| letter.is_some_and(|it| it.is_ascii_digit());
    is_digit(text[..at].chars().next_back()) && is_digit(text[at + 1..].chars().next())
}

/// The text with a point for every decimal comma, and without separators of thousands.
fn with_points(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(start) = rest.find(|it: char| it.is_ascii_digit()) {
        let tail = &rest[start..];
        let is_part = |it: char| it.is_ascii_digit() || it == '.' || it == ',';
        let end = tail.find(|it: char| !is_part(it)).unwrap_or(tail.len());
        let number = tail[..end].trim_end_matches([',', '.']);
        out.push_str(&rest[..start]);
        out.push_str(&number_with_point(number));
        rest = &tail[number.len()..];
    }
    out + rest
}

/// One number: of points and commas the last one begins the decimals, unless there are several of it.
fn number_with_point(number: &str) -> String {
    let (points, commas) = (number.matches('.').count(), number.matches(',').count());
    let is_decimal = |mark: char| match mark {
        ',' => commas == 1 && number.rfind(',') > number.rfind('.'),
        _ => points == 1 && number.rfind('.') > number.rfind(','),
    };
    let digits = number.chars().filter_map(|letter| match letter {
        '.' | ',' if is_decimal(letter) => Some('.'),
        '.' | ',' => None,
        digit => Some(digit),
    });
    digits.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::by_name;

    #[track_caller]
    fn help(kind: &str, key: &str, text: &str) -> Option<String> {
        let kind = by_name(kind).expect("a kind");
        decimal_comma(kind, key, text).map(|fault| fault.help.expect("every one has a help"))
    }

    #[test]
    fn a_comma_between_digits_is_asked_about() {
        let cases = [
            ("9,81", "write `9.81` for a number, `[9, 81]` for a vector of two components"),
            (
                "9,81 m/s^2",
                "write `9.81 m/s^2` for a number, `[9, 81 m/s^2]` for a vector of two components",
            ),
            ("0, -9,81", "write `0, -9.81`: decimals begin with a point"),
        ];
        for (text, expected) in cases {
            assert_eq!(help("gravity", "acceleration", text).as_deref(), Some(expected), "{text}");
        }
        for (text, expected) in [
            ("7,85 g/cm^3", "write `7.85 g/cm^3`: decimals begin with a point"),
            ("1.234,5 kg/m^3", "write `1234.5 kg/m^3`: decimals begin with a point"),
            ("7,850,000 g/m^3", "write `7850000 g/m^3`: decimals begin with a point"),
        ] {
            assert_eq!(help("body", "density", text).as_deref(), Some(expected), "{text}");
        }
        assert!(help("drive", "motion", "50 deg + 6,28*t").is_some());
        assert!(help("solve", "times", "0,5").is_some());
    }

    #[test]
    fn commas_of_vectors_lists_functions_and_names_are_none() {
        for text in ["0, -9.81", "[9, 81]", "[9,81]", "12 N, 0", "0,-9.81 m/s^2"] {
            assert_eq!(help("gravity", "acceleration", text), None, "{text}");
        }
        assert_eq!(help("solve", "times", "0,1,2"), None);
        assert_eq!(help("drive", "motion", "atan2(1,2)*t"), None);
        assert_eq!(help("model", "name", "press 3,5"), None);
    }
}
