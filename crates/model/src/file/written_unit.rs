//! A unit as it stands after a number: `mm`, `N m/rad`.

use bksim_expr::{ParseOptions, SyntaxKind, UnitFactor, parse};

use super::dimension::Dimension;
use super::units::{Scale, find_unit};

/// No quantity of mechanics has a higher power of a unit.
pub(super) const MAX_UNIT_EXPONENT: i32 = 12;

/// A product of powers of units.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct WrittenUnit {
    pub(super) scale: Scale,
    pub(super) dimension: Dimension,
    pub(super) is_angle: bool,
}

impl WrittenUnit {
    /// The unit of this text; `None` when it is none.
    ///
    /// ```
    /// use bksim_model::file::WrittenUnit;
    ///
    /// let unit = WrittenUnit::parse("N mm").expect("a unit");
    /// assert_eq!(unit.to_si(250.0), 0.25);
    /// assert_eq!(WrittenUnit::parse("quux"), None);
    /// ```
    pub fn parse(text: &str) -> Option<Self> {
        // As dimensions are printed: `V/(A s)`.
        let parts = text.trim_end().strip_suffix(')').and_then(|rest| rest.split_once("/("));
        let text = parts.map_or_else(
            || text.to_owned(),
            |(over, under)| {
                format!("{over}/{}", under.split_whitespace().collect::<Vec<_>>().join("/"))
            },
        );
        let text = join_units(&format!("1 {text}"));
        let is_unit = |name: &str| find_unit(name).is_some();
        let options = ParseOptions { max_depth: 1, is_unit: &is_unit, is_name: &|_| false };
        let syntax = parse(&text, &options).ok()?;
        match syntax.nodes.as_slice() {
            [node] => match &node.kind {
                SyntaxKind::Quantity { factors, .. } => Self::of(factors),
                _ => None,
            },
            _ => None,
        }
    }

    /// The unit that these factors are.
    pub(super) fn of(factors: &[UnitFactor]) -> Option<Self> {
        let mut whole = Self { scale: Scale::ONE, dimension: Dimension::NONE, is_angle: true };
        for factor in factors {
            let unit = find_unit(&factor.name)?;
            let exponent = factor.exponent;
            if exponent.abs() > MAX_UNIT_EXPONENT {
                return None;
            }
            whole.scale = whole.scale.times(unit.scale.powi(exponent));
            let power = unit.dimension.power(f64::from(exponent))?;
            whole.dimension = whole.dimension.times(power);
            whole.is_angle &= unit.is_angle;
        }
        Some(whole)
    }

    /// A number in this unit in SI, as the reader of model files converts it.
    pub fn to_si(&self, number: f64) -> f64 {
        self.scale.apply(number)
    }

    /// The SI unit of the same quantity, as text.
    pub fn si(&self) -> String {
        let unit = self.dimension.to_string();
        if unit.is_empty() && self.is_angle { "rad".to_owned() } else { unit }
    }
}

/// Puts `*` for the last space between two units, so that `N m` is read as `N*m`; no character moves.
pub(super) fn join_units(text: &str) -> String {
    let is_word = |c: char| c.is_alphanumeric() || c == '_' || c == '.' || c == '°';
    let mut joined = text.as_bytes().to_vec();
    let starts = text.char_indices().filter(|&(at, c)| {
        is_word(c) && text[..at].ends_with(' ') && !text[..at].trim_end().is_empty()
    });
    for (at, _) in starts {
        let before = text[..at].trim_end();
        let after = text[at..].split(|c| !is_word(c)).next().unwrap_or_default();
        let is_call = text[at + after.len()..].trim_start().starts_with('(');
        let last = &before[before.rfind(|c| !is_word(c)).map_or(0, |location| {
            location + before[location..].chars().next().map_or(1, char::len_utf8)
        })..];
        // The exponent of a unit: `m^2 s`.
        let power =
            before.strip_suffix(last).and_then(|rest| rest.trim_end_matches('-').strip_suffix('^'));
        let unit = power.map_or(last, |rest| {
            &rest[rest.rfind(|c| !is_word(c)).map_or(0, |location| {
                location + rest[location..].chars().next().map_or(1, char::len_utf8)
            })..]
        });
        // `25mm m`: a number may touch its unit.
        let unit = unit.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
        if find_unit(unit).is_some() && find_unit(after).is_some() && !is_call {
            joined[at - 1] = b'*';
        }
    }
    String::from_utf8(joined).expect("ASCII was put for ASCII")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_space_between_units_multiplies() {
        let cases = [
            ("0.2 kg m^2", "0.2 kg*m^2"),
            ("5 N m/rad", "5 N*m/rad"),
            ("3 N  s", "3 N *s"),
            ("2 m^2 kg", "2 m^2*kg"),
            ("25 mm", "25 mm"),
            ("2 m + 3 s", "2 m + 3 s"),
            ("2 N min (3)", "2 N min (3)"),
            ("µm é ° m", "µm é °*m"),
        ];
        for (text, expected) in cases {
            assert_eq!(join_units(text), expected, "{text}");
        }
    }
}
