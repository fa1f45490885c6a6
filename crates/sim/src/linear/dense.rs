//! Small dense linear algebra: square systems, minimum-norm solutions, rank, motions without inertia.

use faer::MatRef;
use faer::prelude::Solve;
use nalgebra::{DMatrix, DVector};

use super::svd::{Svd, view};

/// Relative size below which a singular value counts as zero. A pose that is closed to rounding
/// shows dependent rows at 1e-12 and better; a mechanism within this of a singular pose is one.
pub(crate) const RANK_TOLERANCE: f64 = 1e-9;

/// Part of a row below which it depends on others: between what rounding leaves of a dependent row
/// and the distance of a mechanism from a singular pose.
pub(crate) const DEPENDENT: f64 = 3e-7;

/// Solution x of A x = b by LU with row pivots, A n × n and b of n numbers; not finite where A is singular.
///
/// # Panics
/// If the sizes differ.
pub fn solve_square(matrix: &DMatrix<f64>, rhs: &DVector<f64>) -> DVector<f64> {
    if rhs.is_empty() {
        return rhs.clone();
    }
    let rhs = MatRef::from_column_major_slice(rhs.as_slice(), rhs.len(), 1);
    let solution = view(matrix).partial_piv_lu().solve(rhs);
    DVector::from_fn(solution.nrows(), |row, _| solution[(row, 0)])
}

/// Minimum-norm least-squares solution of `matrix x = rhs`, with the numeric rank.
pub(crate) fn least_squares(matrix: &DMatrix<f64>, rhs: &DVector<f64>) -> (DVector<f64>, usize) {
    let n = matrix.ncols();
    if matrix.nrows() == 0 || n == 0 {
        return (DVector::zeros(n), 0);
    }
    let Some(svd) = Svd::new(matrix) else { return (DVector::from_element(n, f64::NAN), 0) };
    let threshold = RANK_TOLERANCE * svd.largest();
    let rank = svd.singular_values.iter().filter(|&&s| s > threshold).count();
    (svd.solve(rhs, threshold), rank)
}

/// The inverse of a finite square matrix in all directions but the weakest, which it maps to zero.
pub(crate) fn truncated_inverse(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    const TRUNCATION: f64 = 1e-7;
    let (rows, columns) = matrix.shape();
    let inverse = |svd: Svd| svd.pseudo_inverse(TRUNCATION * svd.largest());
    Svd::new(matrix).map_or_else(|| DMatrix::zeros(columns, rows), inverse)
}

/// Rows of `jacobian` that depend on rows before them, and all rows that take part in a dependency.
///
/// Rows are scaled to unit length first, so that units do not decide.
pub(crate) fn dependent_rows(jacobian: &DMatrix<f64>) -> Dependence {
    let nc = jacobian.nrows();
    let mut scaled = jacobian.clone();
    let longest = scaled.row_iter().map(|row| row.norm()).fold(0.0, f64::max);
    for mut row in scaled.row_iter_mut() {
        let norm = row.norm();
        // A row of rounding errors constrains nothing in this pose.
        row /= if norm > RANK_TOLERANCE * longest { norm } else { f64::INFINITY };
    }
    // Rows are taken one by one in file order, each freed of its part along the independent ones before it.
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut dependent = Vec::new();
    for row_idx in 0..nc {
        let mut rest = scaled.row(row_idx).transpose();
        if rest.amax() == 0.0 {
            dependent.push(row_idx);
            continue;
        }
        for _ in 0..2 {
            for direction in &basis {
                let along = direction.dot(&rest);
                rest.axpy(-along, direction, 1.0);
            }
        }
        let norm = rest.norm();
        if norm > DEPENDENT {
            basis.push(rest / norm);
        } else {
            dependent.push(row_idx);
        }
    }
    let involved = rows_in_dependencies(&scaled, &dependent);
    Dependence { rank: basis.len(), dependent, involved }
}

/// Which rows of a matrix depend on which.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct Dependence {
    pub(crate) rank: usize,
    /// Rows that follow from rows before them.
    pub(crate) dependent: Vec<usize>,
    /// All rows that take part in a dependency, the dependent ones included.
    pub(crate) involved: Vec<usize>,
}

fn rows_in_dependencies(scaled: &DMatrix<f64>, dependent: &[usize]) -> Vec<usize> {
    let nc = scaled.nrows();
    let mut involved = vec![false; nc];
    let mut is_dependent = vec![false; nc];
    for &row in dependent {
        is_dependent[row] = true;
    }
    let others: Vec<usize> = (0..nc).filter(|&row| !is_dependent[row]).collect();
    let independent = scaled.select_rows(&others).transpose();
    for &row_idx in dependent {
        involved[row_idx] = true;
        // Rows of zeros, as of open contacts, involve no others.
        let row = scaled.row(row_idx).transpose();
        if row.amax() == 0.0 {
            continue;
        }
        // The row as a combination of the independent ones: its coefficients name the partners.
        let (coefficients, _) = least_squares(&independent, &row);
        for (&other, coefficient) in others.iter().zip(coefficients.iter()) {
            involved[other] |= coefficient.abs() > 1e-6;
        }
    }
    (0..nc).filter(|&row| involved[row]).collect()
}

/// Coordinates of a motion that the constraints leave free and that has no inertia.
pub(crate) fn motion_without_inertia(
    mass: &DMatrix<f64>,
    jacobian: &DMatrix<f64>,
) -> Option<Vec<usize>> {
    /// Part of the largest inertia below which another may be none.
    const NONE: f64 = 1e-14;
    /// Part that is more than none in spite of rounding.
    const CERTAIN: f64 = 1e-11;
    let nq = mass.nrows();
    if nq == 0 {
        return None;
    }
    let scale = mass.amax();
    // With inertia in every direction there is none.
    let rest = mass - DMatrix::from_diagonal_element(nq, nq, CERTAIN * scale);
    if scale > 0.0 && rest.cholesky().is_some() {
        return None;
    }
    // Padding to nq rows makes the decomposition return the null space as well.
    let mut padded = DMatrix::zeros(jacobian.nrows().max(nq), nq);
    padded.rows_mut(0, jacobian.nrows()).copy_from(jacobian);
    let svd = Svd::new(&padded)?;
    let threshold = 1e-9 * svd.largest();
    let free: Vec<usize> = (0..nq).filter(|&k| svd.singular_values[k] <= threshold).collect();
    if free.is_empty() {
        return None;
    }
    let basis = svd.v_t.select_rows(&free).transpose();
    let reduced = basis.transpose() * mass * &basis;
    let eigen = reduced.symmetric_eigen();
    let weak = eigen.eigenvalues.iter().position(|&value| value <= NONE * scale)?;
    let direction = &basis * eigen.eigenvectors.column(weak);
    let largest = direction.amax();
    Some((0..nq).filter(|&i| direction[i].abs() > 0.1 * largest).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_doubled_row_is_dependent_and_names_its_partner() {
        let jacobian = DMatrix::from_row_slice(3, 3, &[1., 0., 0., 0., 2., 1., 3., 0., 0.]);
        let found = dependent_rows(&jacobian);
        let expected = Dependence { rank: 2, dependent: vec![2], involved: vec![0, 2] };
        assert_eq!(found, expected);
    }

    #[test]
    fn minimum_norm_shares_a_load_between_equal_supports() {
        let matrix = DMatrix::from_row_slice(1, 2, &[1.0, 1.0]);
        let (x, rank) = least_squares(&matrix, &DVector::from_element(1, 3.0));
        assert_eq!(rank, 1);
        assert!((x - DVector::from_element(2, 1.5)).amax() < 1e-14);
    }
}
