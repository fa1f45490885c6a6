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

/// z of a solution; `None` where the method finds none.
pub(super) fn lemke(m: &DMatrix<f64>, q: &DVector<f64>) -> Option<DVector<f64>> {
    let n = q.len();
    let size = q.amax();
    if n == 0 || q.iter().all(|&q| q >= 0.0) {
        return Some(DVector::zeros(n));
    }
    // Columns: w, z, the covering variable, and the right side.
    let cover = 2 * n;
    let mut table = DMatrix::zeros(n, 2 * n + 2);
    let mut apart = APART * size;
    for i in 0..n {
        table[(i, i)] = 1.0;
        for j in 0..n {
            table[(i, n + j)] = -m[(i, j)];
        }
        table[(i, cover)] = -1.0;
        // Not alike, and none the sum of others.
        apart *= 1.37;
        if apart > 1e3 * APART * size {
            apart = 1.013 * APART * size;
        }
        table[(i, cover + 1)] = q[i] + apart;
    }
    let mut basis: Vec<usize> = (0..n).collect();
    let least = |table: &DMatrix<f64>| table.column(cover + 1).imin();
    let mut leaving = least(&table);
    if table[(leaving, cover + 1)] >= 0.0 {
        return Some(DVector::zeros(n));
    }
    let mut entering = cover;
    for _ in 0..50 * (n + 1) {
        // The entering column becomes a unit column.
        let pivot = table[(leaving, entering)];
        let row = table.row(leaving) / pivot;
        table.row_mut(leaving).copy_from(&row);
        for i in (0..n).filter(|&i| i != leaving) {
            let factor = table[(i, entering)];
            if factor != 0.0 {
                let changed = table.row(i) - &row * factor;
                table.row_mut(i).copy_from(&changed);
            }
        }
        let left = std::mem::replace(&mut basis[leaving], entering);
        if left == cover {
            let mut z = DVector::zeros(n);
            for (i, &variable) in basis.iter().enumerate() {
                if (n..2 * n).contains(&variable) {
                    z[variable - n] = table[(i, cover + 1)].max(0.0);
                }
            }
            return Some(z);
        }
        // Its complement enters; the row that reaches zero first leaves, that of the covering variable before others.
        entering = if left < n { left + n } else { left - n };
        let column = table.column(entering);
        let smallest = ROUNDING * column.amax();
        let ratios = (0..n).filter(|&i| column[i] > smallest);
        let ratios = ratios.map(|i| (i, table[(i, cover + 1)].max(0.0) / column[i]));
        leaving = ratios.min_by(|a, b| a.1.total_cmp(&b.1))?.0;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_are_complementary() {
        let m = DMatrix::from_row_slice(3, 3, &[2.0, 1.0, 0.0, 1.0, 2.0, 1.0, 0.0, 1.0, 2.0]);
        let q = DVector::from_vec(vec![-1.0, -3.0, 1.0]);
        let z = lemke(&m, &q).expect("a solution");
        let w = &m * &z + &q;
        assert!(z.min() >= 0.0 && w.min() > -1e-7, "z {z}, w {w}");
        assert!(z.dot(&w).abs() < 1e-7, "z {z}, w {w}");
        assert!((z[1] - 1.5).abs() < 1e-7, "{z}");
    }
}
