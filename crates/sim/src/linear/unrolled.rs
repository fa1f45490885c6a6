//! [`UnrolledSolve`]: accelerations and multipliers of a small mechanism as one piece of
//! straight-line code, from (t, q, v) to v̇ and λ.
//!
//! The recorded elimination is carried out once with expressions in place of numbers. Its unrolled
//! steps have no indices, no loops and no zeros, are simplified and shared with the equations they
//! follow, and become machine code with them.

use bksim_expr::{Expr, Pool};

use crate::linear::elimination::Elimination;
use crate::linear::shape::Shape;

/// Updates of the elimination up to which straight-line code is made: beyond, translating it takes
/// longer than runs do, and loops over numbers are as fast.
const LARGEST: usize = 1000;

/// Outputs of the unrolled solution, as expressions of (t, q, v).
#[derive(Clone, Debug)]
pub(crate) struct UnrolledSolve {
    /// v̇, nq, then λ, nc.
    pub(crate) solution: Vec<Expr>,
    /// The factors, see [`Elimination::take`].
    pub(crate) factors: Vec<Expr>,
}

impl UnrolledSolve {
    /// Solves M v̇ + Gᵀ λ = f, G v̇ = −γ; `None` for a mechanism that is too large, or has a
    /// coordinate without inertia of its own.
    pub(crate) fn of(
        pool: &Pool,
        shape: &Shape,
        (mass, jacobian): (&[Expr], &[Expr]),
        (force, gamma): (&[Expr], &[Expr]),
    ) -> Option<Self> {
        let rows: Vec<usize> = (0..shape.nc).collect();
        let has_inertia = |i: usize| shape.mass.contains(&(i, i));
        let elimination = Elimination::new(shape, &rows);
        if elimination.n_updates() > LARGEST || !(0..shape.nq).all(has_inertia) {
            return None;
        }
        let resisting = gamma.iter().map(|&gamma| pool.neg(gamma));
        let right_side = force.iter().copied().chain(resisting).collect();
        let (solution, factors) = elimination.with_expressions(pool, (mass, jacobian), right_side);
        Some(Self { solution, factors })
    }

    /// All outputs in order.
    pub(crate) fn outputs(&self) -> Vec<Expr> {
        [self.solution.as_slice(), &self.factors].concat()
    }
}
