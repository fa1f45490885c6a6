//! [`Shape`]: the entries that M and G have.

use bksim_expr::Expr;
use bksim_mbs::system::SymbolicSystem;

/// Which entries of M and G there are, in the order of their values.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub(crate) struct Shape {
    pub(crate) nq: usize,
    pub(crate) nc: usize,
    /// (i, j) with i ≥ j.
    pub(crate) mass: Vec<(usize, usize)>,
    /// (row, coordinate).
    pub(crate) jacobian: Vec<(usize, usize)>,
    /// Rows between rates, which are no gradients of a position, ascending.
    pub(crate) of_rates: Vec<usize>,
}

impl Shape {
    pub(crate) fn of(system: &SymbolicSystem) -> Self {
        let position = |(row, col, _): (usize, usize, Expr)| (row, col);
        Self {
            nq: system.coordinates().len(),
            nc: system.constraints.len(),
            mass: system.mass_matrix.lower().map(position).collect(),
            jacobian: system.constraint_jacobian.entries().map(position).collect(),
            of_rates: {
                let rows = system.constraints.iter().enumerate();
                rows.filter(|(_, c)| c.is_of_rates()).map(|(row, _)| row).collect()
            },
        }
    }
}
