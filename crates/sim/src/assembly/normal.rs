//! [`Normal`]: the damped normal equations of a part, (JᵀJ + μ) s = Jᵀr, in room that is kept.
//!
//! A search solves some hundred of them for each start, most with few unknowns.

/// JᵀJ, Jᵀr and |r|² of rows of numbers whose entries are known beforehand.
pub(super) struct Normal {
    n: usize,
    /// The unknown of each entry of J, row by row.
    unknowns: Vec<usize>,
    /// Products that each row adds to JᵀJ.
    products: Vec<Product>,
    /// Their number up to the end of each row.
    ends: Vec<usize>,
    /// The rows that were added.
    n_rows: usize,
    /// Their entries.
    entries: Vec<f64>,
    /// JᵀJ on and below the diagonal, by columns.
    matrix: Vec<f64>,
    /// Jᵀr.
    slope: Vec<f64>,
    /// |r|².
    cost: f64,
    /// L and the inverse of D of L D Lᵀ = JᵀJ + μ, as `matrix`.
    factor: Vec<f64>,
}

/// Product of two entries of a row.
struct Product {
    /// Place in the matrix.
    place: usize,
    of: [usize; 2],
}

impl Normal {
    /// The equations in n unknowns of no rows yet; the rows to come have entries by these unknowns.
    pub(super) fn new(n: usize, rows: &[Vec<usize>]) -> Self {
        let unknowns = rows.concat();
        let (mut products, mut ends, mut first) = (Vec::new(), Vec::new(), 0);
        for row in rows {
            let all = first..first + row.len();
            for a in all.clone() {
                products.extend((a..all.end).map(|b| {
                    let (i, j) = (unknowns[a], unknowns[b]);
                    Product { place: i.min(j) * n + i.max(j), of: [a, b] }
                }));
            }
            ends.push(products.len());
            first = all.end;
        }
        let (square, entries) = (vec![0.0; n * n], Vec::with_capacity(unknowns.len()));
        Self {
            n,
            unknowns,
            products,
            ends,
            n_rows: 0,
            entries,
            matrix: square.clone(),
            slope: vec![0.0; n],
            cost: 0.0,
            factor: square,
        }
    }

    /// Takes all rows out.
    pub(super) fn clear(&mut self) {
        self.n_rows = 0;
        self.entries.clear();
        self.slope.fill(0.0);
        self.cost = 0.0;
    }

    /// Adds the next row of J with its r.
    pub(super) fn add(&mut self, row: impl Iterator<Item = f64>, value: f64) {
        self.n_rows += 1;
        self.cost += value * value;
        for entry in row {
            self.slope[self.unknowns[self.entries.len()]] += entry * value;
            self.entries.push(entry);
        }
    }

    /// Multiplies the rows that were added.
    pub(super) fn multiply(&mut self) {
        self.matrix.fill(0.0);
        let n_products = self.n_rows.checked_sub(1).map_or(0, |last| self.ends[last]);
        for Product { place, of: [a, b] } in &self.products[..n_products] {
            self.matrix[*place] += self.entries[*a] * self.entries[*b];
        }
    }

    /// |r|².
    pub(super) fn cost(&self) -> f64 {
        self.cost
    }

    /// Jᵀr.
    pub(super) fn slope(&self) -> &[f64] {
        &self.slope
    }

    /// The largest entry of JᵀJ.
    pub(super) fn largest(&self) -> f64 {
        let diagonal = (0..self.n).map(|i| self.matrix[i * self.n + i]);
        // What is not a number damps nothing.
        diagonal.fold(0.0, |a: f64, b| if b.is_nan() { b } else { a.max(b) })
    }

    /// Writes s for the damping μ; false where JᵀJ + μ is not positive definite to rounding.
    pub(super) fn solve_into(&mut self, damping: f64, s: &mut [f64]) -> bool {
        self.factor.copy_from_slice(&self.matrix);
        s.copy_from_slice(&self.slope);
        let l = self.factor.as_mut_slice();
        // Most parts have few unknowns: loops whose lengths are known are laid out flat.
        match self.n {
            1 => solve(1, l, damping, s),
            2 => solve(2, l, damping, s),
            3 => solve(3, l, damping, s),
            4 => solve(4, l, damping, s),
            5 => solve(5, l, damping, s),
            6 => solve(6, l, damping, s),
            7 => solve(7, l, damping, s),
            FLAT => solve(FLAT, l, damping, s),
            n => solve(n, l, damping, s),
        }
    }
}

/// Unknowns up to which solutions are laid out flat.
const FLAT: usize = 8;

/// One beyond the last number that is not zero.
fn end_of(column: &[f64]) -> usize {
    column.iter().rposition(|l| *l != 0.0).map_or(0, |last| last + 1)
}

/// Factors the n × n matrix A + μ, of which `a` has what is on and below the diagonal by columns, in place, and solves
/// L D Lᵀ s = s; false where it is not positive definite to rounding. Each pivot is divided by once: quotients wait long.
#[expect(clippy::inline_always, reason = "n is to be a constant")]
#[inline(always)]
fn solve(n: usize, a: &mut [f64], damping: f64, s: &mut [f64]) -> bool {
    assert!(a.len() == n * n && s.len() == n, "n × n numbers for n unknowns");
    for k in 0..n {
        // Column k of L D is done; the columns after it still lack their parts along it.
        let pivot = a[k * n + k] + damping;
        if pivot.is_nan() || pivot <= 0.0 {
            return false;
        }
        let inverse = 1.0 / pivot;
        a[k * n + k] = inverse;
        // Chains of bodies leave the ends of many columns empty.
        let end = if n <= FLAT { n } else { end_of(&a[k * n..][..n]) };
        for j in k + 1..end {
            let part = a[k * n + j] * inverse;
            if n <= FLAT || part != 0.0 {
                for i in j..end {
                    a[j * n + i] -= part * a[k * n + i];
                }
            }
            a[k * n + j] = part;
        }
    }

    for k in 0..n {
        for i in k + 1..n {
            s[i] -= s[k] * a[k * n + i];
        }
    }
    for k in (0..n).rev() {
        s[k] *= a[k * n + k];
        for i in k + 1..n {
            s[k] -= s[i] * a[k * n + i];
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    fn of_rows(n: usize, rows: &[(&[(usize, f64)], f64)]) -> Normal {
        let unknowns = |(row, _): &(&[(usize, f64)], f64)| row.iter().map(|(i, _)| *i).collect();
        let mut normal = Normal::new(n, &rows.iter().map(unknowns).collect::<Vec<_>>());
        normal.clear();
        for (row, value) in rows {
            normal.add(row.iter().map(|(_, a)| *a), *value);
        }
        normal.multiply();
        normal
    }

    #[test]
    fn the_solution_is_that_of_the_dense_equations() {
        let rows: [(&[(usize, f64)], f64); 4] = [
            (&[(0, 1.0), (2, -2.0)], 0.5),
            (&[(2, 0.3), (1, 4.0)], -1.0),
            (&[(1, 1.0)], 2.0),
            (&[(0, -1.5), (1, 0.7), (2, 0.2)], 0.1),
        ];
        let mut normal = of_rows(3, &rows);
        let mut j = DMatrix::zeros(4, 3);
        for (k, (row, _)) in rows.into_iter().enumerate() {
            for &(i, a) in row {
                j[(k, i)] = a;
            }
        }
        let r = DVector::from_iterator(4, rows.iter().map(|(_, value)| *value));
        let damped = j.transpose() * &j + 0.1 * DMatrix::identity(3, 3);
        let mut s = [0.0; 3];
        assert!(normal.solve_into(0.1, &mut s));
        let left: DVector<f64> = damped * DVector::from_row_slice(&s) - j.transpose() * &r;
        assert!(left.amax() < 1e-14);
        assert!((normal.cost() - r.norm_squared()).abs() < 1e-15);
        assert!((normal.largest() - 17.49).abs() < 1e-13);
    }

    #[test]
    fn what_no_row_holds_has_no_solution_without_damping() {
        let mut normal = of_rows(2, &[(&[(0, 1.0)], 1.0)]);
        assert!(!normal.solve_into(0.0, &mut [0.0; 2]));
        let mut normal = of_rows(2, &[(&[(0, 1.0)], 1.0), (&[(1, f64::NAN)], 1.0)]);
        assert!(normal.largest().is_nan() && !normal.solve_into(1.0, &mut [0.0; 2]));
    }

    #[test]
    fn systems_of_any_size_are_solved_alike() {
        for n in 1..12 {
            let row = |k: usize| (0..n).map(move |i| (i, (1.0 + (k * n + i * i) as f64).sin()));
            let rows: Vec<Vec<(usize, f64)>> = (0..=n).map(|k| row(k).collect()).collect();
            let rows: Vec<(&[(usize, f64)], f64)> = rows.iter().map(|row| (&**row, 1.0)).collect();
            let mut normal = of_rows(n, &rows);
            let mut s = vec![0.0; n];
            assert!(normal.solve_into(0.1, &mut s));
            let j = DMatrix::from_fn(n + 1, n, |k, i| rows[k].0[i].1);
            let damped = j.transpose() * &j + 0.1 * DMatrix::identity(n, n);
            let left: DVector<f64> =
                damped * DVector::from_row_slice(&s) - j.transpose().column_sum();
            assert!(left.amax() < 1e-12, "{n}: {left}");
        }
    }
}
