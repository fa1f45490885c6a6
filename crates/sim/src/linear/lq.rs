//! The smallest solution of equations whose rows are far from depending on each other.
//!
//! ```text
//! Gᵀ P = Q R,    x = Q R⁻ᵀ Pᵀ r
//! ```
//!
//! Householder's reflections take the rows one after the other, the one with the largest entry left first. Where little
//! is left of a row, singular values must decide what counts as nothing. They take many times as long.
//!
//! Source: G. H. Golub and C. F. Van Loan, *Matrix Computations*, 4th ed. 2013, §5.4.2, §5.6.2.

use nalgebra::{DMatrix, DVector};

/// Part of the longest row that is left of each row without those before it. The smallest singular value is seldom
/// much smaller than that part, and counts as zero at a hundred-thousandth of it.
const CLEAR: f64 = 1e-4;

/// The shortest x with G x = r, the rows of G of length `n` one after the other; `None` where they may depend on each
/// other, or an entry is not finite.
pub(crate) fn shortest_solution(rows: Vec<f64>, n: usize, r: &[f64]) -> Option<Vec<f64>> {
    let m = r.len();
    if m > n {
        return None;
    }
    if m == 0 {
        return Some(vec![0.0; n]);
    }
    // Rows are the columns of the transpose.
    let factors = DMatrix::from_vec(n, m, rows).col_piv_qr();
    let upper = factors.r();
    let left = upper.diagonal();
    let is_clear =
        |left_of_row: &f64| left_of_row.is_finite() && *left_of_row > CLEAR * left.amax();
    if !left.iter().all(is_clear) {
        return None;
    }
    let mut y = DVector::from_column_slice(r);
    factors.p().permute_rows(&mut y);
    let y = upper.tr_solve_upper_triangular(&y)?;
    let x = factors.q() * y;
    Some(x.as_slice().to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::dense::least_squares;

    fn random() -> impl FnMut() -> f64 {
        let mut state = 3_u64;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            2.0 * ((state >> 11) as f64 / (1_u64 << 53) as f64) - 1.0
        }
    }

    /// Numbers of which many are zero, one or small, as those of Jacobians are.
    fn entry(next: &mut impl FnMut() -> f64) -> f64 {
        match next() {
            kind if kind > 0.2 => next(),
            kind if kind > 0.0 => 1.0,
            kind if kind > -0.1 => 1.5e-3,
            _ => 0.0,
        }
    }

    #[test]
    fn solutions_are_those_by_singular_values() {
        let mut next = random();
        let mut n_solved = 0;
        for case in 0..5000 {
            let m = 1 + case % 8;
            let n = m + case / 8 % 5;
            let rows: Vec<f64> = (0..m * n).map(|_| entry(&mut next)).collect();
            let r: Vec<f64> = (0..m).map(|_| next()).collect();
            let matrix = DMatrix::from_row_slice(m, n, &rows);
            let Some(found) = shortest_solution(rows, n, &r) else { continue };
            n_solved += 1;
            let (expected, rank) = least_squares(&matrix, &DVector::from_vec(r));
            assert_eq!(rank, m, "{matrix}");
            let error = (DVector::from_vec(found) - &expected).amax();
            assert!(error <= 1e-10 * expected.amax().max(1.0), "{error:e} of {matrix}");
        }
        assert!(n_solved > 3500, "{n_solved} of 5000");
    }

    #[test]
    fn rows_that_may_depend_on_each_other_are_left_to_singular_values() {
        let solved = |rows: &[f64], n: usize, r: &[f64]| shortest_solution(rows.to_vec(), n, r);
        let near = |apart: f64| solved(&[1.0, 2.0, 0.0, 2.0, 4.0 + apart, 0.0], 3, &[1.0, 1.0]);
        assert_eq!((near(0.0), near(1e-6)), (None, None));
        assert!(near(1e-2).is_some());
        assert_eq!(solved(&[0.0, f64::NAN], 2, &[1.0]), None);
        // More equations than unknowns, and none.
        assert_eq!(solved(&[1.0, 1.0], 1, &[1.0, 1.0]), None);
        assert_eq!(solved(&[], 2, &[]), Some(vec![0.0, 0.0]));
    }
}
