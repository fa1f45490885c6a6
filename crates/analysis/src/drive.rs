//! Prescribed measures of a question, each over a range.

use bksim_model::diagnostic::Diagnostic;
use bksim_model::file::{WrittenUnit, code, looks_like_degrees};
use bksim_model::message::short;
use bksim_model::{Measure, Model};

use crate::error::AnalysisError;

/// A drive with the rate of its motion at the start.
#[derive(Clone, PartialEq, Debug)]
pub struct DriveRate {
    /// Name of the drive.
    pub name: String,
    /// Rate of its motion, SI.
    pub rate: f64,
    /// `rad/s` or `m/s`.
    pub unit: &'static str,
}

/// Values at even distances, SI.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Range {
    /// The first.
    pub from: f64,
    /// The last.
    pub to: f64,
    /// How many, at least one.
    pub n: usize,
}

/// A measure that is driven over a range.
#[derive(Clone, PartialEq, Debug)]
pub struct Drive {
    /// Name of the measure: `crank.angle`.
    pub name: String,
    /// The measure, a position.
    pub measure: Measure,
    /// Values that the drive takes.
    pub range: Range,
    /// Rate at every value, rad/s or m/s.
    pub rate: f64,
    /// Acceleration at every value, rad/s² or m/s².
    pub acceleration: f64,
}

impl Range {
    /// Reads `0:360 deg:361`, `0:90 deg` (two values) or `30 deg` (one); a unit holds for all numbers.
    ///
    /// # Errors
    /// [`AnalysisError::BadRange`] for what is none, and units of other dimensions than `si`.
    pub fn parse(text: &str, si: &str) -> Result<Self, AnalysisError> {
        let bad = || AnalysisError::BadRange { text: text.to_owned(), unit: si.to_owned() };
        let parts: Vec<&str> = text.split(':').map(str::trim).collect();
        let (ends, n) = match parts[..] {
            [one] => (vec![one], 1),
            [from, to] => (vec![from, to], 2),
            [from, to, n] => (vec![from, to], n.parse().map_err(|_| bad())?),
            _ => return Err(bad()),
        };
        if n == 0 || (n == 1 && ends.len() == 2 && ends[0] != ends[1]) {
            return Err(bad());
        }
        let ends: Vec<(f64, &str)> = ends
            .into_iter()
            .map(|end| number_and_unit(end).ok_or_else(bad))
            .collect::<Result<_, _>>()?;
        // A number without a unit has that of the other.
        let shared = ends.iter().map(|(_, unit)| *unit).find(|unit| !unit.is_empty()).unwrap_or("");
        let in_si = |&(number, unit): &(f64, &str)| {
            let unit = if unit.is_empty() { shared } else { unit };
            value_in_si(number, unit, si).ok_or_else(bad)
        };
        let from = in_si(&ends[0])?;
        let to = in_si(ends.last().unwrap_or(&ends[0]))?;
        Ok(Self { from, to, n })
    }

    /// All values.
    pub fn values(&self) -> Vec<f64> {
        let last = (self.n - 1).max(1) as f64;
        (0..self.n).map(|k| self.at(k as f64 / last)).collect()
    }

    /// The value at a share of the range, exact at both ends.
    pub(crate) fn at(&self, share: f64) -> f64 {
        self.from * (1.0 - share) + self.to * share
    }
}

/// Reads a quantity such as `25 mm` in the unit `si`.
///
/// # Errors
/// [`AnalysisError::BadRange`] for what is none.
pub fn quantity(text: &str, si: &str) -> Result<f64, AnalysisError> {
    let bad = || AnalysisError::BadRange { text: text.to_owned(), unit: si.to_owned() };
    let (number, unit) = number_and_unit(text.trim()).ok_or_else(bad)?;
    value_in_si(number, unit, si).ok_or_else(bad)
}

fn value_in_si(number: f64, unit: &str, si: &str) -> Option<f64> {
    if unit.is_empty() {
        return Some(number);
    }
    // A rate is written as one of an angle, which is a number.
    let read = |unit: &str| match unit.strip_prefix("1/") {
        Some(per) => WrittenUnit::parse(&format!("rad/{per}")),
        None => WrittenUnit::parse(unit),
    };
    let written = read(unit)?;
    let is_fitting = if si.is_empty() {
        written.is_alike(&WrittenUnit::PURE)
    } else {
        written.is_alike(&read(si)?)
    };
    is_fitting.then(|| written.to_si(number))
}

/// The number that a text begins with, and what follows it.
fn number_and_unit(text: &str) -> Option<(f64, &str)> {
    let is_number = |end: usize| text[..end].trim().parse::<f64>().is_ok_and(f64::is_finite);
    let ends = text.char_indices().map(|(at, _)| at).chain([text.len()]);
    let end = ends.rev().find(|&end| is_number(end))?;
    Some((text[..end].trim().parse().ok()?, text[end..].trim()))
}

impl Drive {
    /// Reads `crank.angle=0:360 deg:361`; rate 1 and acceleration 0.
    ///
    /// # Errors
    /// [`AnalysisError`] for a measure that the model has not, or values that cannot be read.
    pub fn parse(model: &Model, name: &str, values: &str) -> Result<Self, AnalysisError> {
        let measure = position(model, name)?;
        let range = Range::parse(values, measure.unit(model))?;
        Ok(Self { name: name.to_owned(), measure, range, rate: 1.0, acceleration: 0.0 })
    }
}

/// The warning of a range of an angle that has no unit and whose numbers are degrees.
pub fn range_like_degrees(drive: &Drive, model: &Model, values: &str) -> Option<Diagnostic> {
    let is_bare = values.split(':').all(|part| part.trim().parse::<f64>().is_ok());
    let found = [drive.range.from, drive.range.to].into_iter().find(|x| looks_like_degrees(*x))?;
    if !is_bare || drive.measure.unit(model) != "rad" {
        return None;
    }
    let (name, shown, turns) = (&drive.name, short(found), found / std::f64::consts::TAU);
    let message = format!("{shown} in the range of `{name}` is {shown} rad = {turns:.1} turns");
    // The unit is written once, at the end of the last angle.
    let parts: Vec<&str> = values.split(':').collect();
    let written = |unit: &str| match parts.as_slice() {
        [one] => format!("{name}={one} {unit}"),
        [from, to] => format!("{name}={from}:{to} {unit}"),
        _ => format!("{name}={}:{} {unit}:{}", parts[0], parts[1], parts[2..].join(":")),
    };
    let help = format!("write `{}`, or `{}` if it is right", written("deg"), written("rad"));
    Some(Diagnostic::warning(code::LOOKS_LIKE_DEGREES, message).help(help))
}

/// The measure of this name, which is a position or an angle.
///
/// # Errors
/// [`AnalysisError::UnknownMeasure`], or [`AnalysisError::NotAPosition`] for anything else.
pub fn position(model: &Model, name: &str) -> Result<Measure, AnalysisError> {
    let unknown = || unknown_measure(model, name, is_position);
    let measure = Measure::named(model, name).ok_or_else(unknown)?;
    if measure.is_position() {
        Ok(measure)
    } else {
        Err(AnalysisError::NotAPosition { name: name.to_owned() })
    }
}

/// True if a measure can be prescribed.
pub(crate) fn is_position(measure: Option<Measure>) -> bool {
    measure.is_some_and(Measure::is_position)
}

/// The error of a name that nothing has, with the nearest name of a measure that fits.
pub(crate) fn unknown_measure(
    model: &Model,
    name: &str,
    fits: impl Fn(Option<Measure>) -> bool,
) -> AnalysisError {
    AnalysisError::UnknownMeasure { name: name.to_owned(), near: model.did_you_mean(name, fits) }
}
