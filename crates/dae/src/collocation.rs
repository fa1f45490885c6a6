//! Linear equations of second order along a motion that is known, by collocation.
//!
//! ```text
//! u″ = K u + C u′ + B, functions of t        n unknowns, m right sides at once
//! w_i = u″(t₀ + c_i h)                     i = 1 … s, the nodes of Radau IIA
//! u_i = u₀ + c_i h u₀′ + h² Σ (A²)_ij w_j,   u_i′ = u₀′ + h Σ A_ij w_j
//! ```
//!
//! Their coefficients do not depend on the solution, so that a step is one linear system of s n unknowns: no
//! iteration, and no limit of stability. The solution at the end has order 2s − 1; between, u′ is the integral of the
//! polynomial through the w_i, and u that of u′ (HW2 §II.7 and §IV.5; for equations of second order E. Hairer,
//! S. P. Nørsett and G. Wanner, *Solving Ordinary Differential Equations I*, §II.14).

#![expect(clippy::inline_always, reason = "kernels are compiled with the registers of `run`")]

mod adjoint;

use nalgebra::DMatrix;
use pulp::{Simd, WithSimd};

pub use adjoint::{AdjointCollocation, AdjointStep, Costates};

use crate::lanes::run;
use crate::settings::Stages;
use crate::tableau::{collocation_matrices, legendre, legendre_integrals, nodes};

/// The method with its buffers, for n unknowns and m right sides.
#[derive(Clone, Debug)]
pub struct LinearCollocation {
    n: usize,
    m: usize,
    c: Vec<f64>,
    /// A and A², by rows.
    a: Vec<f64>,
    a_squared: Vec<f64>,
    /// Legendre coefficients of the polynomial through the values at the nodes, by rows.
    to_legendre: Vec<f64>,
    /// The system with its right sides, by rows.
    system: Vec<f64>,
}

/// The coefficients at one node: K and C, n × n by rows, and B, n × m by rows.
#[derive(Clone, PartialEq, Debug)]
pub struct LinearCoefficients {
    /// K.
    pub by_position: Vec<f64>,
    /// C.
    pub by_velocity: Vec<f64>,
    /// B.
    pub forcing: Vec<f64>,
}

/// The solution over one step: u and u′ at every instant of it.
#[derive(Clone, PartialEq, Debug)]
pub struct LinearStep {
    t0: f64,
    h: f64,
    /// u and u′ at the beginning, n × m by rows.
    u: Vec<f64>,
    rate: Vec<f64>,
    /// Legendre coefficients of u″, by degree.
    w: Vec<f64>,
}

impl LinearCoefficients {
    /// Room for n unknowns and m right sides.
    pub fn zeros(n: usize, m: usize) -> Self {
        let square = || vec![0.0; n * n];
        Self { by_position: square(), by_velocity: square(), forcing: vec![0.0; n * m] }
    }

    /// Writes u″ = K u + C u′ + B, n × m by rows.
    pub fn apply(&self, (u, rate): (&[f64], &[f64]), out: &mut [f64]) {
        let Self { by_position, by_velocity, forcing } = self;
        out.copy_from_slice(forcing);
        let n = by_position.len().isqrt();
        let m = forcing.len() / n.max(1);
        for (i, out) in out.chunks_exact_mut(m.max(1)).enumerate() {
            let row = by_position[i * n..][..n].iter().zip(&by_velocity[i * n..][..n]);
            for (j, (k, c)) in row.enumerate() {
                let changes = u[j * m..][..m].iter().zip(&rate[j * m..][..m]);
                out.iter_mut().zip(changes).for_each(|(sum, (u, rate))| *sum += k * u + c * rate);
            }
        }
    }
}

/// See [`LinearCollocation::solve_into`].
struct Solve<'a> {
    collocation: &'a mut LinearCollocation,
    h: f64,
    start: (&'a [f64], &'a [f64]),
    all: &'a [LinearCoefficients],
    w: &'a mut [f64],
}

impl WithSimd for Solve<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let Self { collocation, h, start, all, w } = self;
        collocation.solve_into(h, start, all, w)
    }
}

impl LinearCollocation {
    /// The method with this number of stages.
    #[expect(clippy::missing_panics_doc, reason = "the nodes are distinct")]
    pub fn new(stages: Stages, n: usize, m: usize) -> Self {
        let s = stages.count();
        let c = nodes(s);
        let (a, _) = collocation_matrices(&c);
        let values = DMatrix::from_fn(s, s, |i, k| legendre(c[i])[k]);
        let to_legendre = values.try_inverse().expect("the nodes are distinct");
        let rows = |matrix: &DMatrix<f64>| matrix.transpose().as_slice().to_vec();
        Self {
            n,
            m,
            a_squared: rows(&(&a * &a)),
            a: rows(&a),
            to_legendre: rows(&to_legendre),
            system: vec![0.0; s * n * (s * n + m)],
            c,
        }
    }

    /// The nodes in (0, 1], ascending.
    pub fn nodes(&self) -> &[f64] {
        &self.c
    }

    /// The size of a step whose largest error is that of another one of size `h` over `error`: within it, errors are
    /// of order s + 1. A step that was too long becomes shorter.
    pub fn longest_step(&self, h: f64, error: f64) -> f64 {
        const SAFETY: f64 = 0.9;
        const CHANGE: [f64; 2] = [0.2, 5.0];
        let order = (self.c.len() + 1) as f64;
        let factor = SAFETY * error.powf(-1.0 / order);
        h * if error.is_nan() { CHANGE[0] } else { factor.clamp(CHANGE[0], CHANGE[1]) }
    }

    /// The step from `t0` over `h`, from u and u′ there, with the coefficients at the nodes; `None` where the system is
    /// singular or a number is not finite.
    pub fn step(
        &mut self,
        (t0, h): (f64, f64),
        (u, rate): (&[f64], &[f64]),
        coefficients: &[LinearCoefficients],
    ) -> Option<LinearStep> {
        let mut w = vec![0.0; self.c.len() * self.n * self.m];
        if !run(Solve { collocation: self, h, start: (u, rate), all: coefficients, w: &mut w }) {
            return None;
        }
        let is_finite = w.iter().all(|value| value.is_finite());
        is_finite.then(|| LinearStep { t0, h, u: u.to_vec(), rate: rate.to_vec(), w })
    }

    /// The step from u and u′ at `t0` with these u″ at the nodes, one node after the other, n × m by rows.
    pub fn through(
        &self,
        (t0, h): (f64, f64),
        (u, rate): (&[f64], &[f64]),
        at_nodes: &[f64],
    ) -> LinearStep {
        let (s, width) = (self.c.len(), self.n * self.m);
        let mut w = vec![0.0; s * width];
        for (k, of_degree) in w.chunks_exact_mut(width.max(1)).enumerate() {
            let of_nodes = at_nodes.chunks_exact(width.max(1));
            for (weight, of_node) in self.to_legendre[k * s..][..s].iter().zip(of_nodes) {
                of_degree.iter_mut().zip(of_node).for_each(|(sum, w)| *sum += weight * w);
            }
        }
        LinearStep { t0, h, u: u.to_vec(), rate: rate.to_vec(), w }
    }

    /// Writes the Legendre coefficients of u″; false where the system is singular.
    #[inline(always)]
    fn solve_into(
        &mut self,
        h: f64,
        start: (&[f64], &[f64]),
        all: &[LinearCoefficients],
        w: &mut [f64],
    ) -> bool {
        self.assemble(h, start, all);
        let Self { n, m, c, to_legendre, system, .. } = self;
        let (n, m, s) = (*n, *m, c.len());
        let width = s * n + m;
        if !eliminate_rows(system, s * n, width) {
            return false;
        }
        for (k, of_degree) in w.chunks_exact_mut((n * m).max(1)).enumerate() {
            for (j, weight) in to_legendre[k * s..][..s].iter().enumerate() {
                for (i, row) in of_degree.chunks_exact_mut(m).enumerate() {
                    let at = &system[(j + i * s) * width + s * n..][..m];
                    row.iter_mut().zip(at).for_each(|(sum, w)| *sum += weight * w);
                }
            }
        }
        true
    }

    /// w_i − Σ_j (h² (A²)_ij K_i + h A_ij C_i) w_j = K_i (u₀ + c_i h u₀′) + C_i u₀′ + B_i, unknown by unknown at all
    /// nodes.
    #[inline(always)]
    fn assemble(&mut self, h: f64, (u, rate): (&[f64], &[f64]), all: &[LinearCoefficients]) {
        let Self { n, m, c, a, a_squared, system, .. } = self;
        let (n, m, s) = (*n, *m, c.len());
        let width = s * n + m;
        for (i, of_node) in all.iter().enumerate().take(s) {
            let LinearCoefficients { by_position, by_velocity, forcing } = of_node;
            let (twice, once) = (&a_squared[i * s..][..s], &a[i * s..][..s]);
            for alpha in 0..n {
                let row = &mut system[(i + alpha * s) * width..][..width];
                let (matrix, right) = row.split_at_mut(s * n);
                let (k, d) = (&by_position[alpha * n..][..n], &by_velocity[alpha * n..][..n]);
                for (block, (k, d)) in matrix.chunks_exact_mut(s).zip(k.iter().zip(d)) {
                    let (k, d) = (h * h * k, h * d);
                    let factors = twice.iter().zip(once);
                    let block = block.iter_mut().zip(factors);
                    block.for_each(|(x, (twice, once))| *x = -k * twice - d * once);
                }
                matrix[i + alpha * s] += 1.0;
                right.copy_from_slice(&forcing[alpha * m..][..m]);
                for beta in 0..n {
                    let (u, rate) = (&u[beta * m..][..m], &rate[beta * m..][..m]);
                    let of_rate = k[beta] * c[i] * h + d[beta];
                    let columns = right.iter_mut().zip(u.iter().zip(rate));
                    columns.for_each(|(x, (u, rate))| *x += k[beta] * u + of_rate * rate);
                }
            }
        }
    }
}

impl LinearStep {
    /// Where it begins.
    pub fn t0(&self) -> f64 {
        self.t0
    }

    /// Where it ends.
    pub fn t1(&self) -> f64 {
        self.t0 + self.h
    }

    /// Writes u and u′ at `t`, n × m by rows.
    pub fn at(&self, t: f64, u: &mut [f64], rate: &mut [f64]) {
        let Self { t0, h, u: u0, rate: rate0, w } = self;
        let tau = (t - t0) / h;
        let once = legendre_integrals(tau);
        u.copy_from_slice(u0);
        rate.copy_from_slice(rate0);
        u.iter_mut().zip(rate0).for_each(|(u, rate)| *u += tau * h * rate);
        for (k, of_degree) in w.chunks_exact(u.len().max(1)).enumerate() {
            // ∫ I_k by the same recurrence as I_k = ∫ P_k.
            let twice = match k {
                0 => 0.5 * tau * tau,
                _ => (once[k + 1] - once[k - 1]) / (2.0 * (2.0 * k as f64 + 1.0)),
            };
            for ((u, rate), w) in u.iter_mut().zip(rate.iter_mut()).zip(of_degree) {
                *u += h * h * twice * w;
                *rate += h * once[k] * w;
            }
        }
    }

    /// Estimates of the error of u′ within the step, n × m by rows: the part that one degree more would have, by how
    /// the coefficients fall.
    pub fn errors(&self) -> impl Iterator<Item = f64> {
        let width = self.u.len();
        let s = self.w.len() / width.max(1);
        let of_degree = move |k: usize| &self.w[k * width..(k + 1) * width];
        let [before, last] = [of_degree(s - 2), of_degree(s - 1)];
        before.iter().zip(last).map(move |(before, last)| (self.h * falling(*before, *last)).abs())
    }
}

/// The size of a coefficient that falls to the last one as that falls to the next.
fn falling(before: f64, last: f64) -> f64 {
    let falling = (last / before).abs().min(1.0);
    if last.abs() > 0.0 { last.abs() * falling } else { 0.0 }
}

/// Solves the n equations in the first n columns of `rows`, whose length is `width`, for the right sides in the others,
/// in place, by elimination with row pivots; false where a pivot vanishes or is not finite.
pub fn eliminate(rows: &mut [f64], n: usize, width: usize) -> bool {
    run(Eliminate { rows, n, width })
}

struct Eliminate<'a> {
    rows: &'a mut [f64],
    n: usize,
    width: usize,
}

impl WithSimd for Eliminate<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        eliminate_rows(self.rows, self.n, self.width)
    }
}

#[inline(always)]
fn eliminate_rows(rows: &mut [f64], n: usize, width: usize) -> bool {
    for k in 0..n {
        // The largest pivot.
        let size = |i: usize| rows[i * width + k].abs();
        let pivot = (k..n).fold(k, |best, i| if size(i) > size(best) { i } else { best });
        if !(size(pivot) > 0.0 && size(pivot).is_finite()) {
            return false;
        }
        if pivot != k {
            let (above, below) = rows.split_at_mut(pivot * width);
            above[k * width..][..width].swap_with_slice(&mut below[..width]);
        }

        // Take its row from those below.
        let (above, below) = rows.split_at_mut((k + 1) * width);
        let row = &above[k * width + k..];
        for other in below.chunks_exact_mut(width).take(n - k - 1) {
            let factor = other[k] / row[0];
            if factor != 0.0 {
                other[k..].iter_mut().zip(row).for_each(|(x, pivot)| *x -= factor * pivot);
            }
        }
    }

    // Back substitution.
    for k in (0..n).rev() {
        let (above, below) = rows.split_at_mut((k + 1) * width);
        let row = &mut above[k * width..];
        let (matrix, right) = row.split_at_mut(n);
        for (i, solved) in below.chunks_exact(width).take(n - k - 1).enumerate() {
            let factor = matrix[k + 1 + i];
            right.iter_mut().zip(&solved[n..]).for_each(|(x, known)| *x -= factor * known);
        }
        for x in right.iter_mut() {
            *x /= matrix[k];
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// u″ = −u + (1, t), from u = (0, 1), u′ = (1, 0).
    fn swing(
        collocation: &mut LinearCollocation,
        t0: f64,
        h: f64,
        from: [&[f64]; 2],
    ) -> LinearStep {
        let nodes = collocation.nodes().to_vec();
        let coefficients: Vec<_> = nodes
            .iter()
            .map(|c| LinearCoefficients {
                by_position: vec![-1.0],
                by_velocity: vec![0.0],
                forcing: vec![1.0, t0 + c * h],
            })
            .collect();
        collocation.step((t0, h), (from[0], from[1]), &coefficients).expect("regular")
    }

    fn exact(t: f64) -> ([f64; 2], [f64; 2]) {
        let (s, c) = t.sin_cos();
        ([1.0 - c + s, t + c - s], [s + c, 1.0 - s - c])
    }

    #[test]
    fn the_end_has_twice_the_order_and_the_inside_one_more_than_the_stages() {
        for (stages, s) in [(Stages::Three, 3), (Stages::Five, 5)] {
            let mut method = LinearCollocation::new(stages, 1, 2);
            let worst = |method: &mut LinearCollocation, h: f64| {
                let step = swing(method, 0.0, h, [&[0.0, 1.0], &[1.0, 0.0]]);
                let error = |t: f64| {
                    let (mut u, mut rate) = ([0.0; 2], [0.0; 2]);
                    step.at(t, &mut u, &mut rate);
                    let (u_exact, rate_exact) = exact(t);
                    (0..2)
                        .map(|k| (u[k] - u_exact[k]).abs().max((rate[k] - rate_exact[k]).abs()))
                        .fold(0.0, f64::max)
                };
                let inside = (1..20).map(|k| error(h * f64::from(k) / 20.0)).fold(0.0, f64::max);
                (error(h), inside)
            };
            let (coarse, fine) = (worst(&mut method, 1.0), worst(&mut method, 0.5));
            let order = |a: f64, b: f64| (a / b).log2();
            let (end, inside) = (order(coarse.0, fine.0), order(coarse.1, fine.1));
            assert!(
                (end - 2.0 * f64::from(s)).abs() < 0.6,
                "{s} stages: local order {end} at the end"
            );
            assert!((inside - f64::from(s) - 1.0).abs() < 0.6, "{s} stages: order {inside} inside");
        }
    }

    #[test]
    fn the_estimate_is_near_the_error_inside() {
        let mut method = LinearCollocation::new(Stages::Five, 1, 2);
        for h in [0.3, 1.0, 2.0] {
            let step = swing(&mut method, 0.0, h, [&[0.0, 1.0], &[1.0, 0.0]]);
            let estimate = step.errors().fold(0.0, f64::max);
            let error = (1..50).map(|k| {
                let (mut u, mut rate) = ([0.0; 2], [0.0; 2]);
                let t = h * f64::from(k) / 50.0;
                step.at(t, &mut u, &mut rate);
                (0..2).map(|i| (rate[i] - exact(t).1[i]).abs()).fold(0.0, f64::max)
            });
            let error = error.fold(0.0, f64::max);
            assert!((0.2..20.0).contains(&(estimate / error)), "{h}: {estimate:e} for {error:e}");
        }
    }

    #[test]
    fn a_step_of_the_size_told_has_the_error_asked_for() {
        const TOLERANCE: f64 = 1e-9;
        let mut method = LinearCollocation::new(Stages::Five, 1, 2);
        let error = |method: &mut LinearCollocation, h: f64| {
            let step = swing(method, 0.0, h, [&[0.0, 1.0], &[1.0, 0.0]]);
            step.errors().fold(0.0, f64::max) / TOLERANCE
        };
        let mut h = 2.0;
        for _ in 0..4 {
            let told = error(&mut method, h);
            h = method.longest_step(h, told);
        }
        let left = error(&mut method, h);
        assert!((0.3..0.9).contains(&left), "{left} tolerances at {h}");
        assert!(method.longest_step(h, f64::NAN) < 0.5 * h);
    }

    #[test]
    fn a_step_is_that_through_its_own_nodes() {
        let mut method = LinearCollocation::new(Stages::Five, 1, 2);
        let step = swing(&mut method, 0.2, 0.7, [&[0.0, 1.0], &[1.0, 0.0]]);
        let at_nodes: Vec<f64> = method
            .nodes()
            .iter()
            .flat_map(|c| {
                let (mut u, mut rate) = ([0.0; 2], [0.0; 2]);
                step.at(0.2 + c * 0.7, &mut u, &mut rate);
                [1.0 - u[0], 0.2 + c * 0.7 - u[1]]
            })
            .collect();
        let again = method.through((0.2, 0.7), (&[0.0, 1.0], &[1.0, 0.0]), &at_nodes);
        for (one, other) in step.w.iter().zip(&again.w) {
            // Stages integrate the polynomial through their own values: they are off by the error of the step.
            assert!((one - other).abs() < 1e-6, "{:?} and {:?}", step.w, again.w);
        }
    }

    #[test]
    fn a_stiff_component_dies_away_in_one_step() {
        // u″ = −1e6 u′: u′ falls to zero at once.
        let mut method = LinearCollocation::new(Stages::Five, 1, 1);
        let one = LinearCoefficients {
            by_position: vec![0.0],
            by_velocity: vec![-1e6],
            forcing: vec![0.0],
        };
        let step = method.step((0.0, 1.0), (&[0.0], &[1.0]), &vec![one; 5]).expect("regular");
        let (mut u, mut rate) = ([0.0], [0.0]);
        step.at(1.0, &mut u, &mut rate);
        assert!(rate[0].abs() < 1e-5 && u[0].abs() < 1e-5, "{u:?} {rate:?}");
    }

    #[test]
    fn elimination_takes_pivots_and_refuses_none() {
        let mut rows = vec![0.0, 2.0, 4.0, 1.0, 1.0, 3.0];
        assert!(eliminate(&mut rows, 2, 3));
        assert_eq!([rows[2], rows[5]], [1.0, 2.0]);
        assert!(!eliminate(&mut [1.0, 2.0, 0.0, 2.0, 4.0, 0.0], 2, 3));
    }
}
