//! Numbers with units as a model file writes them.

use bksim_model::file::WrittenUnit;

use crate::places::Places;

/// Digits of a length or angle that a hand gives.
const DIGITS: usize = 6;

/// A number with the unit behind it, as text.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Literal {
    pub(crate) number: f64,
    /// Empty where there is none.
    pub(crate) unit: String,
}

/// Reads `250 mm`, `-1e3`, `30 deg`; `None` for formulas.
pub(crate) fn literal(text: &str) -> Option<Literal> {
    let text = text.trim();
    let is_number = |end: &usize| text[..*end].trim().parse::<f64>().is_ok_and(f64::is_finite);
    let ends = text.char_indices().map(|(at, _)| at).chain([text.len()]);
    let end = ends.rev().find(is_number)?;
    let number = text[..end].trim();
    // Words that Rust takes for numbers are names here.
    if !number.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.')) {
        return None;
    }
    let unit = text[end..].trim();
    let is_unit = unit.is_empty() || (!unit.contains('*') && WrittenUnit::parse(unit).is_some());
    is_unit.then(|| Literal { number: number.parse().unwrap_or(f64::NAN), unit: unit.to_owned() })
}

/// The shortest number with [`DIGITS`] digits.
pub(crate) fn rounded(number: f64) -> f64 {
    let text = format!("{number:.*e}", DIGITS - 1);
    text.parse().unwrap_or(number)
}

/// A number as TOML and expressions write it: no exponent where that is short.
pub(crate) fn written(number: f64) -> String {
    let number = if number == 0.0 { 0.0 } else { number };
    let plain = format!("{number}");
    if plain.len() <= 14 { plain } else { format!("{number:e}") }
}

/// A value in SI in a unit.
pub(crate) fn in_unit(si: f64, unit: &str) -> f64 {
    match WrittenUnit::parse(unit) {
        Some(parsed) if parsed.to_si(1.0) != 0.0 => si / parsed.to_si(1.0),
        _ => si,
    }
}

/// The unit of bare lengths or angles of a text: `key` is `length` or `angle`.
pub(crate) fn file_unit(places: &Places<'_>, key: &str) -> String {
    let default = if key == "length" { "m" } else { "rad" };
    let stated = places.find(&["units", key]).and_then(|place| places.quoted(place));
    stated.unwrap_or(default).to_owned()
}

/// A length as a drawn element has it: `120 mm`.
pub(crate) fn length(metres: f64) -> String {
    format!("{} mm", written(rounded_to(metres * 1e3, 1e3)))
}

/// An angle as a drawn element has it: `30 deg`.
pub(crate) fn angle(radians: f64) -> String {
    format!("{} deg", written(rounded_to(radians.to_degrees(), 1e4)))
}

/// Rounded to a part of one.
fn rounded_to(number: f64, parts: f64) -> f64 {
    (number * parts).round() / parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_are_numbers_with_units_and_formulas_are_none() {
        let read = |text: &str| literal(text).map(|l| (l.number, l.unit));
        assert_eq!(read("250 mm"), Some((250.0, "mm".to_owned())));
        assert_eq!(read("-1e3"), Some((-1e3, String::new())));
        assert_eq!(read("9.81 m/s^2"), Some((9.81, "m/s^2".to_owned())));
        for formula in ["l1/2", "2*l1", "infinity", "nan", "3 quux", "60 deg + 2 rad/s*t", "-l"] {
            assert_eq!(read(formula), None, "{formula}");
        }
        assert_eq!(length(0.123_456_789), "123.457 mm");
        assert_eq!(angle(std::f64::consts::FRAC_PI_6), "30 deg");
        assert_eq!(written(-0.0), "0");
    }
}
