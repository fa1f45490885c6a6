//! Lagrange's equations in the order of the book, part by part.
//!
//! ```text
//! Σ_j M_ij q̈_j  +  h_i(q, q̇)  +  ∂V/∂q_i  −  Q_i  +  Σ_k λ_k ∂g_k/∂q_i  =  0
//! ```

use bksim_expr::{Expr, Pool};

use crate::assemble::constraint_jacobian;
use crate::coordinate::CoordinateKind;
use crate::system::SymbolicSystem;
use bksim_model::Model;

/// The kind of a part of a Lagrange equation, in the order in which parts are written.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Kind {
    /// M q̈.
    Inertia,
    /// h: Coriolis and centrifugal terms.
    Velocity,
    /// ∂V/∂q: gravity and springs.
    Potential,
    /// −Q: loads without a potential.
    Load,
    /// Gᵀλ.
    Constraint,
}

impl Kind {
    /// Characters of the longest title.
    pub(super) const LONGEST_TITLE: usize = 19;

    /// The name of the kind.
    pub fn title(self) -> &'static str {
        match self {
            Self::Inertia => "inertia",
            Self::Velocity => "velocity products",
            Self::Potential => "gravity and springs",
            Self::Load => "loads",
            Self::Constraint => "constraint forces",
        }
    }
}

/// A sum multiplied by one acceleration or multiplier, or by 1.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Part {
    /// The kind of its terms.
    pub kind: Kind,
    /// q̈_j, λ_k or 1.
    pub factor: Expr,
    /// The terms of the sum.
    pub sum: Vec<Expr>,
}

impl Part {
    /// The part as terms of the equation: one product, or the terms of the sum if the factor is 1.
    pub fn terms(&self, pool: &Pool) -> Vec<Expr> {
        if pool.is_one(self.factor) {
            return self.sum.clone();
        }
        vec![pool.mul(pool.sum(self.sum.iter().copied()), self.factor)]
    }
}

/// The system with its rows folded, and G from these: long rows run as they are.
pub(super) fn to_be_read(model: &Model, system: &SymbolicSystem) -> SymbolicSystem {
    let pool = &model.pool;
    let mut system = system.clone();
    for constraint in &mut system.constraints {
        constraint.expression = pool.simplify(constraint.expression);
    }
    let rows = (system.constraints.as_slice(), u64::MAX);
    let mut slopes = constraint_jacobian(model, &system.tree, &system.kinematics, rows);
    for slope in slopes.entries_mut() {
        *slope = pool.simplify(*slope);
    }
    system.constraint_jacobian = slopes;
    system
}

/// The parts of the i-th equation that are not zero.
pub(super) fn lagrange_parts(model: &Model, system: &SymbolicSystem, i: usize) -> Vec<Part> {
    let pool = &model.pool;
    let part = |kind, factor, e| Part { kind, factor, sum: vec![e] };
    let acceleration = |j: usize| pool.symbol_expr(system.coordinates()[j].a);
    let inertia = system.mass_matrix.row(i).iter();
    let inertia = inertia.map(|&(j, m)| part(Kind::Inertia, acceleration(j), m));
    let others = [
        part(Kind::Velocity, pool.one(), system.bias[i]),
        part(Kind::Potential, pool.one(), system.potential_gradient[i]),
        part(Kind::Load, pool.one(), pool.neg(system.applied_force[i])),
    ];
    let multiplier = |k: usize| pool.symbol_expr(system.constraints[k].lambda);
    let forces = system.constraint_jacobian.column(i);
    let forces = forces.map(|(k, g)| part(Kind::Constraint, multiplier(k), g));
    let parts = inertia.chain(others).chain(forces);
    parts.filter(|part| !pool.is_zero(part.sum[0])).collect()
}

/// The parts of all equations whose M v̇ + h + ∂V/∂q is one sum, found by recursion.
pub(super) fn recursive_parts(
    model: &Model,
    system: &SymbolicSystem,
    inverse_dynamics: &[Expr],
) -> Vec<Vec<Part>> {
    let one = model.pool.one();
    let others = |part: &Part| matches!(part.kind, Kind::Load | Kind::Constraint);
    let parts = |(i, &force): (usize, &Expr)| {
        let inertia = Part { kind: Kind::Inertia, factor: one, sum: vec![force] };
        let rest = lagrange_parts(model, system, i).into_iter().filter(others);
        [inertia].into_iter().chain(rest).collect()
    };
    inverse_dynamics.iter().enumerate().map(parts).collect()
}

/// Terms of T, one for each product of velocities: the product and its coefficient.
pub(super) fn kinetic_parts(model: &Model, system: &SymbolicSystem) -> Vec<(Expr, Expr)> {
    let pool = &model.pool;
    let v = |i: usize| pool.symbol_expr(system.coordinates()[i].v);
    let half = |i, j| if i == j { pool.rational(1, 2) } else { pool.one() };
    // The row of a state has one where others have a mass.
    let is_state = |i: usize| system.coordinates()[i].kind == CoordinateKind::Integral;
    let lower = system.mass_matrix.lower().filter(|&(i, ..)| !is_state(i));
    lower.map(|(i, j, entry)| (pool.product([half(i, j), v(i), v(j)]), entry)).collect()
}
