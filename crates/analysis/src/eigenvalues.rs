//! Eigenvalues of matrices that are not symmetric.
//!
//! They are those of faer, whose iteration ends; nalgebra's goes on for ever with some matrices, such as
//! [0 1 0; 1 0 1; 0 1 0] (nalgebra 0.35).

use faer::MatRef;
use nalgebra::{Complex, DMatrix};

/// The eigenvalues of a square matrix, ascending by size, of a pair that with Im s > 0 first; none where an entry is
/// not finite.
pub(crate) fn eigenvalues(matrix: &DMatrix<f64>) -> Vec<Complex<f64>> {
    let n = matrix.nrows();
    if n == 0 || !matrix.iter().all(|value| value.is_finite()) {
        return Vec::new();
    }
    let found = MatRef::from_column_major_slice(matrix.as_slice(), n, n).eigenvalues();
    // What rounding leaves of a zero is none.
    let rounding = f64::EPSILON * matrix.norm();
    let clean = |part: f64| if part.abs() <= rounding { 0.0 } else { part };
    let found = found.unwrap_or_default().into_iter();
    let mut found: Vec<_> = found.map(|s| Complex::new(clean(s.re), clean(s.im))).collect();
    found.sort_by(|a, b| {
        let size = a.norm().total_cmp(&b.norm());
        size.then(a.re.total_cmp(&b.re)).then(b.im.total_cmp(&a.im))
    });
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_on_which_an_iteration_turns_in_a_circle_have_their_eigenvalues() {
        let root = 2.0_f64.sqrt();
        for (entries, expected) in [
            ([0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0], [0.0, root, root]),
            ([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], [0.0; 3]),
            ([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], [1.0; 3]),
        ] {
            let sizes = eigenvalues(&DMatrix::from_row_slice(3, 3, &entries));
            assert_eq!(sizes.len(), 3);
            for (found, expected) in sizes.iter().zip(expected) {
                assert!((found.norm() - expected).abs() < 1e-5, "{sizes:?}");
            }
        }
    }

    #[test]
    fn pairs_stand_together_with_the_positive_frequency_first() {
        let matrix =
            DMatrix::from_row_slice(3, 3, &[0.0, 4.0, 0.0, -4.0, 0.0, 0.0, 0.0, 0.0, -1.0]);
        let found = eigenvalues(&matrix);
        let expected = [[-1.0, 0.0], [0.0, 4.0], [0.0, -4.0]];
        for (found, [re, im]) in found.iter().zip(expected) {
            assert!((found - Complex::new(re, im)).norm() < 1e-14, "{found}");
        }
    }
}
