//! [`Quadratic`]: sparse quadratic equations, and balls around their solutions.
//!
//! ```text
//! ‖d‖ = max |dᵢ|/wᵢ,  wᵢ = max(1, |xᵢ|)
//! Y ≈ F′(x)⁻¹,  ‖1 − Y F′(x)‖ ≤ δ,  ‖Y F(x)‖ ≤ η,  ‖Y F″‖ ≤ K
//! K η / (1 − δ)² ≤ 1/2:  one solution within 2η/(1 − δ), and no other within (1 − δ)/K
//! ```
//!
//! F″ is constant, so K holds everywhere. F is evaluated in twice the digits; η has the error of its coefficients in it.
//!
//! Source: L. V. Kantorovich's theorem, e.g. J. M. Ortega and W. C. Rheinboldt, *Iterative Solution of Nonlinear
//! Equations in Several Variables* (1970), 12.6.2.

use nalgebra::{DMatrix, DVector};

use crate::C;
use crate::double::Double;

/// Equations Σ c xᵢ xⱼ = 0 with x₀ = 1.
#[derive(Clone, Debug)]
pub struct Quadratic {
    rows: Vec<Vec<(C, usize, usize)>>,
}

/// A ball that holds one solution, in the norm max |dᵢ|/max(1, |xᵢ|) around its centre x.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Ball {
    /// The solution is not farther away.
    pub radius: f64,
    /// Up to there it is the only one.
    pub alone: f64,
}

/// A solution in a ball, improved to twice the digits.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Enclosed {
    /// Around the nearest numbers.
    pub ball: Ball,
    /// Largest share of its terms that an equation misses, before the solution is rounded.
    pub left: f64,
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

    /// Values in twice the digits, and the sums of their terms' sizes.
    fn values(&self, x: &[Double]) -> (DVector<C>, Vec<f64>) {
        let of = |i: usize| if i == 0 { Double::from(C::from(1.0)) } else { x[i - 1] };
        let value = |row: &Vec<(C, usize, usize)>| {
            row.iter().fold((Double::default(), 0.0), |(sum, size), &(c, i, j)| {
                let term = Double::from(c) * of(i) * of(j);
                (sum + term, size + term.rounded().norm())
            })
        };
        let all: Vec<(Double, f64)> = self.rows.iter().map(value).collect();
        let values = all.iter().map(|(value, _)| value.rounded());
        (DVector::from_iterator(self.n(), values), all.iter().map(|(_, size)| *size).collect())
    }

    fn slopes(&self, x: &DVector<C>) -> DMatrix<C> {
        let n = self.n();
        let of = |i: usize| if i == 0 { C::from(1.0) } else { x[i - 1] };
        let mut slopes = DMatrix::from_element(n, n, C::default());
        for (k, row) in self.rows.iter().enumerate() {
            for &(c, i, j) in row {
                if i > 0 {
                    slopes[(k, i - 1)] += c * of(j);
                }
                if j > 0 {
                    slopes[(k, j - 1)] += c * of(i);
                }
            }
        }
        slopes
    }

    /// Takes steps of Newton's iteration in twice the digits; the nearest numbers are written to `x`. None where it does not
    /// converge.
    fn improved(&self, x: &mut DVector<C>) -> Option<Vec<Double>> {
        const STEPS: usize = 8;
        const NEAR: f64 = 1e-25;
        let mut at: Vec<Double> = x.iter().copied().map(Double::from).collect();
        let size = 1.0 + x.camax();
        let mut last = f64::INFINITY;
        for _ in 0..STEPS {
            let step = self.slopes(x).lu().solve(&self.values(&at).0)?;
            let length = step.camax() / size;
            if length.is_nan() || length > 0.1 {
                return None;
            }
            if length >= 0.5 * last {
                break;
            }
            at.iter_mut().zip(step.iter()).for_each(|(x, s)| *x = *x + Double::from(-s));
            x.iter_mut().zip(&at).for_each(|(x, at)| *x = at.rounded());
            last = length;
            if length < NEAR {
                break;
            }
        }
        Some(at)
    }

    /// Improves a solution to the nearest numbers, and gives the ball around it in which there is one and no other; none where
    /// that cannot be shown. `uncertain` is the relative error of the coefficients.
    pub fn enclose(&self, x: &mut DVector<C>, uncertain: f64) -> Option<Enclosed> {
        /// Roundings in products of slopes.
        const ROUNDINGS: f64 = 64.0;
        /// Relative error of values in twice the digits.
        const OF_DOUBLE: f64 = 1e-29;
        let n = self.n();
        let centre = self.improved(x)?;
        let (value, size) = self.values(&centre);
        let shares = value.iter().zip(&size).map(|(v, size)| v.norm() / size.max(1e-300));
        let left = shares.fold(0.0, f64::max);
        let slopes = self.slopes(x);
        let y = slopes.clone().try_inverse()?;
        let rest = DMatrix::identity(n, n) - &y * &slopes;
        let (rounding, of_values) = (ROUNDINGS * f64::EPSILON, uncertain + OF_DOUBLE);
        let (mut delta, mut eta, mut k) = (0.0_f64, 0.0_f64, 0.0_f64);
        let step = &y * &value;
        let w: Vec<f64> = x.iter().map(|c| weight(*c)).collect();
        for i in 0..n {
            let mut from_rounding = 0.0;
            let (mut of_second, mut of_rest, mut of_product) = (0.0, 0.0, 0.0);
            for j in 0..n {
                let by = y[(i, j)].norm() / w[i];
                from_rounding += by * size[j];
                of_second += by * self.second(j, &w);
                of_rest += rest[(i, j)].norm() * w[j] / w[i];
                of_product += by * (0..n).map(|l| slopes[(j, l)].norm() * w[l]).sum::<f64>();
            }
            delta = delta.max(of_rest + rounding * of_product);
            eta = eta.max(step[i].norm() / w[i] * (1.0 + 1e-9) + of_values * from_rounding);
            k = k.max(of_second);
        }
        // Slopes are those at the nearest numbers.
        let off = f64::EPSILON;
        let left_over = 1.0 - delta - k * off;
        let is_near = left_over > 0.5 && k * eta <= 0.45 * left_over * left_over;
        let ball = Ball { radius: 2.0 * eta / left_over + off, alone: left_over / k - off };
        is_near.then_some(Enclosed { ball, left })
    }

    /// Bound of a row of F″ on vectors with components up to these.
    fn second(&self, row: usize, w: &[f64]) -> f64 {
        let terms = self.rows[row].iter().filter(|(_, i, j)| *i > 0 && *j > 0);
        terms.map(|(c, i, j)| 2.0 * c.norm() * w[i - 1] * w[j - 1]).sum()
    }
}

fn weight(c: C) -> f64 {
    c.norm().max(1.0)
}

impl Ball {
    /// True if balls around two centres have nothing in common.
    pub fn is_apart(&self, x: &DVector<C>, other: &Self, y: &DVector<C>) -> bool {
        let reach = |x: C, y: C| self.radius * weight(x) + other.radius * weight(y);
        x.iter().zip(y.iter()).any(|(x, y)| (x - y).norm() > reach(*x, *y))
    }

    /// Whether the solution in the ball around `x` is also the one near `y`, its image under a symmetry of the equations; none
    /// where that is not certain.
    pub fn is_own(&self, x: &DVector<C>, y: &DVector<C>) -> Option<bool> {
        let off = x.iter().zip(y.iter()).map(|(x, y)| (x - y).norm() / weight(*x));
        if off.fold(0.0, f64::max) + 2.0 * self.radius < self.alone {
            return Some(true);
        }
        self.is_apart(x, self, y).then_some(false)
    }
}
