//! The adjoint of linear equations of second order, back along a motion that is known, by collocation.
//!
//! A goal changes by α·u + β·u′ with the state at one end of a step. Towards the other end
//!
//! ```text
//! α′ = −Kᵀ β,   β′ = −α − Cᵀ β          so that (α·u + β·u′)′ = β·B along u″ = K u + C u′ + B
//! β_i = β₀ + δ_i                        i = 1 … s, the nodes of Radau IIA from there
//! Σ (A⁻¹)_ij δ_j + h C_iᵀ δ_i − h² Σ A_ij K_jᵀ δ_j = h² Σ A_ij K_jᵀ β₀ − h C_iᵀ β₀ − h α₀
//! α = α₀ − h Σ b_j K_jᵀ β_j,   ∫ β·B = −h Σ b_j β_j·B_j
//! ```
//!
//! h is the size of the step with its sign, so that it is negative where the motion went forward. One costate replaces the
//! changes by any number of quantities. Sources: Y. Cao, S. Li, L. Petzold and R. Serban, *Adjoint sensitivity analysis for
//! differential-algebraic equations*, SIAM J. Sci. Comput. 24 (2003); HW2 §IV.5 for the collocation.

#![expect(clippy::inline_always, reason = "kernels are compiled with the registers of `run`")]

use pulp::{Simd, WithSimd};

use super::{LinearCoefficients, LinearCollocation, eliminate_rows, falling};
use crate::lanes::run;
use crate::settings::Stages;

/// The method with its buffers, for n unknowns.
#[derive(Clone, Debug)]
pub struct AdjointCollocation {
    of: LinearCollocation,
    /// A⁻¹ by rows.
    a_inverse: Vec<f64>,
}

/// The costates of a state: α and β, the derivatives of a goal by u and u′.
#[derive(Clone, PartialEq, Debug)]
pub struct Costates {
    /// α, n.
    pub by_position: Vec<f64>,
    /// β, n.
    pub by_velocity: Vec<f64>,
}

/// The costates over one step.
#[derive(Clone, PartialEq, Debug)]
pub struct AdjointStep {
    /// α and β where it ends.
    pub end: Costates,
    /// β at the nodes, one node after the other.
    pub by_velocity: Vec<f64>,
    /// Estimate of the largest error of β at the nodes: the part that two degrees more would have, by how the
    /// coefficients fall. Between nodes, where nothing is asked for, errors are larger.
    pub error: f64,
}

impl Costates {
    /// Costates of a goal that does not change with n unknowns.
    pub fn zeros(n: usize) -> Self {
        Self { by_position: vec![0.0; n], by_velocity: vec![0.0; n] }
    }
}

/// See [`AdjointCollocation::solve`].
struct Solve<'a> {
    collocation: &'a mut AdjointCollocation,
    h: f64,
    from: &'a Costates,
    all: &'a [LinearCoefficients],
}

impl WithSimd for Solve<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let Self { collocation, h, from, all } = self;
        collocation.solve(h, from, all)
    }
}

impl AdjointCollocation {
    /// The method with this number of stages.
    #[expect(clippy::missing_panics_doc, reason = "the matrix of a collocation method is regular")]
    pub fn new(stages: Stages, n: usize) -> Self {
        let of = LinearCollocation::new(stages, n, 1);
        let s = stages.count();
        let a = nalgebra::DMatrix::from_row_slice(s, s, &of.a);
        let inverse = a.try_inverse().expect("the nodes are distinct and none is zero");
        Self { of, a_inverse: inverse.transpose().as_slice().to_vec() }
    }

    /// The nodes in (0, 1], ascending, from where a step begins.
    pub fn nodes(&self) -> &[f64] {
        self.of.nodes()
    }

    /// The weights b of the nodes: −h Σ b_j f_j is the integral of f over a step, against its direction.
    pub fn weights(&self) -> &[f64] {
        let s = self.of.c.len();
        &self.of.a[(s - 1) * s..]
    }

    /// Longest step; see [`LinearCollocation::longest_step`].
    pub fn longest_step(&self, h: f64, error: f64) -> f64 {
        self.of.longest_step(h, error)
    }

    /// The step over `h` from costates, with K and C at the nodes; `None` where the system is singular or a number is not
    /// finite.
    pub fn step(
        &mut self,
        h: f64,
        from: &Costates,
        coefficients: &[LinearCoefficients],
    ) -> Option<AdjointStep> {
        if !run(Solve { collocation: self, h, from, all: coefficients }) {
            return None;
        }

        // β at the nodes: the last of them is where the step ends.
        let LinearCollocation { n, c, system, .. } = &self.of;
        let (n, s) = (*n, c.len());
        let width = s * n + 1;
        let delta = |node: usize, i: usize| system[(node + i * s) * width + s * n];
        let at = |node: usize| (0..n).map(move |i| from.by_velocity[i] + delta(node, i));
        let by_velocity: Vec<f64> = (0..s).flat_map(at).collect();

        // α where it ends.
        let mut end = Costates {
            by_position: from.by_position.clone(),
            by_velocity: (0..n).map(|i| by_velocity[by_velocity.len() - n + i]).collect(),
        };
        let of_nodes = by_velocity.chunks_exact(n.max(1)).zip(coefficients);
        for ((beta, LinearCoefficients { by_position, .. }), b) in of_nodes.zip(self.weights()) {
            for (row, beta) in by_position.chunks_exact(n.max(1)).zip(beta) {
                let out = end.by_position.iter_mut().zip(row);
                out.for_each(|(alpha, k)| *alpha -= h * b * k * beta);
            }
        }
        let error = self.error(&delta);
        let numbers = end.by_position.iter().chain(&by_velocity);
        let are_finite = numbers.fold(true, |all, value| all & value.is_finite());
        are_finite.then_some(AdjointStep { end, by_velocity, error })
    }

    /// The largest part of β that two degrees more would have, from the Legendre coefficients of h β′ = A⁻¹ δ.
    fn error(&self, delta: &impl Fn(usize, usize) -> f64) -> f64 {
        let LinearCollocation { n, c, to_legendre, .. } = &self.of;
        let s = c.len();
        let product = |row: &[f64], i: usize| -> f64 {
            row.iter().enumerate().map(|(node, x)| x * delta(node, i)).sum()
        };
        // The last two rows of the Legendre coefficients, times A⁻¹.
        let rows = [s - 2, s - 1].map(|degree| -> Vec<f64> {
            let of = &to_legendre[degree * s..][..s];
            let column =
                |j: usize| of.iter().enumerate().map(move |(i, x)| x * self.a_inverse[i * s + j]);
            (0..s).map(|j| column(j).sum()).collect()
        });
        let of_unknown = |i: usize| {
            let last = product(&rows[1], i);
            falling(last, falling(product(&rows[0], i), last))
        };
        let errors = (0..*n).map(of_unknown);
        errors.fold(0.0, f64::max)
    }

    /// Solves for the δ_i, which are then the right sides of the system; false where it is singular.
    #[inline(always)]
    fn solve(&mut self, h: f64, from: &Costates, all: &[LinearCoefficients]) -> bool {
        let Self { of: LinearCollocation { n, c, a, system, .. }, a_inverse } = self;
        let (n, s) = (*n, c.len());
        let width = s * n + 1;
        let Costates { by_position: alpha, by_velocity: beta } = from;
        for i in 0..s {
            for unknown in 0..n {
                let row = &mut system[(i + unknown * s) * width..][..width];
                let (matrix, right) = row.split_at_mut(s * n);
                right[0] = -h * alpha[unknown];
                for (other, block) in matrix.chunks_exact_mut(s).enumerate() {
                    for (j, (x, of_node)) in block.iter_mut().zip(all).enumerate() {
                        *x = -h * h * a[i * s + j] * of_node.by_position[other * n + unknown];
                    }
                    block[i] += h * all[i].by_velocity[other * n + unknown];
                    right[0] -= block.iter().sum::<f64>() * beta[other];
                }
                let own = matrix[unknown * s..][..s].iter_mut().zip(&a_inverse[i * s..][..s]);
                own.for_each(|(x, inverse)| *x += inverse);
            }
        }
        eliminate_rows(system, s * n, width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// u″ = K u + C u′ + B with these coefficients of time, for two unknowns.
    fn coefficients(t: f64) -> LinearCoefficients {
        LinearCoefficients {
            by_position: vec![-2.0 + t, 0.3, 0.1 * t, -1.0],
            by_velocity: vec![-0.1, 0.2 * t, -0.4, -0.05],
            forcing: vec![1.0 + t * t, t.cos()],
        }
    }

    fn at_nodes(nodes: &[f64], t0: f64, h: f64) -> Vec<LinearCoefficients> {
        nodes.iter().map(|c| coefficients(t0 + c * h)).collect()
    }

    /// The change of a goal 0.7 u₀ − 0.2 u₁ + 0.5 u₁′ at `t = 1` from two ways: the changes forward, and the costates
    /// back, in `n` steps each.
    fn both(stages: Stages, n_steps: u32) -> [f64; 2] {
        let (weights, rates) = ([0.7, -0.2], [0.0, 0.5]);
        let h = 1.0 / f64::from(n_steps);
        let mut forward = LinearCollocation::new(stages, 2, 1);
        let nodes = forward.nodes().to_vec();
        let (start, start_rate) = ([0.4, -0.3], [0.1, 0.9]);
        let (mut u, mut rate) = (start, start_rate);
        for k in 0..n_steps {
            let t0 = f64::from(k) * h;
            let step = forward.step((t0, h), (&u, &rate), &at_nodes(&nodes, t0, h));
            step.expect("regular").at(t0 + h, &mut u, &mut rate);
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let one = dot(&weights, &u) + dot(&rates, &rate);

        let mut back = AdjointCollocation::new(stages, 2);
        let mut costates = Costates { by_position: weights.into(), by_velocity: rates.into() };
        let mut integral = 0.0;
        for k in (0..n_steps).rev() {
            let t1 = f64::from(k + 1) * h;
            let all = at_nodes(&nodes, t1, -h);
            let step = back.step(-h, &costates, &all).expect("regular");
            let of_nodes = step.by_velocity.chunks_exact(2).zip(&all).zip(back.weights());
            let parts = of_nodes.map(|((beta, at), b)| h * b * dot(beta, &at.forcing));
            integral += parts.sum::<f64>();
            costates = step.end;
        }
        let Costates { by_position, by_velocity } = &costates;
        [one, dot(by_position, &start) + dot(by_velocity, &start_rate) + integral]
    }

    #[test]
    fn costates_tell_what_the_changes_do() {
        let [forward, back] = both(Stages::Seven, 4);
        assert!((forward - back).abs() < 1e-13, "{forward} and {back}");
    }

    #[test]
    fn the_order_is_that_of_the_method() {
        let [exact, _] = both(Stages::Seven, 8);
        let error = |n| (both(Stages::Three, n)[1] - exact).abs();
        let order = (error(2) / error(4)).log2();
        assert!((order - 5.0).abs() < 0.5, "order {order}");
    }

    #[test]
    fn the_estimate_is_near_the_error_at_the_nodes() {
        // β = sin t for α = −cos t, K = −1: from t = 0.
        let at =
            LinearCoefficients { by_position: vec![-1.0], by_velocity: vec![0.0], forcing: vec![] };
        let mut method = AdjointCollocation::new(Stages::Five, 1);
        for h in [-0.5, 1.0, 2.0] {
            let from = Costates { by_position: vec![-1.0], by_velocity: vec![0.0] };
            let step = method.step(h, &from, &vec![at.clone(); 5]).expect("regular");
            let of_nodes = step.by_velocity.iter().zip(method.nodes());
            let errors = of_nodes.map(|(beta, c): (&f64, &f64)| (beta - (c * h).sin()).abs());
            let error = errors.fold(0.0, f64::max);
            assert!(
                (0.2..50.0).contains(&(step.error / error)),
                "{h}: {:e} for {error:e}",
                step.error
            );
        }
    }
}
