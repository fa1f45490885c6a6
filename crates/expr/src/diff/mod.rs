//! Differentiation on the shared graph: each node once, forward or backward, whichever is shorter.
//!
//! ```text
//! forward    ẋ = 1 for one symbol;   u̇ = Σ ∂u/∂a · ȧ    over the operands a of u
//! backward   f̄ = 1 for one function; ā = Σ ∂u/∂a · ū    over the users u of a
//! ```
//!
//! A forward sweep gives the derivatives of all functions by one symbol, a backward sweep those of
//! one function by all symbols. Which symbols a node depends on is found first, so that neither
//! visits a node whose derivative is zero.

mod dependence;
mod forward;
mod powers;
mod products;
mod reverse;
mod rules;

use crate::build::MERGE_LIMIT;
use crate::pool::{Expr, ONE, Pool, SymbolId, ZERO};
use crate::sweep::Sweep;
use dependence::Dependence;

/// The structural non-zeros of a matrix of derivatives.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct SparseJacobian {
    /// Number of rows, one per differentiated expression.
    pub n_rows: usize,
    /// Number of columns, one per symbol.
    pub n_columns: usize,
    /// Row, column and derivative, in row-major order; no entry is the number 0.
    pub entries: Vec<(usize, usize, Expr)>,
}

/// One entry of a matrix of derivatives: row, column, derivative.
type MatrixEntry = (usize, usize, Expr);

/// Cost of one step backward, in forward steps for one symbol. Above the ratio of the work
/// itself, about two, because forward derivatives stay factored: (√u)˙ = u̇/(2√u) has one quotient,
/// while backward every term of u is divided. Equations to be read have few symbols and go forward.
const REVERSE_COST: usize = 4;

/// Symbols above which a gradient is taken backward without comparing costs.
const MANY_COLUMNS: usize = 1 << 12;

impl Pool {
    /// ∂e/∂x for any symbol: a coordinate, a velocity, a parameter.
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let e = pool.parse("m*g*l*(1 - cos(q))").expect("valid");
    /// let [q, l] = ["q", "l"].map(|name| pool.find_symbol(name).expect("was parsed"));
    /// assert_eq!(pool.to_text(pool.diff(e, q)), "g*l*m*sin(q)");
    /// assert_eq!(pool.to_text(pool.diff(e, l)), "g*m*(1 - cos(q))");
    /// ```
    pub fn diff(&self, e: Expr, x: SymbolId) -> Expr {
        self.total_derivative(e, &[(x, ONE)])
    }

    /// The partial derivatives of `e` with respect to each of `xs`.
    ///
    /// One backward sweep where there are many symbols: the work is a few times that of `e`,
    /// whatever their number.
    pub fn gradient(&self, e: Expr, xs: &[SymbolId]) -> Vec<Expr> {
        // Far beyond the number where it pays to go backward, without sets of columns.
        if xs.len() > MANY_COLUMNS {
            return self.vjp(&[e], &[ONE], xs);
        }
        let mut gradient = vec![ZERO; xs.len()];
        for (_, column, derivative) in self.jacobian(&[e], xs).entries {
            gradient[column] = derivative;
        }
        gradient
    }

    /// All ∂rows/∂columns that are not identically zero.
    ///
    /// Long rows that depend on many symbols are differentiated backward, all others forward.
    pub fn jacobian(&self, rows: &[Expr], columns: &[SymbolId]) -> SparseJacobian {
        let sweep = self.sweep(rows);
        let mut entries = Vec::new();
        for (first, dependence) in Dependence::in_groups(&sweep, columns) {
            let found = self.jacobian_of_group(&sweep, &dependence);
            entries.extend(found.into_iter().map(|(row, column, d)| (row, first + column, d)));
        }
        entries.sort_unstable_by_key(|&(row, column, _)| (row, column));
        SparseJacobian { n_rows: rows.len(), n_columns: columns.len(), entries }
    }

    fn jacobian_of_group(&self, sweep: &Sweep, dependence: &Dependence) -> Vec<MatrixEntry> {
        let plan = Plan::new(sweep, dependence);
        let mut entries = self.forward_rows(sweep, dependence, &plan.forward);
        entries.extend(self.reverse_rows(sweep, dependence, &plan.reverse));
        entries
    }
}

/// Which rows are differentiated which way.
struct Plan {
    forward: Vec<usize>,
    /// Rows with the positions they reach, users before operands.
    reverse: Vec<(usize, Vec<usize>)>,
}

impl Plan {
    /// A row goes backward where that costs less than its share of the forward sweeps. A forward
    /// step costs one for each symbol it depends on, more in long chains, shared by the rows that
    /// use it.
    fn new(sweep: &Sweep, dependence: &Dependence) -> Self {
        let (mut candidates, mut forward): (Vec<usize>, Vec<usize>) =
            (0..sweep.roots.len()).partition(|&r| dependence.count(sweep.roots[r]) > REVERSE_COST);
        let mut is_shared = vec![false; sweep.steps.len()];
        let roots: Vec<usize> = forward.iter().map(|&row| sweep.roots[row]).collect();
        dependence.reach(sweep, &roots).into_iter().for_each(|p| is_shared[p] = true);

        // Choosing must not cost more than the sweeps to choose from.
        let mut budget: usize = (0..sweep.steps.len()).map(|p| dependence.count(p)).sum();
        let mut n_users = vec![0usize; sweep.steps.len()];
        let mut reaches = Vec::new();
        let mut n_walked = 0;
        for &row in &candidates {
            let reach = dependence.reach(sweep, &[sweep.roots[row]]);
            for &p in &reach {
                n_users[p] += 1;
            }
            n_walked += 1;
            budget = budget.saturating_sub(reach.len());
            reaches.push((row, reach));
            if budget == 0 {
                break;
            }
        }
        forward.extend(candidates.drain(n_walked..));
        let share = |p: usize| {
            let n_merged = sweep.operands(&sweep.steps[p]).len().div_ceil(MERGE_LIMIT as usize);
            let cost = dependence.count(p) * n_merged.max(1);
            if is_shared[p] { 0.0 } else { cost as f64 / n_users[p] as f64 }
        };
        let (reverse, rest): (Vec<_>, Vec<_>) = reaches.into_iter().partition(|(_, reach)| {
            let forward_cost: f64 = reach.iter().map(|&p| share(p)).sum();
            (REVERSE_COST * reach.len()) as f64 <= forward_cost
        });
        forward.extend(rest.into_iter().map(|(row, _)| row));
        Self { forward, reverse }
    }
}
