//! [`Normal`]: the damped normal equations of a part, (JᵀJ + μ) s = Jᵀr, in room that is kept.
//!
//! A search solves some hundred of them for each start, most with few unknowns.

/// JᵀJ, Jᵀr and |r|² of rows of numbers.
pub(super) struct Normal {
    n: usize,
    /// JᵀJ on and below the diagonal, by columns.
    matrix: Vec<f64>,
    /// Jᵀr.
    slope: Vec<f64>,
    /// |r|².
    cost: f64,
    /// L of L Lᵀ = JᵀJ + μ, as `matrix`.
    factor: Vec<f64>,
}

impl Normal {
    /// The equations of no rows in n unknowns.
    pub(super) fn new(n: usize) -> Self {
        let square = || vec![0.0; n * n];
        Self { n, matrix: square(), slope: vec![0.0; n], cost: 0.0, factor: square() }
    }

    /// Takes all rows out.
    pub(super) fn clear(&mut self) {
        self.matrix.fill(0.0);
        self.slope.fill(0.0);
        self.cost = 0.0;
    }

    /// Adds a row of J with its r.
    pub(super) fn add(&mut self, row: &[(usize, f64)], value: f64) {
        self.cost += value * value;
        for (place, &(i, a)) in row.iter().enumerate() {
            self.slope[i] += a * value;
            for &(j, b) in &row[place..] {
                self.matrix[i.min(j) * self.n + i.max(j)] += a * b;
            }
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
        let Self { n, matrix, slope, factor, .. } = self;
        let n = *n;
        factor.copy_from_slice(matrix);
        for k in 0..n {
            // Column k of L is done; the columns after it still lack their parts along it.
            let (done, after) = factor.split_at_mut((k + 1) * n);
            let column = &mut done[k * n + k..];
            let square = column[0] + damping;
            if square.is_nan() || square <= 0.0 {
                return false;
            }
            let pivot = square.sqrt();
            column[0] = pivot;
            column[1..].iter_mut().for_each(|l| *l /= pivot);
            for (other, column_after) in (k + 1..n).zip(after.chunks_exact_mut(n.max(1))) {
                let below = &column[other - k..];
                let part = below[0];
                if part != 0.0 {
                    let entries = column_after[other..].iter_mut().zip(below);
                    entries.for_each(|(entry, l)| *entry -= part * l);
                }
            }
        }

        s.copy_from_slice(slope);
        for (k, column) in factor.chunks_exact(n.max(1)).enumerate() {
            s[k] /= column[k];
            let known = s[k];
            s[k + 1..].iter_mut().zip(&column[k + 1..]).for_each(|(s, l)| *s -= known * l);
        }
        for (k, column) in factor.chunks_exact(n.max(1)).enumerate().rev() {
            let along: f64 = s[k + 1..].iter().zip(&column[k + 1..]).map(|(s, l)| s * l).sum();
            s[k] = (s[k] - along) / column[k];
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    #[test]
    fn the_solution_is_that_of_the_dense_equations() {
        let rows: [(&[(usize, f64)], f64); 4] = [
            (&[(0, 1.0), (2, -2.0)], 0.5),
            (&[(2, 0.3), (1, 4.0)], -1.0),
            (&[(1, 1.0)], 2.0),
            (&[(0, -1.5), (1, 0.7), (2, 0.2)], 0.1),
        ];
        let mut normal = Normal::new(3);
        let mut j = DMatrix::zeros(4, 3);
        for (k, (row, value)) in rows.into_iter().enumerate() {
            normal.add(row, value);
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
        let mut normal = Normal::new(2);
        normal.add(&[(0, 1.0)], 1.0);
        assert!(!normal.solve_into(0.0, &mut [0.0; 2]));
        normal.add(&[(1, f64::NAN)], 1.0);
        assert!(normal.largest().is_nan() && !normal.solve_into(1.0, &mut [0.0; 2]));
    }
}
