//! Constraint rows at velocity and at acceleration level.

use bksim_expr::{Expr, Pool};
use bksim_model::Model;

use crate::system::SymbolicSystem;

/// G v + ∂g/∂t of one row.
pub fn constraint_velocity(pool: &Pool, system: &SymbolicSystem, row: usize) -> Expr {
    let v = |i: usize| pool.symbol_expr(system.coordinates()[i].v);
    let terms = system.constraint_jacobian.row(row).iter().map(|&(i, g)| pool.mul(g, v(i)));
    pool.sum(terms.chain([system.constraint_rate[row]]).collect::<Vec<_>>())
}

/// G v̇ + γ of one row.
pub fn constraint_acceleration(model: &Model, system: &SymbolicSystem, row: usize) -> Expr {
    let pool = &model.pool;
    let a = |i: usize| pool.symbol_expr(system.coordinates()[i].a);
    let terms = system.constraint_jacobian.row(row).iter().map(|&(i, g)| pool.mul(g, a(i)));
    pool.sum(terms.chain([constraint_gamma(model, system, row)]).collect::<Vec<_>>())
}

/// γ = (∂/∂q (G v + ∂g/∂t)) v + ∂/∂t (G v + ∂g/∂t).
pub fn constraint_gamma(model: &Model, system: &SymbolicSystem, row: usize) -> Expr {
    system.kinematics.rate(model, constraint_velocity(&model.pool, system, row))
}
