//! The equations of motion as a person reads them, and as a program parses them.

use bksim_expr::Expr;

use crate::assemble::SymbolicSystem;
use crate::model::Model;

/// How formulas are written.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Notation {
    /// Infix with plain identifiers: `m*x_ddot + c*x_dot`.
    Text,
    /// LaTeX: `m \ddot{x} + c \dot{x}`.
    Latex,
}

/// Every formula of a system, in one notation.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Equations {
    /// T.
    pub kinetic_energy: String,
    /// V.
    pub potential_energy: String,
    /// Left sides of the Lagrange equations (1.3), one per coordinate; each equals zero.
    pub equations: Vec<String>,
    /// Left sides of the constraints; each equals zero.
    pub constraints: Vec<String>,
}

/// Writes the formulas of `system`.
pub fn equations(model: &Model, system: &SymbolicSystem, notation: Notation) -> Equations {
    let pool = &model.pool;
    let one = |e: Expr| match notation {
        Notation::Text => pool.to_text(e),
        Notation::Latex => pool.to_latex(e),
    };
    let sum = |terms: &[Expr]| match notation {
        Notation::Text => pool.terms_to_text(terms),
        Notation::Latex => pool.terms_to_latex(terms),
    };
    Equations {
        kinetic_energy: sum(&kinetic_terms(model, system)),
        potential_energy: one(system.potential_energy),
        equations: (0..system.coordinates().len())
            .map(|i| sum(&lagrange_terms(model, system, i)))
            .collect(),
        constraints: system.constraints.iter().map(|c| one(c.expression)).collect(),
    }
}

/// Terms of T, one for each product of velocities.
fn kinetic_terms(model: &Model, system: &SymbolicSystem) -> Vec<Expr> {
    let pool = &model.pool;
    let v = |i: usize| pool.symbol_expr(system.coordinates()[i].v);
    let mut terms = Vec::new();
    for i in 0..system.coordinates().len() {
        for j in 0..=i {
            let factor = if i == j { pool.rational(1, 2) } else { pool.one() };
            terms.push(pool.product([factor, system.mass_matrix[i][j], v(i), v(j)]));
        }
    }
    nonzero(model, terms)
}

/// Left side of the i-th Lagrange equation, in the order of the book: accelerations, velocity
/// terms, potential, loads, constraint forces.
pub fn lagrange_terms(model: &Model, system: &SymbolicSystem, i: usize) -> Vec<Expr> {
    let pool = &model.pool;
    let accelerations = system
        .coordinates()
        .iter()
        .zip(&system.mass_matrix[i])
        .map(|(c, &m)| pool.mul(m, pool.symbol_expr(c.a)));
    let others = [system.bias[i], system.potential_gradient[i], pool.neg(system.force[i])];
    let multipliers = system
        .constraints
        .iter()
        .zip(&system.constraint_jacobian)
        .map(|(c, row)| pool.mul(row[i], pool.symbol_expr(c.lambda)));
    nonzero(model, accelerations.chain(others).chain(multipliers).collect())
}

fn nonzero(model: &Model, mut terms: Vec<Expr>) -> Vec<Expr> {
    terms.retain(|&term| !model.pool.is_zero(term));
    terms
}
