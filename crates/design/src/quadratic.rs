//! Strictly convex quadratic programs, by the dual method of Goldfarb and Idnani.
//!
//! ```text
//! min ½ xᵀ H x + gᵀ x      aᵢᵀ x ≥ bᵢ,   the first `n_equal` rows with =
//! ```
//!
//! It begins at the minimum without rows and adds the row that is violated most, dropping rows whose
//! multipliers would change sign. Source: Goldfarb, Idnani, Mathematical Programming 27 (1983).

use nalgebra::{DMatrix, DVector};

/// A solution with the multiplier of every row; H x + g = Σ uᵢ aᵢ.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    pub(crate) x: DVector<f64>,
    pub(crate) multipliers: DVector<f64>,
}

/// Rows that are violated by less than this part of their size hold.
const TOLERANCE: f64 = 1e-13;

/// The minimum; `None` where the rows exclude each other, or H is not positive definite.
pub(crate) fn minimum(
    h: &DMatrix<f64>,
    g: &DVector<f64>,
    (a, b): (&DMatrix<f64>, &DVector<f64>),
    n_equal: usize,
) -> Option<Solution> {
    let cholesky = h.clone().cholesky()?;
    let mut x = -cholesky.solve(g);
    let n_rows = a.nrows();
    let mut active: Vec<usize> = Vec::new();
    // Equations that hold from below have their sign turned.
    let mut sign = vec![1.0; n_rows];
    let mut u = DVector::zeros(n_rows);
    let slack = |row: usize, x: &DVector<f64>| a.row(row).dot(&x.transpose()) - b[row];
    let size = |row: usize| a.row(row).norm() + b[row].abs() + 1e-300;

    for _ in 0..200 + 20 * n_rows {
        // The row that is violated most, equations first.
        let violation = |row: usize| {
            let s = slack(row, &x) / size(row);
            if row < n_equal { s.abs() } else { -s }
        };
        let is_open = |row: &usize| !active.contains(row);
        let worst = |rows: std::ops::Range<usize>| {
            let rows = rows.filter(is_open).map(|row| (row, violation(row)));
            rows.max_by(|x, y| x.1.total_cmp(&y.1)).filter(|(_, v)| *v > TOLERANCE)
        };
        let Some((row, _)) = worst(0..n_equal).or_else(|| worst(n_equal..n_rows)) else {
            let multipliers = DVector::from_fn(n_rows, |row, _| sign[row] * u[row]);
            return Some(Solution { x, multipliers });
        };
        sign[row] = if row < n_equal && slack(row, &x) > 0.0 { -1.0 } else { 1.0 };
        let mut u_new = 0.0;
        loop {
            // Directions in x and in the multipliers of active rows.
            let normal: DVector<f64> = a.row(row).transpose() * sign[row];
            let m = active.len();
            let n_active = DMatrix::from_fn(x.len(), m, |i, k| a[(active[k], i)] * sign[active[k]]);
            let h_normal = cholesky.solve(&normal);
            let (z, r) = if m == 0 {
                (h_normal, DVector::zeros(0))
            } else {
                let h_active = cholesky.solve(&n_active);
                let gram = n_active.transpose() * &h_active;
                let r =
                    gram.svd(true, true).solve(&(n_active.transpose() * &h_normal), 1e-14).ok()?;
                (h_normal - h_active * &r, r)
            };
            // The longest step that keeps multipliers above zero, and the one that meets the row.
            let can_leave = |k: &usize| active[*k] >= n_equal && r[*k] > 1e-14;
            let leaving = (0..m).filter(can_leave).map(|k| (k, u[active[k]] / r[k]));
            let leaving = leaving.min_by(|x: &(usize, f64), y| x.1.total_cmp(&y.1));
            let curvature = z.dot(&normal);
            let s = sign[row] * slack(row, &x);
            let full = if curvature > 1e-12 * normal.norm_squared() / h.norm().max(1e-300) {
                -s / curvature
            } else {
                f64::INFINITY
            };
            let partial = leaving.map_or(f64::INFINITY, |(_, t)| t);
            let t = full.min(partial);
            if !t.is_finite() {
                return None;
            }
            if full.is_finite() {
                x += &z * t;
            }
            for k in 0..m {
                u[active[k]] -= t * r[k];
            }
            u_new += t;
            if full <= partial {
                u[row] = u_new;
                active.push(row);
                break;
            }
            if let Some((k, _)) = leaving {
                u[active.remove(k)] = 0.0;
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corner_has_the_multipliers_of_its_rows() {
        // min ½|x|² − (3, 2)·x, x₀ ≤ 1, x₁ ≤ 1, x₀ + x₁ = 1.5.
        let a = DMatrix::from_row_slice(3, 2, &[1.0, 1.0, -1.0, 0.0, 0.0, -1.0]);
        let b = DVector::from_column_slice(&[1.5, -1.0, -1.0]);
        let g = DVector::from_column_slice(&[-3.0, -2.0]);
        let found = minimum(&DMatrix::identity(2, 2), &g, (&a, &b), 1).expect("a minimum");
        assert!((found.x - DVector::from_column_slice(&[1.0, 0.5])).norm() < 1e-12);
        let expected = DVector::from_column_slice(&[-1.5, 0.5, 0.0]);
        assert!((&found.multipliers - expected).norm() < 1e-12, "{}", found.multipliers);
    }

    #[test]
    fn rows_that_exclude_each_other_have_no_minimum() {
        let a = DMatrix::from_row_slice(2, 1, &[1.0, -1.0]);
        let b = DVector::from_column_slice(&[1.0, 0.0]);
        let g = DVector::zeros(1);
        assert!(minimum(&DMatrix::identity(1, 1), &g, (&a, &b), 0).is_none());
    }
}
