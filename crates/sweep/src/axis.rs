//! One varied quantity and the values it takes.
//!
//! ```text
//! 0.8:1.2:41          41 values at even distances, both ends among them
//! 80 mm:120 mm:41     with a unit, which holds for all numbers
//! 1:1000:4:log        at even ratios: 1, 10, 100, 1000
//! 0.8, 0.9, 1.3       these
//! 0.8:1.2             anything between, for samples
//! ```

use bksim::model::diagnostic::Diagnostic;
use bksim::model::file::WrittenUnit;

use crate::codes;

/// How values lie between two ends.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Spacing {
    /// At even distances.
    Linear,
    /// At even ratios.
    Log,
}

/// The values of an axis, numbers in its unit.
#[derive(Clone, PartialEq, Debug)]
pub enum Values {
    /// These.
    List(Vec<f64>),
    /// Values evenly from one end to the other.
    Even {
        /// The first.
        from: f64,
        /// The last.
        to: f64,
        /// How many, at least two.
        n: u64,
        /// How they lie.
        spacing: Spacing,
    },
    /// Anything between two ends, for samples.
    Range {
        /// One end.
        from: f64,
        /// The other.
        to: f64,
        /// How samples lie.
        spacing: Spacing,
    },
}

/// A parameter or stated initial value with the values it takes.
#[derive(Clone, PartialEq, Debug)]
pub struct Axis {
    /// Name of a parameter, `l1`, or of an initial value, `A.rate`.
    pub name: String,
    /// Unit of the numbers, empty for numbers without one.
    pub unit: String,
    /// Values of the axis.
    pub values: Values,
}

/// Longer lists come from somewhere else than a command line.
const LONGEST_LIST: usize = 1_000_000;

impl Axis {
    /// A checked axis.
    ///
    /// # Errors
    /// A diagnostic with [`codes::BAD_AXIS`].
    pub fn new(name: &str, values: Values, unit: &str) -> Result<Self, Diagnostic> {
        let axis = Self { name: name.to_owned(), unit: unit.trim().to_owned(), values };
        axis.check()?;
        Ok(axis)
    }

    /// Reads `0.8:1.2:41`, `0.8:1.2` or `0.8, 0.9`; `None` when the text is no axis but one value.
    ///
    /// # Errors
    /// A diagnostic with [`codes::BAD_AXIS`].
    pub fn parse<'t>(name: &str, text: &'t str) -> Result<Option<Self>, Diagnostic> {
        // Parts, of which there are several.
        let is_range = text.contains(':');
        let parts: Vec<&'t str> =
            text.split(if is_range { ':' } else { ',' }).map(str::trim).collect();
        if parts.len() < 2 {
            return Ok(None);
        }

        // Numbers, at least one with the unit of all.
        let mut unit = "";
        let mut number = |part: &'t str| {
            let (number, own) = number_and_unit(part)?;
            let is_other = !own.is_empty() && !unit.is_empty() && own != unit;
            unit = if own.is_empty() { unit } else { own };
            (!is_other).then_some(number)
        };

        // A list, or two ends with a count and a spacing.
        if !is_range {
            let list: Option<Vec<f64>> = parts.iter().map(|part| number(part)).collect();
            // `atan2(a, b)` is one value, an expression.
            let is_expression = parts.iter().any(|part| part.contains(['(', ')']));
            return match list {
                Some(list) => Self::new(name, Values::List(list), unit).map(Some),
                None if is_expression => Ok(None),
                None => Err(unreadable(name, text)),
            };
        }
        let (from, to) = number(parts[0]).zip(number(parts[1])).ok_or(unreadable(name, text))?;
        let values = match parts[2..] {
            [] => Values::Range { from, to, spacing: Spacing::Linear },
            ["log"] => Values::Range { from, to, spacing: Spacing::Log },
            [n] | [n, "log"] => {
                let n = n.parse().map_err(|_| unreadable(name, text))?;
                let spacing = if parts.len() > 3 { Spacing::Log } else { Spacing::Linear };
                Values::Even { from, to, n, spacing }
            }
            _ => return Err(unreadable(name, text)),
        };
        Self::new(name, values, unit).map(Some)
    }

    fn check(&self) -> Result<(), Diagnostic> {
        let Self { name, unit, values } = self;
        if !unit.is_empty() && WrittenUnit::parse(unit).is_none() {
            let message = format!("the axis `{name}` has the unknown unit `{unit}`");
            let help = "`bksim explain M030` lists the units";
            return Err(Diagnostic::error(codes::BAD_AXIS, message).help(help));
        }

        // Values: finite, and of ranges and counts some way between two ends.
        let fault = |message: String, help: String| {
            Err(Diagnostic::error(codes::BAD_AXIS, message).help(help))
        };
        let (from, to, spacing) = match values {
            Values::List(list) if list.is_empty() || list.len() > LONGEST_LIST => {
                let message = format!("the axis `{name}` has {} values", list.len());
                return fault(message, format!("give 1 to {LONGEST_LIST} values"));
            }
            Values::List(list) => match list.iter().find(|value| !value.is_finite()) {
                Some(value) => {
                    let message = format!("the axis `{name}` holds {value}");
                    return fault(message, "give finite numbers".to_owned());
                }
                None => return Ok(()),
            },
            Values::Even { from, to, n, .. } if *n < 2 => {
                let message = format!("the axis `{name}` goes from {from} to {to} in {n} values");
                let help = format!(
                    "give a count of at least 2, as in `{name}={from}:{to}:11`; one value is `{name}={from}`"
                );
                return fault(message, help);
            }
            Values::Even { from, to, spacing, .. } | Values::Range { from, to, spacing } => {
                (*from, *to, *spacing)
            }
        };
        if !(from.is_finite() && to.is_finite() && (to - from).is_finite()) || from == to {
            let message = format!("the axis `{name}` goes from {from} to {to}");
            return fault(message, "give two finite ends that differ".to_owned());
        }
        if spacing == Spacing::Log && from * to <= 0.0 {
            let message = format!("the axis `{name}` goes from {from} to {to} at even ratios");
            return fault(message, "give two ends of one sign, or leave out `:log`".to_owned());
        }
        Ok(())
    }

    /// How many values there are; `None` between two ends.
    pub fn n_values(&self) -> Option<u64> {
        match &self.values {
            Values::List(list) => Some(list.len() as u64),
            Values::Even { n, .. } => Some(*n),
            Values::Range { .. } => None,
        }
    }

    /// The value with this index; the axis is no range.
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        reason = "small counts"
    )]
    pub(crate) fn value(&self, idx: u64) -> f64 {
        match &self.values {
            Values::List(list) => list[idx as usize],
            Values::Even { from, to, n, spacing } => {
                let last = n - 1;
                let weights = [(last - idx) as f64 / last as f64, idx as f64 / last as f64];
                match idx {
                    // The ends as they were written.
                    0 => *from,
                    _ if idx == last => *to,
                    _ if *spacing == Spacing::Linear => {
                        between([*from, *to], [(last - idx) as f64, idx as f64])
                    }
                    _ => from.signum() * from.abs().powf(weights[0]) * to.abs().powf(weights[1]),
                }
            }
            Values::Range { .. } => unreachable!("plans take samples of ranges alone"),
        }
    }

    /// The value of a sample, `at` from 0 up to 1.
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "an index below the length"
    )]
    pub(crate) fn sample(&self, at: f64) -> f64 {
        match &self.values {
            Values::Range { from, to, spacing: Spacing::Linear } => from + (to - from) * at,
            Values::Range { from, to, spacing: Spacing::Log } => from * (to / from).powf(at),
            _ => {
                let n = self.n_values().expect("values that are no range are counted");
                self.value(((n as f64 * at) as u64).min(n - 1))
            }
        }
    }

    /// A number of the axis as `bksim solve --set` takes it: `0.83`, `83 mm`.
    pub fn text(&self, number: f64) -> String {
        let space = if self.unit.is_empty() { "" } else { " " };
        format!("{number:?}{space}{}", self.unit)
    }

    /// Axis as it can be written: `l1=0.8:1.2 m:41`.
    pub fn describe(&self) -> String {
        let spaced = |spacing: Spacing| if spacing == Spacing::Log { ":log" } else { "" };
        let values = match &self.values {
            Values::List(list) => {
                list.iter().map(|&number| self.text(number)).collect::<Vec<_>>().join(",")
            }
            Values::Even { from, to, n, spacing } => {
                format!("{from:?}:{}:{n}{}", self.text(*to), spaced(*spacing))
            }
            Values::Range { from, to, spacing } => {
                format!("{from:?}:{}{}", self.text(*to), spaced(*spacing))
            }
        };
        format!("{}={values}", self.name)
    }
}

/// The mean of two ends with whole weights; rounded once where the ends are short decimals, so that it
/// is 0.9, not 0.9000000000000001.
fn between([from, to]: [f64; 2], weights: [f64; 2]) -> f64 {
    /// Products of the two, and their sums, are exact.
    const SHORT: f64 = 1e9;
    const FEW: f64 = 4e6;
    let whole = weights[0] + weights[1];
    let ten = (0..=9).map(|decimals| 10f64.powi(decimals)).find(|ten| {
        let is_short = |end: f64| (end * ten).abs() < SHORT && (end * ten).round() / ten == end;
        is_short(from) && is_short(to)
    });
    match ten.filter(|_| whole < FEW) {
        Some(ten) => {
            let [a, b] = [from, to].map(|end| (end * ten).round());
            (a * weights[0] + b * weights[1]) / (whole * ten)
        }
        None => (from * weights[0] + to * weights[1]) / whole,
    }
}

/// `80 mm` as 80 and `mm`.
fn number_and_unit(text: &str) -> Option<(f64, &str)> {
    let is_end = |at: usize| at == text.len() || text[at..].starts_with(char::is_whitespace);
    let boundaries = (1..=text.len()).rev().filter(|&at| text.is_char_boundary(at));
    // The longest start that is a number; a unit may touch it.
    let mut found = None;
    for at in boundaries {
        if let Ok(number) = text[..at].parse::<f64>()
            && text[..at].ends_with(|c: char| c.is_ascii_digit() || c == '.')
        {
            found = Some((number, text[at..].trim()));
            break;
        }
        if text.len() - at > 60 && is_end(at) {
            return None;
        }
    }
    found
}

fn unreadable(name: &str, text: &str) -> Diagnostic {
    let shown: String = text.chars().take(60).collect();
    let message = format!("`{name}={shown}` is no axis");
    Diagnostic::error(codes::BAD_AXIS, message).help(format!(
        "write `{name}=0.8:1.2:41` for 41 values, `{name}=0.8,0.9` for these, `{name}=0.8:1.2` for samples; one unit for all numbers"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Vec<f64> {
        let axis = Axis::parse("a", text).expect("an axis").expect("an axis");
        (0..axis.n_values().expect("a grid")).map(|idx| axis.value(idx)).collect()
    }

    #[test]
    fn texts_become_values() {
        assert_eq!(values("0.8:1.2:5"), [0.8, 0.9, 1.0, 1.1, 1.2]);
        assert_eq!(values("80 mm:120mm:3"), [80.0, 100.0, 120.0]);
        assert_eq!(values("-1:1:3"), [-1.0, 0.0, 1.0]);
        assert_eq!(values("3, 1 ,2"), [3.0, 1.0, 2.0]);
        let decades = values("1:1000:4:log");
        for (found, expected) in decades.iter().zip([1.0, 10.0, 100.0, 1000.0]) {
            assert!((found / expected - 1.0).abs() < 1e-14, "{decades:?}");
        }
        let axis = Axis::parse("a", "80:120 mm:3").expect("an axis").expect("an axis");
        assert_eq!(axis.text(80.0), "80.0 mm");
    }

    #[test]
    fn what_is_described_can_be_read() {
        for text in ["0.8:1.2:5", "80:120 mm:3", "1:1000:4:log", "1:3:log", "2:1", "3,-1e-9,2"] {
            let axis = Axis::parse("a", text).expect("an axis").expect("an axis");
            let described = axis.describe();
            let (_, values) = described.split_once('=').expect("a name");
            assert_eq!(Axis::parse("a", values), Ok(Some(axis)), "{described}");
        }
    }

    #[test]
    fn one_value_is_no_axis() {
        for text in ["0.8", "80 mm", "atan2(a, b)", "l1/2"] {
            assert_eq!(Axis::parse("a", text).expect("no fault"), None, "{text}");
        }
    }

    #[test]
    fn faults_have_the_code_of_axes() {
        for text in [
            "0.8:1.2:0",
            "0.8:1.2:1",
            "1:1:3",
            "1:inf:3",
            "-1:1:3:log",
            "1:2:3:4",
            "a:b:3",
            "1,,2",
            "1 mm:2 kg:3",
            "1 quux:2 quux:3",
            ":",
            "1:2:-3",
            "1:2:1.5",
            "nan,1",
        ] {
            let fault = Axis::parse("a", text).expect_err(text);
            assert_eq!(fault.code, codes::BAD_AXIS, "{text}");
            assert!(fault.help.is_some(), "{text}");
        }
    }
}
