//! [`Weighted`]: the rows of a part in units of the mechanism and radians, as they stand among the numbers of all rows.

use super::equations::Numbers;
use super::normal::Normal;
use super::parts::Part;
use crate::linear::rows::SparseRows;

/// The rows of a part: those that must hold, then the guesses.
pub(super) struct Weighted {
    rows: Vec<Row>,
    /// How many must hold.
    n_held: usize,
    /// Entries by coordinates of the part, row by row.
    entries: Vec<Entry>,
}

struct Row {
    /// Place among all rows.
    place: usize,
    weight: f64,
    n_entries: usize,
}

struct Entry {
    /// Place among the slopes of all rows.
    slope: usize,
    /// Place of its column in the part.
    place: usize,
    unit: f64,
}

impl Weighted {
    /// The rows of `part` among those with the entries of `gradients`. A row weighs 1 for an angle, 1 by the size of
    /// the mechanism for a length; the unit of a column is 1 rad, or that size.
    pub(super) fn of(
        part: &Part,
        gradients: &SparseRows,
        (weight_of_row, unit_of_column): (&[f64], &[f64]),
    ) -> Self {
        let mut entries: Vec<Entry> = Vec::new();
        let mut row = |&row: &usize| {
            let all = gradients.places(row).zip(gradients.row(row));
            let own = all.filter_map(|(slope, &(column, _))| {
                let place = part.columns.binary_search(&column).ok()?;
                Some(Entry { slope, place, unit: unit_of_column[column] })
            });
            let first = entries.len();
            entries.extend(own);
            Row { place: row, weight: weight_of_row[row], n_entries: entries.len() - first }
        };
        let rows = part.rows.iter().chain(&part.wishes).map(&mut row).collect();
        Self { rows, n_held: part.rows.len(), entries }
    }

    /// Σ r² with guesses of this weight.
    pub(super) fn cost(&self, at: &Numbers, wish_weight: f64) -> f64 {
        let square = |row: &Row| (row.weight * at.values[row.place]).powi(2);
        let (held, wishes) = self.rows.split_at(self.n_held);
        let held: f64 = held.iter().map(square).sum();
        let wished: f64 = wishes.iter().map(square).sum();
        held + wish_weight * wish_weight * wished
    }

    /// The unknowns that each row has entries by.
    pub(super) fn unknowns(&self) -> Vec<Vec<usize>> {
        let mut entries = self.entries.iter().map(|entry| entry.place);
        self.rows.iter().map(|row| entries.by_ref().take(row.n_entries).collect()).collect()
    }

    /// Writes the normal equations of all rows, guesses with this weight.
    pub(super) fn write_to(&self, normal: &mut Normal, at: &Numbers, wish_weight: f64) {
        normal.clear();
        // Guesses without weight have no part.
        let n_rows = if wish_weight == 0.0 { self.n_held } else { self.rows.len() };
        let mut rest = self.entries.as_slice();
        for (k, row) in self.rows[..n_rows].iter().enumerate() {
            let weight = if k < self.n_held { row.weight } else { wish_weight * row.weight };
            let (entries, after) = rest.split_at(row.n_entries);
            rest = after;
            let entries = entries.iter().map(|entry| weight * at.slopes[entry.slope] * entry.unit);
            normal.add(entries, weight * at.values[row.place]);
        }
        normal.multiply();
    }
}
