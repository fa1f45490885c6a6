//! [`SparseMatrix`]: a matrix of expressions by its entries that are not zero.
//!
//! A body meets its neighbours only, so the matrices of a long mechanism hold a few entries in each
//! row, and everything made from them grows with their number.

use std::collections::BTreeMap;

use bksim_expr::{Expr, Pool};

/// The entries of a matrix that are not the number 0, row by row.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct SparseMatrix {
    n_columns: usize,
    /// Columns and entries, columns ascending.
    rows: Vec<Vec<(usize, Expr)>>,
}

impl SparseMatrix {
    /// The matrix with the given `(row, column, entry)`, each position once, in any order.
    ///
    /// # Panics
    /// If a position lies outside the matrix or is named twice.
    pub fn new(
        n_rows: usize,
        n_columns: usize,
        entries: impl IntoIterator<Item = (usize, usize, Expr)>,
    ) -> Self {
        let mut rows = vec![Vec::new(); n_rows];
        for (row, column, entry) in entries {
            assert!(row < n_rows && column < n_columns, "({row}, {column}) lies outside");
            rows[row].push((column, entry));
        }
        for row in &mut rows {
            row.sort_unstable_by_key(|&(column, _)| column);
            assert!(row.windows(2).all(|pair| pair[0].0 < pair[1].0), "a position is named twice");
        }
        Self { n_columns, rows }
    }

    /// Number of rows.
    pub fn n_rows(&self) -> usize {
        self.rows.len()
    }

    /// Number of columns.
    pub fn n_columns(&self) -> usize {
        self.n_columns
    }

    /// Columns and entries of a row, columns ascending.
    pub fn row(&self, row: usize) -> &[(usize, Expr)] {
        &self.rows[row]
    }

    /// Rows and entries of a column, found row by row; see [`SparseMatrix::transposed`] for all.
    pub fn column(&self, column: usize) -> impl Iterator<Item = (usize, Expr)> {
        (0..self.n_rows()).filter_map(move |row| Some((row, self.get(row, column)?)))
    }

    /// The entry at a position; `None` is zero.
    pub fn get(&self, row: usize, column: usize) -> Option<Expr> {
        let entries = &self.rows[row];
        let at = entries.binary_search_by_key(&column, |&(column, _)| column).ok()?;
        Some(entries[at].1)
    }

    /// All `(row, column, entry)`, row by row.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, Expr)> {
        let with_row = |(row, entries): (usize, &Vec<(usize, Expr)>)| {
            entries.iter().map(move |&(column, entry)| (row, column, entry)).collect::<Vec<_>>()
        };
        self.rows.iter().enumerate().flat_map(with_row)
    }

    /// The entries of a row, columns ascending.
    pub(crate) fn row_mut(&mut self, row: usize) -> impl Iterator<Item = &mut Expr> {
        self.rows[row].iter_mut().map(|(_, entry)| entry)
    }

    /// All entries, row by row.
    pub(crate) fn entries_mut(&mut self) -> impl Iterator<Item = &mut Expr> {
        self.rows.iter_mut().flatten().map(|(_, entry)| entry)
    }

    /// The entries on and below the diagonal, row by row.
    pub fn lower(&self) -> impl Iterator<Item = (usize, usize, Expr)> {
        self.entries().filter(|&(row, column, _)| column <= row)
    }

    /// Sum with further entries, several at one position if need be; zeros are left out.
    #[must_use]
    pub(crate) fn plus(
        &self,
        pool: &Pool,
        terms: impl IntoIterator<Item = (usize, usize, Expr)>,
    ) -> Self {
        let mut entries: BTreeMap<(usize, usize), Expr> =
            self.entries().map(|(i, j, entry)| ((i, j), entry)).collect();
        for (i, j, term) in terms {
            let entry = entries.entry((i, j)).or_insert(pool.zero());
            *entry = pool.add(*entry, term);
        }
        let entries = entries.into_iter().map(|((i, j), entry)| (i, j, entry));
        let entries = entries.filter(|&(.., entry)| !pool.is_zero(entry));
        Self::new(self.n_rows(), self.n_columns, entries)
    }

    /// Rows and columns exchanged.
    #[must_use]
    pub fn transposed(&self) -> Self {
        let entries = self.entries().map(|(row, column, entry)| (column, row, entry));
        Self::new(self.n_columns, self.n_rows(), entries)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_found_in_the_matrix_and_across_the_diagonal_in_its_transpose() {
        let pool = bksim_expr::Pool::new();
        let [a, b, c] = ["a", "b", "c"].map(|name| pool.symbol(name));
        let matrix = SparseMatrix::new(2, 3, [(1, 2, c), (0, 1, a), (1, 0, b)]);
        assert_eq!(matrix.row(1), [(0, b), (2, c)]);
        assert_eq!((matrix.get(0, 1), matrix.get(0, 0)), (Some(a), None));
        assert_eq!(matrix.column(1).collect::<Vec<_>>(), [(0, a)]);
        assert_eq!(matrix.lower().collect::<Vec<_>>(), [(1, 0, b)]);
        let transposed = matrix.transposed();
        assert!(matrix.entries().all(|(i, j, e)| transposed.get(j, i) == Some(e)));
        assert_eq!(transposed.transposed(), matrix);
    }
}
