//! Bodies that bend: a straight beam of one cross-section, in a frame that is fixed at its root.
//!
//! ```text
//! S_k = ∫ P_k−1,   W_k = ∫ S_k        over ξ = x/L from the root, P_k the Legendre polynomials of 0 … 1
//! ```
//!
//! S_k are slopes of the shapes and L W_k deflections. As the P_k are orthogonal, every shape has a stiffness of its own,
//! EI/L/(2 k − 1), and shapes of a free end together are all polynomials with a fixed root.

use bksim_expr::Expr;

use crate::ids::{BodyId, JointId};

/// A beam along x of its body's frame.
#[derive(Clone, Debug)]
pub struct Flexible {
    /// Length L, m.
    pub length: Expr,
    /// Joints whose angles are the parts of the shapes in the plane of x and y.
    pub bending: Vec<JointId>,
    /// Joints of the shapes in the plane of x and z.
    pub across: Vec<JointId>,
    /// Joints whose positions are the parts of the stretch along x, m.
    pub axial: Vec<JointId>,
    /// Whether bending draws the far end nearer, so that forces along the beam stiffen it or make it buckle.
    pub is_stiffened: bool,
    /// Points of the body that the author wrote; those after them are places of its mass, then its far end.
    pub n_points: usize,
    /// Places of all points along it, from 0 at the root to 1.
    pub places: Vec<f64>,
    /// Bodies of its mass, from the root on.
    pub masses: Vec<BodyId>,
    /// A body without mass at its far end, in the frame of the cross-section.
    pub end: BodyId,
    /// Bodies without mass in the frames of the author's points: what acts there turns with the cross-section.
    pub sections: Vec<BodyId>,
}

impl Flexible {
    /// The joints that stand for shapes.
    pub fn shapes(&self) -> impl Iterator<Item = JointId> {
        [&self.bending, &self.across, &self.axial].into_iter().flatten().copied()
    }

    /// True of a body that stands for mass, a cross-section or the end of the beam.
    pub fn has_part(&self, body: BodyId) -> bool {
        self.end == body || self.masses.contains(&body) || self.sections.contains(&body)
    }
}

/// A number as a short fraction, if it is one up to rounding: integrals over a whole beam then stay exact.
pub fn short_fraction(value: f64) -> Option<(i64, i64)> {
    const LARGEST: i32 = 1000;
    if value.abs() < 1e-15 {
        return Some((0, 1));
    }
    (1..=LARGEST).find_map(|denominator| {
        let numerator = value * f64::from(denominator);
        let whole = numerator.round();
        let rounding = 1e-13 * f64::from(denominator) * value.abs().max(1e-3);
        if (numerator - whole).abs() >= rounding || whole == 0.0 || whole.abs() >= 1e6 {
            return None;
        }
        #[expect(clippy::cast_possible_truncation, reason = "a whole number below 10⁶")]
        Some((whole as i64, denominator.into()))
    })
}

/// Values of P_0 … P_n of 0 … 1 at ξ.
pub fn legendre(n: usize, xi: f64) -> Vec<f64> {
    let x = 2.0 * xi - 1.0;
    let mut values = vec![1.0, x];
    let mut order = 1.0;
    while values.len() <= n {
        let [.., before, last] = values[..] else { unreachable!("two to begin with") };
        values.push(((2.0 * order + 1.0) * x * last - order * before) / (order + 1.0));
        order += 1.0;
    }
    values
}

/// Integrals of functions f_0 … f_n that fulfil the recursion of Legendre polynomials, from 0, with that of f_0 first.
fn integrals(first: f64, values: &[f64]) -> Vec<f64> {
    let mut integrals = vec![first];
    let mut order = 1.0;
    for pair in values.windows(3) {
        integrals.push((pair[2] - pair[0]) / (2.0 * (2.0 * order + 1.0)));
        order += 1.0;
    }
    integrals
}

/// S_1 … S_n at ξ: slopes of the shapes of bending, and the shapes of stretching over L.
pub fn slopes(n: usize, xi: f64) -> Vec<f64> {
    let mut slopes = integrals(xi, &legendre(n + 1, xi));
    slopes.truncate(n);
    slopes
}

/// W_1 … W_n at ξ: shapes of bending over L.
pub fn deflections(n: usize, xi: f64) -> Vec<f64> {
    let mut deflections = integrals(0.5 * xi * xi, &slopes(n + 2, xi));
    deflections.truncate(n);
    deflections
}

/// ∫ S_k S_l from 0 to ξ.
pub fn shortenings(n: usize, xi: f64) -> Vec<Vec<f64>> {
    let mut sums = vec![vec![0.0; n]; n];
    for (at, weight) in gauss(n + 1) {
        let slopes = slopes(n, xi * at);
        for (row, s_k) in sums.iter_mut().zip(&slopes) {
            for (sum, s_l) in row.iter_mut().zip(&slopes) {
                *sum += xi * weight * s_k * s_l;
            }
        }
    }
    sums
}

/// Places and weights of Gauss's quadrature over 0 … 1, exact up to degree 2 n − 1.
pub fn gauss(n: usize) -> Vec<(f64, f64)> {
    #[expect(clippy::cast_precision_loss, reason = "few places")]
    let place = |k: usize| {
        let guess = (std::f64::consts::PI * (k as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut xi = 0.5 * (1.0 - guess);
        // P′ by P_n and P_n−1; Newton's method doubles the digits of the guess each time.
        let slope = |xi: f64, values: &[f64]| {
            let x = 2.0 * xi - 1.0;
            2.0 * n as f64 * (x * values[n] - values[n - 1]) / (x * x - 1.0)
        };
        for _ in 0..6 {
            let values = legendre(n, xi);
            xi -= values[n] / slope(xi, &values);
        }
        let slope = slope(xi, &legendre(n, xi));
        (xi, 1.0 / (xi * (1.0 - xi) * slope * slope))
    };
    (0..n).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadrature_is_exact_up_to_its_degree() {
        for n in 1..12_i32 {
            let places = gauss(usize::try_from(n).expect("small"));
            for degree in 0..2 * n {
                let sum: f64 = places.iter().map(|(at, weight)| weight * at.powi(degree)).sum();
                let exact = 1.0 / f64::from(degree + 1);
                assert!((sum - exact).abs() < 1e-14, "{n} {degree}: {sum} for {exact}");
            }
        }
    }

    #[test]
    fn shapes_are_integrals_of_each_other() {
        let n = 7;
        for xi in [0.2, 0.55, 1.0] {
            let sum = |of: fn(usize, f64) -> Vec<f64>, k: usize| -> f64 {
                gauss(12).iter().map(|(at, weight)| xi * weight * of(n, xi * at)[k]).sum()
            };
            for k in 0..n {
                let (s, w) = (slopes(n, xi)[k], deflections(n, xi)[k]);
                assert!((s - sum(legendre, k)).abs() < 1e-14, "S_{k} at {xi}");
                assert!((w - sum(slopes, k)).abs() < 1e-14, "W_{k} at {xi}");
            }
        }
    }
}
