//! Roots of polynomials, and polynomials through values.

use nalgebra::{Complex, DMatrix, DVector};

/// All roots of Σ cₖ xᵏ, each improved by Newton's iteration; leading coefficients that are rounding are left out.
pub(super) fn roots(coefficients: &[f64]) -> Vec<Complex<f64>> {
    let size = coefficients.iter().fold(0.0, |a: f64, c| a.max(c.abs()));
    let Some(degree) = coefficients.iter().rposition(|c| c.abs() > 1e-13 * size) else {
        return Vec::new();
    };
    if degree == 0 {
        return Vec::new();
    }
    let leading = coefficients[degree];
    let companion = DMatrix::from_fn(degree, degree, |i, j| {
        if j + 1 == degree { -coefficients[i] / leading } else { f64::from(u8::from(i == j + 1)) }
    });
    let value = |x: Complex<f64>| {
        let first = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
        coefficients[..=degree]
            .iter()
            .rev()
            .fold(first, |(p, slope), &c| (p * x + c, slope * x + p))
    };
    let improved = |root: Complex<f64>| {
        (0..4).fold(root, |x, _| {
            let (p, slope) = value(x);
            let next = x - p / slope;
            if next.is_finite() && value(next).0.norm() <= p.norm() { next } else { x }
        })
    };
    companion.complex_eigenvalues().iter().map(|&root| improved(root)).collect()
}

/// Real ones of all roots; those off the axis by rounding are on it.
pub(super) fn real_roots(coefficients: &[f64]) -> Vec<f64> {
    let is_real = |root: &Complex<f64>| root.im.abs() < 1e-7 * (1.0 + root.re.abs());
    let mut real: Vec<f64> =
        roots(coefficients).into_iter().filter(is_real).map(|root| root.re).collect();
    real.sort_by(f64::total_cmp);
    real
}

/// Coefficients of the polynomial of this degree in one variable with the values of `f`.
pub(super) fn through(degree: usize, f: impl Fn(f64) -> f64) -> Vec<f64> {
    let at = |k: usize| ((k as f64 + 0.5) * std::f64::consts::PI / (degree + 1) as f64).cos();
    let matrix =
        DMatrix::from_fn(degree + 1, degree + 1, |i, j| at(i).powi(i32::try_from(j).unwrap_or(0)));
    let values = DVector::from_fn(degree + 1, |i, _| f(at(i)));
    matrix.lu().solve(&values).map_or_else(Vec::new, |c| c.iter().copied().collect())
}
