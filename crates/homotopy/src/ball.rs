//! [`Quadratic`]: sparse quadratic equations, and balls around their solutions.
//!
//! ```text
//! Y ≈ F′(x)⁻¹,  ‖1 − Y F′(x)‖ ≤ δ,  ‖Y F(x)‖ ≤ η,  ‖Y F″‖ ≤ K        norms of largest components
//! K η / (1 − δ)² ≤ 1/2:  one solution within 2η/(1 − δ), and no other within (1 − δ)/K
//! ```
//!
//! F″ is constant, so K holds everywhere. η has the rounding of F and of its coefficients in it.
//!
//! Source: L. V. Kantorovich's theorem, e.g. J. M. Ortega and W. C. Rheinboldt, *Iterative Solution of Nonlinear
//! Equations in Several Variables* (1970), 12.6.2.

use nalgebra::{DMatrix, DVector};

use crate::C;

/// Equations Σ c xᵢ xⱼ = 0 with x₀ = 1.
#[derive(Clone, Debug)]
pub struct Quadratic {
    rows: Vec<Vec<(C, usize, usize)>>,
}

/// A ball that holds one solution.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Ball {
    /// The solution is not farther away.
    pub radius: f64,
    /// Up to there it is the only one.
    pub alone: f64,
}

impl Quadratic {
    /// One equation for each row of terms (c, i, j): c xᵢ xⱼ, where x₀ is 1 and unknowns count from one.
    pub fn new(rows: Vec<Vec<(C, usize, usize)>>) -> Self {
        Self { rows }
    }

    /// Number of equations.
    pub fn n(&self) -> usize {
        self.rows.len()
    }

    /// Values with the sums of their terms' sizes, and slopes.
    fn at(&self, x: &DVector<C>) -> (DVector<C>, Vec<f64>, DMatrix<C>) {
        let n = self.n();
        let of = |i: usize| if i == 0 { C::from(1.0) } else { x[i - 1] };
        let mut value = DVector::from_element(n, C::default());
        let mut size = vec![0.0; n];
        let mut slopes = DMatrix::from_element(n, n, C::default());
        for (k, row) in self.rows.iter().enumerate() {
            for &(c, i, j) in row {
                let term = c * of(i) * of(j);
                value[k] += term;
                size[k] += term.norm();
                if i > 0 {
                    slopes[(k, i - 1)] += c * of(j);
                }
                if j > 0 {
                    slopes[(k, j - 1)] += c * of(i);
                }
            }
        }
        (value, size, slopes)
    }

    /// Takes a few steps of Newton's iteration.
    pub fn improve(&self, x: &mut DVector<C>) {
        const STEPS: usize = 3;
        for _ in 0..STEPS {
            let (value, _, slopes) = self.at(x);
            match slopes.lu().solve(&value) {
                Some(step) if step.iter().all(|s| s.re.is_finite() && s.im.is_finite()) => {
                    *x -= step;
                }
                _ => return,
            }
        }
    }

    /// The ball around a solution near `x`, in which there is one and no other; none where that cannot be shown.
    pub fn ball(&self, x: &DVector<C>) -> Option<Ball> {
        /// Roundings in a value, coefficients included.
        const ROUNDINGS: f64 = 64.0;
        let n = self.n();
        let (value, size, slopes) = self.at(x);
        let y = slopes.clone().try_inverse()?;
        let rest = DMatrix::identity(n, n) - &y * &slopes;
        let rounding = ROUNDINGS * f64::EPSILON;
        let (mut delta, mut eta, mut k) = (0.0_f64, 0.0_f64, 0.0_f64);
        let step = &y * &value;
        for i in 0..n {
            let mut from_rounding = 0.0;
            let (mut of_second, mut of_rest, mut of_product) = (0.0, 0.0, 0.0);
            for j in 0..n {
                let weight = y[(i, j)].norm();
                from_rounding += weight * size[j];
                of_second += weight * self.second(j);
                of_rest += rest[(i, j)].norm();
                of_product += weight * slopes.row(j).iter().map(|c| c.norm()).sum::<f64>();
            }
            delta = delta.max(of_rest + rounding * of_product);
            eta = eta.max(step[i].norm() + rounding * from_rounding);
            k = k.max(of_second);
        }
        let left = 1.0 - delta;
        let is_near = left > 0.5 && k * eta <= 0.45 * left * left;
        is_near.then(|| Ball { radius: 2.0 * eta / left, alone: left / k })
    }

    /// Bound of a row of F″ on vectors with components up to one.
    fn second(&self, row: usize) -> f64 {
        let terms = self.rows[row].iter().filter(|(_, i, j)| *i > 0 && *j > 0);
        terms.map(|(c, ..)| 2.0 * c.norm()).sum()
    }
}
