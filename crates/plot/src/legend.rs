//! Legends: rows above the axes, where they hide no curve.

use std::collections::BTreeSet;

use crate::Curve;
use crate::font;

/// Size of its texts, px.
pub(crate) const TEXT_SIZE: f64 = 14.0;
/// Height of a row, px.
pub(crate) const ROW_HEIGHT: f64 = 21.0;
/// Length of the sample of a curve before its name, px.
pub(crate) const SAMPLE: f64 = 26.0;
/// Gap between a sample and its name, px.
const GAP: f64 = 6.0;
/// Gap between a name and the next sample, px.
const BETWEEN: f64 = 18.0;

/// Least width of a column, px.
const NARROWEST: f64 = 88.0;

/// A name in a legend.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Entry {
    /// Index of its curve in the panel.
    pub(crate) curve: usize,
    /// Name of the entry, shortened to the width of the legend.
    pub(crate) text: String,
    /// Left end of the sample, from the left end of the legend, px.
    pub(crate) x: f64,
    /// Row, the highest first.
    pub(crate) row: usize,
}

impl Entry {
    /// Left end of the text, px.
    pub(crate) fn text_x(&self) -> f64 {
        self.x + SAMPLE + GAP
    }
}

/// The legend of these curves within a width, in columns where it has several rows; empty for one
/// curve, which the axis names. Where it would have more than `max_rows`, names are shortened so that more
/// columns fit, down to [`NARROWEST`].
pub(crate) fn entries(curves: &[Curve], width: f64, max_rows: usize) -> Vec<Entry> {
    let entries = within(curves, width, width);
    let n_rows = |entries: &[Entry]| entries.last().map_or(0, |last| last.row + 1);
    if n_rows(&entries) <= max_rows.max(1) {
        return entries;
    }
    let n_fewest = curves.len().div_ceil(max_rows.max(1));
    let column = |n: usize| (width + BETWEEN) / n as f64 - BETWEEN;
    let n_columns = (1..=n_fewest).rev().find(|&n| column(n) >= NARROWEST).unwrap_or(1);
    let narrow = within(curves, width, column(n_columns));
    if n_rows(&narrow) < n_rows(&entries) { narrow } else { entries }
}

/// The legend within a width, with no entry wider than `widest`.
fn within(curves: &[Curve], width: f64, widest: f64) -> Vec<Entry> {
    if curves.len() < 2 {
        return Vec::new();
    }
    let room = (widest - SAMPLE - GAP).max(0.0);
    let texts = told_apart(curves, room);
    let widths: Vec<f64> =
        texts.iter().map(|text| SAMPLE + GAP + font::width(text, TEXT_SIZE)).collect();
    let whole = widths.iter().sum::<f64>() + BETWEEN * (widths.len() - 1) as f64;
    let widest = widths.iter().copied().fold(0.0, f64::max);
    // Columns read better than ragged rows.
    let n_columns = if whole <= width {
        texts.len()
    } else {
        let fit = (1..texts.len())
            .rev()
            .find(|&n| n as f64 * (widest + BETWEEN) - BETWEEN <= width + 1e-9);
        fit.unwrap_or(1)
    };
    let entry = |(curve, text): (usize, String)| {
        let (row, column) = (curve / n_columns, curve % n_columns);
        let x = if n_columns == widths.len() {
            widths[..curve].iter().map(|width| width + BETWEEN).sum()
        } else {
            column as f64 * (widest + BETWEEN)
        };
        Entry { curve, text, x, row }
    };
    texts.into_iter().enumerate().map(entry).collect()
}

/// The names within a width: without their middle, or, where that makes two of them one, without their end.
fn told_apart(curves: &[Curve], room: f64) -> Vec<String> {
    let of = |shorten: fn(&str, f64, f64) -> String| -> Vec<String> {
        curves.iter().map(|curve| shorten(&curve.name, TEXT_SIZE, room)).collect()
    };
    let n_different = |texts: &[String]| texts.iter().collect::<BTreeSet<_>>().len();
    let (middle, begun) = (of(font::fitted), of(font::begun));
    if n_different(&begun) > n_different(&middle) { begun } else { middle }
}

/// Height of a legend, px.
pub(crate) fn height(entries: &[Entry]) -> f64 {
    entries.last().map_or(0.0, |last| (last.row + 1) as f64 * ROW_HEIGHT + 4.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stand_next_to_one_another_within_the_width() {
        let curves: Vec<Curve> = ["theta1", "x2", "a_rather_long_name", "y2", "theta2"]
            .map(|name| Curve::new(name, vec![]))
            .into();
        for width in [60.0, 150.0, 300.0, 900.0] {
            let entries = entries(&curves, width, 9);
            for entry in &entries {
                let end = entry.text_x() + font::width(&entry.text, TEXT_SIZE);
                assert!(end <= width + 1e-9, "{entry:?} in {width}");
            }
            for pair in entries.windows(2).filter(|pair| pair[0].row == pair[1].row) {
                let end = pair[0].text_x() + font::width(&pair[0].text, TEXT_SIZE);
                assert!(end + 10.0 < pair[1].x, "{pair:?}");
            }
        }
        assert_eq!(height(&entries(&curves, 900.0, 9)), ROW_HEIGHT + 4.0);
        assert!(entries(&curves[..1], 900.0, 9).is_empty());
    }

    #[test]
    fn names_are_shortened_before_a_legend_is_too_high() {
        let curves: Vec<Curve> = ["first_angle1_dot", "first_angle2_dot", "phi1_dot", "phi2_dot"]
            .map(|name| Curve::new(name, vec![]))
            .into();
        let rows = |max_rows| entries(&curves, 250.0, max_rows).last().map(|last| last.row + 1);
        assert_eq!([rows(9), rows(2)], [Some(4), Some(2)]);
        for entry in entries(&curves, 250.0, 2) {
            let end = entry.text_x() + font::width(&entry.text, TEXT_SIZE);
            assert!(end <= 250.0 + 1e-9, "{entry:?}");
        }
        // Names are kept readable however low the picture is.
        assert_eq!(entries(&curves, 100.0, 1).len(), 4);
        let curves: Vec<Curve> =
            ["cross1_angle", "cross2_angle"].map(|name| Curve::new(name, vec![])).into();
        let texts: Vec<_> =
            entries(&curves, 195.0, 1).into_iter().map(|entry| entry.text).collect();
        assert!(texts[0] != texts[1] && texts[0].ends_with('…'), "{texts:?}");
    }
}
