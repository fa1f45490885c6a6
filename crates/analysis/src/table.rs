//! [`Table`]: an answer in rows and columns.

use std::fmt::Write;

use bksim_model::message::short;

use crate::error::AnalysisError;

/// Named columns of numbers, all of the same length.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Table {
    /// Heads of the columns.
    pub columns: Vec<Column>,
    /// Rows, each as long as the columns are many.
    pub rows: Vec<Vec<f64>>,
}

/// Head of a column.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Column {
    /// Name: `crank.angle`, `A.fx`.
    pub name: String,
    /// SI unit; empty for plain numbers.
    pub unit: String,
}

impl Column {
    /// A column of this name and unit.
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into() }
    }
}

impl Table {
    /// The numbers of a column.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let idx = self.columns.iter().position(|column| column.name == name)?;
        Some(self.rows.iter().map(|row| row[idx]).collect())
    }

    /// Refuses numbers that are none, but in columns that `may_be_open` lets have no bound.
    ///
    /// # Errors
    /// [`AnalysisError::NoNumber`] names the first of them by its column, and its row by the value in the first one.
    pub(crate) fn check_numbers(
        &self,
        may_be_open: impl Fn(&Column) -> bool,
    ) -> Result<(), AnalysisError> {
        let cells = self.rows.iter().flat_map(|row| {
            let numbers = row.iter().zip(&self.columns);
            numbers.map(move |(value, column)| (*value, column, row))
        });
        let is_bad = |(value, column, _): &(f64, &Column, &Vec<f64>)| {
            !value.is_finite() && !may_be_open(column)
        };
        let Some((value, column, row)) = { cells }.find(is_bad) else { return Ok(()) };
        let by = &self.columns[0];
        let place = format!("at {} = {} {}", by.name, short(row[0]), by.unit).trim_end().to_owned();
        Err(AnalysisError::NoNumber { name: column.name.clone(), place, value })
    }

    /// The table as comma-separated values: a line of names, a line for each row. Numbers have as many
    /// digits as tell them apart from all others.
    pub fn csv(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|column| column.name.as_str()).collect();
        let mut text = names.join(",") + "\n";
        for row in &self.rows {
            for (k, cell) in row.iter().enumerate() {
                text.push_str(if k > 0 { "," } else { "" });
                push_number(&mut text, *cell);
            }
            text.push('\n');
        }
        text
    }
}

/// Appends a number as `{}` writes it; without the formatter, which takes most of the time of a large table.
fn push_number(text: &mut String, x: f64) {
    // Within these there are digits alone, beyond them powers of ten.
    const PLAIN: std::ops::Range<f64> = 1e-4..1e15;
    if PLAIN.contains(&x.abs()) {
        let mut buffer = zmij::Buffer::new();
        let digits = buffer.format_finite(x);
        let is_whole = digits.as_bytes().ends_with(b".0");
        text.push_str(&digits[..digits.len() - if is_whole { 2 } else { 0 }]);
    } else {
        write!(text, "{x}").expect("a text takes whatever is written to it");
    }
}

#[cfg(test)]
mod tests {
    use super::push_number;

    #[test]
    fn numbers_are_written_as_the_formatter_writes_them() {
        let edges = [0.0, -0.0, 1.0, -1.5, 0.1, 1e-5, 1.25e-7, 1e15, 1e16, 1e300, 5e-324];
        let others = [f64::MAX, f64::MIN_POSITIVE, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        // All magnitudes, by the bits of a linear congruential sequence.
        let bits = std::iter::successors(Some(1_u64), |bits| {
            Some(
                bits.wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407),
            )
        });
        let any = bits.take(20_000).flat_map(|bits| {
            let x = f64::from_bits(bits);
            [x, (x.abs().log10() * 1e3).round() / 1e3, x.abs().log2().sin()]
        });
        for x in edges.into_iter().chain(others).chain(any) {
            let mut written = String::new();
            push_number(&mut written, x);
            // Of two shortest texts as near as each other either will do.
            let known = format!("{x}");
            let is_as_good = written.len() == known.len() && written.parse() == Ok(x);
            assert!(written == known || is_as_good, "{written} is not {known}");
        }
    }
}
