//! Linear complementarity by Lemke's method.
//!
//! ```text
//! w = M z + q,   w ≥ 0,   z ≥ 0,   wᵀ z = 0
//! ```
//!
//! It ends in a solution for the matrices of rigid bodies that touch and rub, also where contacts repeat each other. Source:
//! R. W. Cottle, J.-S. Pang and R. E. Stone, *The Linear Complementarity Problem* (1992), §4.4; D. E. Stewart and
//! J. C. Trinkle (1996) for contacts.

use nalgebra::{DMatrix, DVector};

/// Entries below this part of the largest are rounding.
const ROUNDING: f64 = 1e-11;
/// Part of the largest number by which the right sides are moved apart, so that no two rows leave at once.
const APART: f64 = 1e-10;
/// Part of the terms of a row within which a solution satisfies it.
const FITS: f64 = 1e-6;

/// A solution of a linear complementarity problem.
pub(super) struct Complementary {
    pub(super) z: DVector<f64>,
    /// The z that are free to be other than zero: no more than the rows that decide them.
    pub(super) is_basic: Vec<bool>,
}

/// A solution; `None` where the method finds none.
///
/// The pivots find which z are not zero, from right sides that are moved apart; their values are those of the right sides as
/// they are.
pub(super) fn lemke(m: &DMatrix<f64>, q: &DVector<f64>) -> Option<Complementary> {
    let n = q.len();
    if n == 0 || q.iter().all(|&q| q >= 0.0) {
        return Some(Complementary { z: DVector::zeros(n), is_basic: vec![false; n] });
    }
    let basis = complementary_basis(m, q)?;
    let is_basic = |k: usize| basis.contains(&(n + k));
    let chosen: Vec<usize> = (0..n).filter(|&k| is_basic(k)).collect();
    let values = if chosen.is_empty() {
        DVector::zeros(0)
    } else {
        m.select_rows(&chosen).select_columns(&chosen).lu().solve(&-q.select_rows(&chosen))?
    };
    let mut z = DVector::zeros(n);
    for (&k, value) in chosen.iter().zip(values.iter()) {
        z[k] = value.max(0.0);
    }
    let left = m * &z + q;
    let largest = |k: usize| {
        m.row(k).iter().zip(z.iter()).map(|(m, z)| (m * z).abs()).fold(q[k].abs(), f64::max)
    };
    let fits = |k: usize| {
        let rounding = FITS * largest(k).max(q.amax());
        left[k] >= -rounding && (z[k] == 0.0 || left[k] <= rounding)
    };
    (0..n).all(fits).then(|| Complementary { is_basic: (0..n).map(is_basic).collect(), z })
}

/// Rows of the tableau, each with the columns w, z, the covering variable, and the right side.
struct Table {
    rows: Vec<Vec<f64>>,
}

impl Table {
    fn new(m: &DMatrix<f64>, q: &DVector<f64>) -> Self {
        let (n, size) = (q.len(), q.amax());
        let mut apart = APART * size;
        let row = |i: usize| {
            let mut row = vec![0.0; 2 * n + 2];
            row[i] = 1.0;
            (0..n).for_each(|j| row[n + j] = -m[(i, j)]);
            row[2 * n] = -1.0;
            // Unlike, and none the sum of others.
            apart *= 1.37;
            if apart > 1e3 * APART * size {
                apart = 1.013 * APART * size;
            }
            row[2 * n + 1] = q[i] + apart;
            row
        };
        Self { rows: (0..n).map(row).collect() }
    }

    fn right(&self, i: usize) -> f64 {
        self.rows[i].last().copied().unwrap_or(0.0)
    }

    /// Makes the column a unit column with its one in this row.
    fn pivot(&mut self, at: usize, column: usize) {
        let mut row = std::mem::take(&mut self.rows[at]);
        let pivot = row[column];
        for value in &mut row {
            *value /= pivot;
        }
        for other in self.rows.iter_mut().filter(|other| !other.is_empty()) {
            let factor = other[column];
            if factor != 0.0 {
                other.iter_mut().zip(&row).for_each(|(value, own)| *value -= factor * own);
            }
        }
        self.rows[at] = row;
    }
}

/// The variables that are not zero in a solution, w before z; `None` where the method ends elsewhere.
fn complementary_basis(m: &DMatrix<f64>, q: &DVector<f64>) -> Option<Vec<usize>> {
    let n = q.len();
    let cover = 2 * n;
    let mut table = Table::new(m, q);
    let mut basis: Vec<usize> = (0..n).collect();
    let mut leaving = (0..n).min_by(|&a, &b| table.right(a).total_cmp(&table.right(b)))?;
    if table.right(leaving) >= 0.0 {
        return Some(basis);
    }
    let mut entering = cover;
    for _ in 0..50 * (n + 1) {
        table.pivot(leaving, entering);
        let left = std::mem::replace(&mut basis[leaving], entering);
        if left == cover {
            return Some(basis);
        }
        // Its complement enters; the row that reaches zero first leaves, that of the covering variable before others.
        entering = if left < n { left + n } else { left - n };
        let column = |i: usize| table.rows[i][entering];
        let smallest = ROUNDING * (0..n).map(|i| column(i).abs()).fold(0.0, f64::max);
        let ratios = (0..n).filter(|&i| column(i) > smallest);
        let ratios = ratios.map(|i| (i, table.right(i).max(0.0) / column(i)));
        leaving = ratios.min_by(|a, b| a.1.total_cmp(&b.1))?.0;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_sides_below_zero_by_rounding_are_solved_by_nothing() {
        let m = DMatrix::identity(2, 2);
        let z = lemke(&m, &DVector::from_vec(vec![-1e-14, 1.0])).expect("a solution").z;
        assert!(z.amax() <= 1e-14, "{z}");
    }

    #[test]
    fn solutions_are_complementary() {
        let m = DMatrix::from_row_slice(3, 3, &[2.0, 1.0, 0.0, 1.0, 2.0, 1.0, 0.0, 1.0, 2.0]);
        let q = DVector::from_vec(vec![-1.0, -3.0, 1.0]);
        let z = lemke(&m, &q).expect("a solution").z;
        let w = &m * &z + &q;
        assert!(z.min() >= 0.0 && w.min() > -1e-14, "z {z}, w {w}");
        assert!(z.dot(&w).abs() < 1e-14, "z {z}, w {w}");
        assert!((z[1] - 1.5).abs() < 1e-14, "{z}");
    }
}
