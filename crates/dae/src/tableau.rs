//! The Radau IIA methods with s = 1, 3, 5, 7 stages, derived from their definition.
//!
//! ```text
//! nodes        P_s(x) − P_{s−1}(x) = 0, x = 2c − 1       HW2 §IV.5, Radau IIA
//! collocation  Σ_j a_ij p(c_j) = ∫_0^{c_i} p, deg p < s  HW2 §IV.5, condition C(s)
//! weights      b_j = a_sj, as c_s = 1                    (stiffly accurate)
//! transform    A⁻¹ T = T Λ                               HW2 §IV.8, the linear system
//! ```
//!
//! For odd `s`, `A⁻¹` has one real eigenvalue `γ` and `(s − 1)/2` pairs `α ± iβ`. The columns of
//! `T` are the real eigenvector and the real and imaginary parts of one complex eigenvector per
//! pair, all scaled to end in 1, which gives Hairer's last row `(1, 1, 0, …)`.

use std::sync::OnceLock;

use faer::c64;
use nalgebra::{Complex, DMatrix, DVector};

use crate::settings::Stages;

/// Highest degree of a Legendre polynomial that is needed.
const MAX_DEGREE: usize = 8;

/// The coefficients of one method. Matrices are stored by rows, `s × s`.
#[derive(Clone, Debug)]
pub(crate) struct Tableau {
    /// The method.
    pub(crate) stages: Stages,
    /// Number of stages.
    pub(crate) s: usize,
    /// Nodes, ascending, `c_s = 1`.
    pub(crate) c: Vec<f64>,
    /// `A⁻¹`.
    pub(crate) a_inv: Vec<f64>,
    /// `T`: stage increments from transformed ones, `Z = T W`.
    pub(crate) t: Vec<f64>,
    /// `T⁻¹`.
    pub(crate) t_inv: Vec<f64>,
    /// The real eigenvalue of `A⁻¹`.
    pub(crate) gamma: f64,
    /// One eigenvalue `α − iβ` of each complex pair.
    ///
    /// With `W = (w_re, w_im)` on the columns `(Re u, Im u)` of `T` and `A⁻¹ u = (α + iβ) u`,
    /// `A⁻¹` acts as multiplication of `w_re + i w_im` by `α − iβ`.
    pub(crate) lambda: Vec<c64>,
    /// Coefficients `e` of the error estimate, see [`error_coefficients`].
    pub(crate) e: Vec<f64>,
    /// Rows that give the Legendre coefficients of `h u′` of degree `s − 2` and `s − 1` from the
    /// stage increments; both the last one for one stage.
    pub(crate) tail: [Vec<f64>; 2],
}

impl Tableau {
    /// The coefficients of a method, derived once.
    pub(crate) fn of(stages: Stages) -> &'static Self {
        static DERIVED: [OnceLock<Tableau>; 4] = [const { OnceLock::new() }; 4];
        DERIVED[stages.count() / 2].get_or_init(|| Self::new(stages))
    }

    /// Derives all coefficients; errors are a few units of rounding for every [`Stages`].
    pub(crate) fn new(stages: Stages) -> Self {
        let s = stages.count();
        let c = nodes(s);
        let (a, a_inv) = collocation_matrices(&c);
        let (gamma, pairs) = eigenvalues(&a_inv);
        let t = transform(&a_inv, gamma, &pairs);
        let t_inv = t.clone().try_inverse().expect("the eigenvalues of Radau IIA are distinct");
        let e = error_coefficients(&a, &c, gamma);
        let tail = legendre_tail(&a_inv, &c);
        let lambda = pairs.iter().map(|pair| c64::new(pair.re, -pair.im)).collect();
        let rows = |m: &DMatrix<f64>| m.transpose().as_slice().to_vec();
        Self {
            stages,
            s,
            c,
            a_inv: rows(&a_inv),
            t: rows(&t),
            t_inv: rows(&t_inv),
            gamma,
            lambda,
            e,
            tail,
        }
    }
}

/// Legendre polynomials `P_0 … P_8` on `[−1, 1]`, taken at `x = 2τ − 1`.
pub(crate) fn legendre(tau: f64) -> [f64; MAX_DEGREE + 1] {
    let x = 2.0 * tau - 1.0;
    let mut p = [1.0; MAX_DEGREE + 1];
    p[1] = x;
    for k in 1..MAX_DEGREE {
        let kf = k as f64;
        p[k + 1] = ((2.0 * kf + 1.0) * x * p[k] - kf * p[k - 1]) / (kf + 1.0);
    }
    p
}

/// `∫_0^τ P_k(2σ − 1) dσ` for `k = 0 … 7`: `(P_{k+1} − P_{k−1}) / (2 (2k + 1))`.
pub(crate) fn legendre_integrals(tau: f64) -> [f64; MAX_DEGREE] {
    let p = legendre(tau);
    std::array::from_fn(|k| match k {
        0 => tau,
        _ => (p[k + 1] - p[k - 1]) / (2.0 * (2.0 * k as f64 + 1.0)),
    })
}

/// The roots of `P_s − P_{s−1}`: bracketed on a grid far finer than their distance, then bisected.
pub(crate) fn nodes(s: usize) -> Vec<f64> {
    const GRID: usize = 128;
    let value = |tau: f64| {
        let p = legendre(tau);
        p[s] - p[s - 1]
    };
    let mut c: Vec<f64> = (0..GRID - 1)
        .map(|k| (k as f64 / GRID as f64, (k + 1) as f64 / GRID as f64))
        .filter(|&(left, right)| value(left) * value(right) < 0.0)
        .map(|(left, right)| bisect(value, left, right))
        .collect();
    c.push(1.0);
    assert_eq!(c.len(), s, "Radau IIA with s stages has s nodes in (0, 1]");
    c
}

fn bisect(value: impl Fn(f64) -> f64, mut left: f64, mut right: f64) -> f64 {
    let left_is_positive = value(left) > 0.0;
    loop {
        let middle = f64::midpoint(left, right);
        if middle <= left || middle >= right {
            return middle;
        }
        if (value(middle) > 0.0) == left_is_positive { left = middle } else { right = middle }
    }
}

/// `A` and `A⁻¹` from the collocation conditions, posed for Legendre polynomials: the power basis
/// would lose five digits at seven stages.
pub(crate) fn collocation_matrices(c: &[f64]) -> (DMatrix<f64>, DMatrix<f64>) {
    let s = c.len();
    let values = DMatrix::from_fn(s, s, |i, k| legendre(c[i])[k]);
    let integrals = DMatrix::from_fn(s, s, |i, k| legendre_integrals(c[i])[k]);
    let inverse = |m: &DMatrix<f64>| m.clone().try_inverse().expect("the nodes are distinct");
    (&integrals * inverse(&values), &values * inverse(&integrals))
}

/// The real eigenvalue and those with positive imaginary part, by ascending imaginary part.
fn eigenvalues(a_inv: &DMatrix<f64>) -> (f64, Vec<Complex<f64>>) {
    let all = a_inv.complex_eigenvalues();
    let real = all
        .iter()
        .min_by(|x, y| x.im.abs().total_cmp(&y.im.abs()))
        .expect("a method has at least one stage")
        .re;
    let mut pairs: Vec<_> = all.iter().copied().filter(|value| value.im > 0.5).collect();
    pairs.sort_by(|x, y| x.im.total_cmp(&y.im));
    (real, pairs)
}

/// The columns `u, Re u_1, Im u_1, …` of `T`.
fn transform(a_inv: &DMatrix<f64>, gamma: f64, pairs: &[Complex<f64>]) -> DMatrix<f64> {
    let mut columns = vec![eigenvector(a_inv, Complex::new(gamma, 0.0)).map(|x| x.re)];
    for &pair in pairs {
        let u = eigenvector(a_inv, pair);
        columns.extend([u.map(|x| x.re), u.map(|x| x.im)]);
    }
    DMatrix::from_columns(&columns)
}

/// The eigenvector that ends in 1: `(A⁻¹ − λ) u = 0` with its last row replaced by `u_s = 1`.
fn eigenvector(a_inv: &DMatrix<f64>, lambda: Complex<f64>) -> DVector<Complex<f64>> {
    let (s, one, zero) = (a_inv.nrows(), Complex::new(1.0, 0.0), Complex::new(0.0, 0.0));
    let mut bordered = a_inv.map(|x| Complex::new(x, 0.0));
    for i in 0..s {
        bordered[(i, i)] -= lambda;
    }
    bordered.row_mut(s - 1).fill(zero);
    bordered[(s - 1, s - 1)] = one;
    let mut right = DVector::from_element(s, zero);
    right[s - 1] = one;
    bordered.lu().solve(&right).expect("no eigenvector of Radau IIA ends in zero")
}

/// The coefficients `e` of the error estimate `γ₀ h y′(t₀) + Σ e_i z_i`, `γ₀ = 1/γ`.
///
/// The embedded formula adds `γ₀ h y′(t₀)` to the method and is exact for polynomials of degree `s`
/// (HW2 §IV.8, step size selection, (8.19)): `d = b̂ − b` solves `Σ d_i p(c_i) = −γ₀ p(0)` for `deg
/// p < s`. As `h Y′ = A⁻¹ Z`, `e = A⁻ᵀ d`.
fn error_coefficients(a: &DMatrix<f64>, c: &[f64], gamma: f64) -> Vec<f64> {
    let s = c.len();
    let values_t = DMatrix::from_fn(s, s, |k, i| legendre(c[i])[k]);
    let right = DVector::from_iterator(s, legendre(0.0)[..s].iter().map(|p| -p / gamma));
    let d = values_t.lu().solve(&right).expect("the nodes are distinct");
    let e = a.transpose().lu().solve(&d).expect("A is regular");
    e.as_slice().to_vec()
}

/// The last two Legendre coefficients of the polynomial through `h Y′ = A⁻¹ Z`, as rows on `Z`.
fn legendre_tail(a_inv: &DMatrix<f64>, c: &[f64]) -> [Vec<f64>; 2] {
    let s = c.len();
    let values = DMatrix::from_fn(s, s, |i, k| legendre(c[i])[k]);
    let rows = values.try_inverse().expect("the nodes are distinct") * a_inv;
    [s.saturating_sub(2), s - 1].map(|k| rows.row(k).iter().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Stages; 4] = [Stages::One, Stages::Three, Stages::Five, Stages::Seven];

    fn matrix(s: usize, rows: &[f64]) -> DMatrix<f64> {
        DMatrix::from_row_slice(s, s, rows)
    }

    fn coefficients(tableau: &Tableau) -> (DMatrix<f64>, DVector<f64>) {
        let a = matrix(tableau.s, &tableau.a_inv).try_inverse().expect("A is regular");
        let b = a.row(tableau.s - 1).transpose();
        (a, b)
    }

    fn assert_small(what: &str, s: usize, defect: f64) {
        assert!(defect.abs() < 2e-13, "{what}, {s} stages: defect {defect:e}");
    }

    #[test]
    fn three_stages_are_the_published_ones() {
        let tableau = Tableau::new(Stages::Three);
        let (a, _) = coefficients(&tableau);
        let r = 6f64.sqrt();
        // HW2 §IV.5, table 5.6.
        let c = [(4.0 - r) / 10.0, (4.0 + r) / 10.0, 1.0];
        let published = [
            (88.0 - 7.0 * r) / 360.0,
            (296.0 - 169.0 * r) / 1800.0,
            (-2.0 + 3.0 * r) / 225.0,
            (296.0 + 169.0 * r) / 1800.0,
            (88.0 + 7.0 * r) / 360.0,
            (-2.0 - 3.0 * r) / 225.0,
            (16.0 - r) / 36.0,
            (16.0 + r) / 36.0,
            1.0 / 9.0,
        ];
        for i in 0..3 {
            assert_small("c", 3, tableau.c[i] - c[i]);
        }
        assert_small("A", 3, (a - matrix(3, &published)).amax());
        // HW2 §IV.8: γ₀⁻¹ of the error estimate, and its coefficients e with (8.19).
        let gamma = 30.0 / (6.0 + 81f64.cbrt() - 9f64.cbrt());
        assert_small("gamma", 3, tableau.gamma - gamma);
        let e = [-13.0 - 7.0 * r, -13.0 + 7.0 * r, -1.0].map(|x| x / (3.0 * gamma));
        for i in 0..3 {
            assert_small("e", 3, tableau.e[i] - e[i]);
        }
    }

    #[test]
    fn order_conditions_b_c_and_d_hold() {
        for stages in ALL {
            let tableau = Tableau::new(stages);
            let (s, c) = (tableau.s, &tableau.c);
            let (a, b) = coefficients(&tableau);
            let power = |x: f64, k: usize| x.powi(i32::try_from(k).expect("small"));
            // B(2s − 1): Σ b_i c_i^{k−1} = 1/k.
            for k in 1..2 * s {
                let sum: f64 = (0..s).map(|i| b[i] * power(c[i], k - 1)).sum();
                assert_small("B", s, sum - 1.0 / k as f64);
            }
            // C(s): Σ_j a_ij c_j^{k−1} = c_i^k / k.
            for (k, i) in (1..=s).flat_map(|k| (0..s).map(move |i| (k, i))) {
                let sum: f64 = (0..s).map(|j| a[(i, j)] * power(c[j], k - 1)).sum();
                assert_small("C", s, sum - power(c[i], k) / k as f64);
            }
            // D(s − 1): Σ_i b_i c_i^{k−1} a_ij = b_j (1 − c_j^k) / k.
            for (k, j) in (1..s).flat_map(|k| (0..s).map(move |j| (k, j))) {
                let sum: f64 = (0..s).map(|i| b[i] * power(c[i], k - 1) * a[(i, j)]).sum();
                assert_small("D", s, sum - b[j] * (1.0 - power(c[j], k)) / k as f64);
            }
        }
    }

    #[test]
    fn the_tail_finds_the_legendre_coefficients_of_the_derivative() {
        for stages in [Stages::Three, Stages::Five, Stages::Seven] {
            let tableau = Tableau::new(stages);
            let s = tableau.s;
            // h u′ = 0.3 P_{s−2} − 0.7 P_{s−1}, integrated to the stages.
            let z = |tau: f64| {
                let integrals = legendre_integrals(tau);
                0.3 * integrals[s - 2] - 0.7 * integrals[s - 1]
            };
            for (row, exact) in tableau.tail.iter().zip([0.3, -0.7]) {
                let found: f64 = row.iter().zip(&tableau.c).map(|(a, &c)| a * z(c)).sum();
                assert_small("tail", s, found - exact);
            }
        }
    }

    #[test]
    fn the_error_estimate_sees_the_next_legendre_coefficient_times_two_over_gamma() {
        for stages in [Stages::Three, Stages::Five, Stages::Seven] {
            let tableau = Tableau::new(stages);
            let s = tableau.s;
            // h u′ = P_s: the quadrature error of the embedded formula.
            let integral = |tau: f64| legendre_integrals(tau)[s];
            let start = legendre(0.0)[s] / tableau.gamma;
            // Stages of the collocation polynomial, which takes u′ at the nodes only.
            let (a, _) = coefficients(&tableau);
            let slopes: Vec<f64> = tableau.c.iter().map(|&c| legendre(c)[s]).collect();
            let z = (0..s).map(|i| (0..s).map(|j| a[(i, j)] * slopes[j]).sum::<f64>());
            let seen: f64 = start + tableau.e.iter().zip(z).map(|(e, z)| e * z).sum::<f64>();
            assert_small("estimate", s, seen.abs() - 2.0 / tableau.gamma);
            assert!(integral(1.0).abs() < 1e-14, "P_s integrates to zero");
        }
    }

    #[test]
    fn order_condition_b_fails_one_order_higher() {
        for stages in ALL {
            let tableau = Tableau::new(stages);
            let (s, (_, b)) = (tableau.s, coefficients(&tableau));
            let exponent = i32::try_from(2 * s - 1).expect("small");
            let sum: f64 = (0..s).map(|i| b[i] * tableau.c[i].powi(exponent)).sum();
            assert!((sum - 1.0 / (2 * s) as f64).abs() > 1e-9, "{s} stages have order 2s − 1");
        }
    }

    #[test]
    fn t_diagonalises_the_inverse_of_a() {
        for stages in ALL {
            let tableau = Tableau::new(stages);
            let s = tableau.s;
            let mut lambda = DMatrix::zeros(s, s);
            lambda[(0, 0)] = tableau.gamma;
            for (k, pair) in tableau.lambda.iter().enumerate() {
                // Multiplication of (re, im) by α − iβ.
                let at = 2 * k + 1;
                lambda[(at, at)] = pair.re;
                lambda[(at, at + 1)] = -pair.im;
                lambda[(at + 1, at)] = pair.im;
                lambda[(at + 1, at + 1)] = pair.re;
            }
            let (t, t_inv) = (matrix(s, &tableau.t), matrix(s, &tableau.t_inv));
            let a_inv = matrix(s, &tableau.a_inv);
            // The eigenvectors are nearly parallel for seven stages; rounding grows with that.
            let scale = a_inv.amax() * t.amax() * t_inv.amax();
            assert_small("T Λ T⁻¹", s, (&t * lambda * &t_inv - a_inv).amax() / scale);
            assert_small("T T⁻¹", s, (&t * &t_inv - DMatrix::identity(s, s)).amax());
        }
    }
}
