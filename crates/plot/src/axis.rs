//! Axes: quantity, unit, range and scale, and the map from numbers to positions in the picture.

use crate::decimate::LARGEST;
use crate::font;
use crate::ticks::{Ticks, power_of_ten, superscript};

/// One axis of a panel: its quantity, unit, scale and range.
#[derive(Clone, PartialEq, Debug)]
pub struct Axis {
    /// Quantity in words.
    pub label: String,
    /// Unit as text, such as `rad/s^2`; may be empty.
    pub unit: String,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// Ends of the axis; those of the curves, with a margin, unless given.
    pub range: Option<[f64; 2]>,
    /// Names that stand at 0, 1, 2, … in place of numbers; none of a quantity.
    pub names: Vec<String>,
}

/// The relation between numbers and positions along an axis.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Scale {
    /// Positions in proportion to numbers.
    #[default]
    Linear,
    /// Positions in proportion to logarithms; numbers that have none are gaps.
    Logarithmic,
}

impl Axis {
    /// A linear axis that is as long as its curves.
    pub fn new(label: &str, unit: &str) -> Self {
        Self {
            label: label.to_owned(),
            unit: unit.to_owned(),
            scale: Scale::Linear,
            range: None,
            names: Vec::new(),
        }
    }

    /// Quantity and unit, as `angle (rad)`.
    pub fn name(&self) -> String {
        match unit_text(&self.unit).as_str() {
            "" => self.label.clone(),
            unit => format!("{} ({unit})", self.label).trim_start().to_owned(),
        }
    }

    /// Title of the axis, as `angle (rad)`, with the offset and the power of ten that the labels leave out.
    pub(crate) fn title(&self, ticks: &Ticks) -> String {
        let mut words = self.label.clone();
        if let Some(offset) = &ticks.offset {
            let (sign, size) = match offset.strip_prefix('-') {
                Some(size) => ('+', size),
                None => ('−', offset.as_str()),
            };
            words = format!("{words} {sign} {size}");
        }
        let factor = if ticks.exponent == 0 { String::new() } else { power_of_ten(ticks.exponent) };
        let unit = [factor, unit_text(&self.unit)].join(" ");
        match unit.trim() {
            "" => words,
            unit => format!("{words} ({unit})").trim_start().to_owned(),
        }
    }

    /// The title, shortened to a width of `room`; the unit is the last to go.
    pub(crate) fn title_within(&self, ticks: &Ticks, size: f64, room: f64) -> String {
        let title = self.title(ticks);
        if font::width(&title, size) <= room {
            return title;
        }
        let unit = Self { label: String::new(), ..self.clone() }.title(ticks);
        let rest = room - font::width(&unit, size) - font::width(" ", size);
        let words = font::fitted(&self.label, size, rest);
        if words.chars().count() < 4 || ticks.offset.is_some() {
            return font::fitted(&unit, size, room);
        }
        Self { label: words, ..self.clone() }.title(ticks)
    }

    /// Ends for these values.
    pub(crate) fn ends(&self, values: impl Iterator<Item = f64>, margin: Margin) -> [f64; 2] {
        let is_drawn = |value: &f64| match self.scale {
            Scale::Linear => value.abs() <= LARGEST,
            Scale::Logarithmic => (1.0 / LARGEST..=LARGEST).contains(value),
        };
        let given = self.range.filter(|[low, high]| low < high && is_drawn(low) && is_drawn(high));
        if let Some(range) = given {
            return range;
        }
        let [low, high] = values
            .filter(is_drawn)
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
                [low.min(value), high.max(value)]
            });
        match self.scale {
            Scale::Linear => linear_ends(low, high, margin),
            Scale::Logarithmic => logarithmic_ends(low, high, margin),
        }
    }

    pub(crate) fn ticks(&self, [low, high]: [f64; 2], max_n: usize) -> Ticks {
        if !self.names.is_empty() {
            let values = (0..self.names.len()).map(|k| k as f64).collect();
            return Ticks { values, labels: self.names.clone(), exponent: 0, offset: None };
        }
        match self.scale {
            Scale::Linear => Ticks::linear(low, high, max_n),
            Scale::Logarithmic => Ticks::logarithmic(low, high, max_n),
        }
    }
}

/// Margin between the curves and the ends of an axis.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Margin {
    None,
    Narrow,
}

/// A narrow margin as a fraction of the span.
const MARGIN: f64 = 0.05;
/// Spans smaller than this fraction of the values are rounding errors.
const ROUNDING: f64 = 1e-13;

fn linear_ends(low: f64, high: f64, margin: Margin) -> [f64; 2] {
    if low > high {
        return [-1.0, 1.0];
    }
    let (span, size) = (high - low, low.abs().max(high.abs()));
    if span <= ROUNDING * size || span < 1e-290 {
        let middle = 0.5 * low + 0.5 * high;
        let half = if size < 1e-280 { 1.0 } else { 0.1 * size };
        return [middle - half, middle + half];
    }
    let margin = if margin == Margin::None { 0.0 } else { MARGIN * span };
    [low - margin, high + margin]
}

fn logarithmic_ends(low: f64, high: f64, margin: Margin) -> [f64; 2] {
    // Also when there are no values.
    if low > high {
        return [0.1, 10.0];
    }
    let decades = high.log10() - low.log10();
    let factor = match margin {
        _ if decades < 1e-9 => 2.0,
        Margin::None => 1.0,
        Margin::Narrow => 10f64.powf(MARGIN * decades),
    };
    [(low / factor).max(1.0 / LARGEST), (high * factor).min(LARGEST)]
}

/// `rad/s^2` as `rad/s²`, `N*m` as `N·m`.
pub fn unit_text(unit: &str) -> String {
    let mut text = String::new();
    let mut rest = unit;
    while let Some(at) = rest.find('^') {
        text.push_str(&rest[..at]);
        let power = &rest[at + 1..];
        let is_power =
            |(at, letter): (usize, char)| letter.is_ascii_digit() || (at == 0 && letter == '-');
        let end = power.char_indices().find(|&letter| !is_power(letter));
        let (power, after) = power.split_at(end.map_or(power.len(), |(end, _)| end));
        text.push_str(&superscript(power));
        rest = after;
    }
    text.push_str(rest);
    text.replace('*', "·")
}

/// The map from numbers to positions along one direction of the picture.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Map {
    ends: [f64; 2],
    positions: [f64; 2],
    scale: Scale,
}

impl Map {
    pub(crate) fn new(ends: [f64; 2], positions: [f64; 2], scale: Scale) -> Self {
        let ends = match scale {
            Scale::Linear => ends,
            Scale::Logarithmic => ends.map(f64::log10),
        };
        Self { ends, positions, scale }
    }

    /// The position of a number; NaN if it has none on this scale.
    pub(crate) fn position(&self, value: f64) -> f64 {
        let value = match self.scale {
            Scale::Linear => value,
            // A tick at the smallest number may be rounded below it.
            Scale::Logarithmic if value >= 0.999_999 / LARGEST => value.log10(),
            Scale::Logarithmic => f64::NAN,
        };
        let ([low, high], [from, to]) = (self.ends, self.positions);
        // Halves, so that ends near the largest numbers have a finite distance.
        let part = (0.5 * value - 0.5 * low) / (0.5 * high - 0.5 * low);
        let position = from + part * (to - from);
        // Bounded, so that positions far outside of the picture stay valid numbers there.
        if position.is_nan() { position } else { position.clamp(-1e5, 1e5) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_set_as_printed() {
        let cases = [
            ("rad/s^2", "rad/s²"),
            ("N*m", "N·m"),
            ("kg*m^2*s^-1", "kg·m²·s⁻¹"),
            ("", ""),
            ("^", ""),
            ("m^^", "m"),
        ];
        for (unit, expected) in cases {
            assert_eq!(unit_text(unit), expected);
        }
    }

    #[test]
    fn titles_hold_the_offset_and_power_that_the_labels_leave_out() {
        let title = |low, high, unit| {
            let axis = Axis::new("energy", unit);
            axis.title(&axis.ticks([low, high], 5))
        };
        assert_eq!(title(0.0, 3.0, "J"), "energy (J)");
        assert_eq!(title(0.0, 3.0, ""), "energy");
        assert_eq!(title(0.0, 3e-9, "J"), "energy (10⁻⁹ J)");
        assert_eq!(title(-2.5e-9, 3e-9, ""), "energy (10⁻⁹)");
        assert_eq!(title(12.345_678_9, 12.345_679_1, "J"), "energy − 12.34567890 (10⁻⁹ J)");
        let axis = Axis::new("angular acceleration", "rad/s^2");
        let ticks = axis.ticks([0.0, 1.0], 5);
        assert_eq!(axis.title_within(&ticks, 14.0, 60.0), "(rad/s²)");
        assert_eq!(axis.title_within(&ticks, 14.0, 500.0), "angular acceleration (rad/s²)");
    }

    #[test]
    fn any_values_have_ends_apart() {
        let cases: [&[f64]; 10] = [
            &[],
            &[0.0],
            &[5.0, 5.0],
            &[1.0, 1.0 + f64::EPSILON],
            &[f64::NAN, f64::INFINITY],
            &[-LARGEST, LARGEST],
            &[f64::MIN_POSITIVE, -f64::MIN_POSITIVE],
            &[1e-320, 2.0],
            &[1.0 / LARGEST, LARGEST],
            &[3e-310],
        ];
        for values in cases {
            for scale in [Scale::Linear, Scale::Logarithmic] {
                for margin in [Margin::None, Margin::Narrow] {
                    let axis = Axis { scale, ..Axis::new("", "") };
                    let [low, high] = axis.ends(values.iter().copied(), margin);
                    assert!(low < high && high.is_finite(), "{values:?}: {low} {high}");
                    let map = Map::new([low, high], [0.0, 100.0], scale);
                    assert!(
                        (map.position(low)).abs() < 1e-9
                            && (map.position(high) - 100.0).abs() < 1e-9
                    );
                    assert!(!axis.ticks([low, high], 5).values.is_empty());
                }
            }
        }
    }
}
