//! [`Svd`]: singular values and vectors of dense matrices.
//!
//! They are those of faer. What nalgebra computes is wrong for some matrices with many zeros, as Jacobians are: of
//! 200 000 random ones with up to six rows, products of its factors missed 34 by more than 1e-10 of the largest
//! singular value and 13 by more than 1e-3 (nalgebra 0.35; its issue 1172 is open).

use faer::MatRef;
use nalgebra::{DMatrix, DVector};

/// Numbers that matrices are decomposed of, real or complex.
pub trait Entry:
    nalgebra::ComplexField<RealField = f64> + faer::traits::ComplexField<Real = f64>
{
}

impl<T> Entry for T where
    T: nalgebra::ComplexField<RealField = f64> + faer::traits::ComplexField<Real = f64>
{
}

/// Singular value decomposition A = U diag(σ) Vᴴ of an m × n matrix, with k = min(m, n) singular values.
#[derive(Clone, PartialEq, Debug)]
pub struct Svd<T: Entry = f64> {
    /// Left singular vectors, m × k.
    pub u: DMatrix<T>,
    /// Singular values, k, in descending order.
    pub singular_values: DVector<f64>,
    /// Vᴴ, k × n: right singular vectors, conjugate, one to a row.
    pub v_t: DMatrix<T>,
}

impl<T: Entry> Svd<T> {
    /// The decomposition of a matrix; `None` where an entry is not finite.
    pub fn new(matrix: &DMatrix<T>) -> Option<Self> {
        let (m, n) = matrix.shape();
        if m == 0 || n == 0 {
            let (u, v_t) = (DMatrix::zeros(m, 0), DMatrix::zeros(0, n));
            return Some(Self { u, singular_values: DVector::zeros(0), v_t });
        }
        if !is_finite(matrix) {
            return None;
        }
        let svd = view(matrix).thin_svd().ok()?;
        let (u, v, values) = (svd.U(), svd.V(), svd.S().column_vector());
        let k = values.nrows();
        Some(Self {
            u: DMatrix::from_fn(m, k, |row, column| u[(row, column)].clone()),
            singular_values: DVector::from_fn(k, |place, _| values[place].clone().real()),
            v_t: DMatrix::from_fn(k, n, |row, column| v[(column, row)].clone().conjugate()),
        })
    }

    /// The largest singular value, zero of an empty matrix.
    pub fn largest(&self) -> f64 {
        self.singular_values.iter().copied().fold(0.0, f64::max)
    }

    /// The place of the smallest singular value, the last one.
    pub fn last(&self) -> usize {
        self.singular_values.len().saturating_sub(1)
    }
}

impl Svd {
    /// The singular values alone, as of [`Svd::new`].
    pub fn values(matrix: &DMatrix<f64>) -> Option<DVector<f64>> {
        let (m, n) = matrix.shape();
        if m == 0 || n == 0 {
            return Some(DVector::zeros(0));
        }
        if !is_finite(matrix) {
            return None;
        }
        view(matrix).singular_values().ok().map(DVector::from_vec)
    }

    /// The shortest x that comes nearest to A x = `right`, m, singular values up to `floor` taken as zero.
    pub fn solve(&self, right: &DVector<f64>, floor: f64) -> DVector<f64> {
        let mut parts = self.u.tr_mul(right);
        self.divide(&mut parts, floor);
        self.v_t.tr_mul(&parts)
    }

    /// A⁺, n × m, singular values up to `floor` taken as zero.
    pub fn pseudo_inverse(&self, floor: f64) -> DMatrix<f64> {
        let mut parts = self.u.transpose();
        parts.column_iter_mut().for_each(|mut column| {
            for (part, &value) in column.iter_mut().zip(&self.singular_values) {
                *part = quotient(*part, value, floor);
            }
        });
        self.v_t.tr_mul(&parts)
    }

    fn divide(&self, parts: &mut DVector<f64>, floor: f64) {
        for (part, &value) in parts.iter_mut().zip(&self.singular_values) {
            *part = quotient(*part, value, floor);
        }
    }
}

fn quotient(part: f64, value: f64, floor: f64) -> f64 {
    if value > floor { part / value } else { 0.0 }
}

fn is_finite<T: Entry>(matrix: &DMatrix<T>) -> bool {
    matrix.iter().all(|value| nalgebra::ComplexField::is_finite(value))
}

/// Numbers of a matrix as a matrix of faer.
pub(super) fn view<T: Entry>(matrix: &DMatrix<T>) -> MatRef<'_, T> {
    let (m, n) = matrix.shape();
    MatRef::from_column_major_slice(matrix.as_slice(), m, n)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Matrices of zeros, ones, small and random numbers, as Jacobians have them.
    fn sparse((m, n): (usize, usize), next: &mut impl FnMut() -> f64) -> DMatrix<f64> {
        DMatrix::from_fn(m, n, |_, _| match next() {
            part if part < 0.35 => 2.0 * next() - 1.0,
            part if part < 0.5 => 1.0,
            part if part < 0.55 => 1.5e-3,
            _ => 0.0,
        })
    }

    #[test]
    fn the_factors_of_sparse_matrices_give_them_back_and_solve_them() {
        let mut state = 7_u64;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for case in 0..20_000 {
            let m = 1 + case % 6;
            let matrix = sparse((m, m + case / 6 % 5), &mut next);
            let svd = Svd::new(&matrix).expect("finite");
            let size = svd.largest().max(f64::MIN_POSITIVE);
            let back = &svd.u * DMatrix::from_diagonal(&svd.singular_values) * &svd.v_t;
            assert!((back - &matrix).amax() <= 1e-13 * size, "{matrix}");
            let values = Svd::values(&matrix).expect("finite");
            assert!((values - &svd.singular_values).amax() <= 1e-13 * size, "{matrix}");
            // What the rows give of some x is found again.
            let right = &matrix * DVector::from_fn(matrix.ncols(), |_, _| next());
            let x = svd.solve(&right, 1e-9 * size);
            assert!((&matrix * x - &right).amax() <= 1e-7 * size, "{matrix}");
            let inverse = svd.pseudo_inverse(1e-9 * size);
            assert!((&matrix * (inverse * &right) - right).amax() <= 1e-7 * size, "{matrix}");
        }
    }

    /// A gear pair and a screw on one crank, with the crank's rate: nalgebra's factors miss it by 4e-10.
    #[test]
    fn the_rates_of_a_crank_with_a_gear_and_a_screw_are_met() {
        let lead = -0.0098 / std::f64::consts::TAU;
        let rows = [
            [0.098_148_39, 0.122_872_207, 0.0, 0.0, 0.0, 0.0],
            [lead, 0.0, 1.0, 0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        ];
        let matrix = DMatrix::from_row_slice(3, 6, rows.as_flattened());
        let right = DVector::from_row_slice(&[0.0, 0.0, -0.67]);
        let x = Svd::new(&matrix).expect("finite").solve(&right, 1e-9);
        assert!((matrix * x - right).amax() < 1e-15);
    }

    #[test]
    fn empty_matrices_have_no_singular_values_and_others_must_be_finite() {
        let empty = Svd::new(&DMatrix::zeros(0, 3)).expect("no entry");
        assert_eq!(empty.solve(&DVector::zeros(0), 0.0), DVector::zeros(3));
        assert_eq!(empty.pseudo_inverse(0.0), DMatrix::zeros(3, 0));
        assert_eq!(Svd::new(&DMatrix::from_element(2, 2, f64::NAN)), None);
    }
}
