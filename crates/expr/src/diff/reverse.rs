//! Backward sweeps: the derivative of one function by every step below it.

use super::MatrixEntry;
use super::dependence::Dependence;
use super::rules::partial_derivatives;
use crate::build::MERGE_LIMIT;
use crate::op::{Function, Op};
use crate::pool::{Expr, ONE, Pool, ZERO};
use crate::sweep::{Step, Sweep};

impl Pool {
    /// The derivatives of some rows, each with the positions it reaches, users before operands.
    pub(super) fn reverse_rows(
        &self,
        sweep: &Sweep,
        dependence: &Dependence,
        rows: &[(usize, Vec<usize>)],
    ) -> Vec<MatrixEntry> {
        let mut shares = vec![Vec::new(); sweep.steps.len()];
        let mut entries = Vec::new();
        for (row, reach) in rows {
            shares[sweep.roots[*row]].push(ONE);
            let sums = self.reverse(sweep, dependence, reach, &mut shares).into_iter();
            let of_row = sums.map(|(column, sum)| (*row, column, sum));
            entries.extend(of_row.filter(|entry| entry.2 != ZERO));
        }
        entries
    }

    /// One backward sweep over the positions in reach, users before operands: the derivative of
    /// Σ wᵢ uᵢ by each column found, columns ascending.
    ///
    /// The weights wᵢ of the steps uᵢ are given as the first of their `shares`, the contributions
    /// of the users of each step to its adjoint so far; all shares are taken out again.
    pub(super) fn reverse(
        &self,
        sweep: &Sweep,
        dependence: &Dependence,
        reach: &[usize],
        shares: &mut [Vec<Expr>],
    ) -> Vec<(usize, Expr)> {
        let mut of_columns = Vec::new();
        let branches = self.branch_derivatives(sweep, dependence, reach);
        for &position in reach {
            let adjoint = self.sum(std::mem::take(&mut shares[position]));
            if adjoint == ZERO {
                continue;
            }
            let step = &sweep.steps[position];
            if let Some(symbol) = step.symbol() {
                let columns = dependence.columns_of(symbol).iter();
                of_columns.extend(columns.map(|&(_, column)| (column, adjoint)));
                continue;
            }
            let start = branches.partition_point(|branch| branch.0 < position);
            let own = branches[start..].iter().take_while(|branch| branch.0 == position);
            for &(_, column, derivative) in own {
                of_columns.push((column, self.mul(adjoint, derivative)));
            }
            self.pull_back(sweep, step, adjoint, &mut |operand, share| {
                if share != ZERO && !dependence.is_empty(operand) {
                    shares[operand].push(share);
                }
            });
        }
        // Stable: the shares of a column stay in the order of the sweep.
        of_columns.sort_by_key(|&(column, _)| column);
        let same_column = |a: &(usize, Expr), b: &(usize, Expr)| a.0 == b.0;
        let columns = of_columns.chunk_by(same_column);
        columns.map(|shares| (shares[0].0, self.sum(shares.iter().map(|s| s.1)))).collect()
    }

    /// Position, column and derivative of every `if` in reach, in ascending order. They are
    /// differentiated forward: backward, the branch not taken would enter with weight 0, which
    /// spoils the sum where that branch has no finite derivative.
    fn branch_derivatives(
        &self,
        sweep: &Sweep,
        dependence: &Dependence,
        reach: &[usize],
    ) -> Vec<MatrixEntry> {
        let is_if = |&&p: &&usize| sweep.steps[p].op == Op::Call(Function::If);
        let positions: Vec<usize> = reach.iter().filter(is_if).copied().collect();
        if positions.is_empty() {
            return Vec::new();
        }
        let found = self.forward_steps(sweep, dependence, &positions);
        let mut entries: Vec<MatrixEntry> =
            found.into_iter().map(|(index, column, d)| (positions[index], column, d)).collect();
        entries.sort_unstable_by_key(|&(position, column, _)| (position, column));
        entries
    }

    /// Gives each operand its share `adjoint · ∂step/∂operand`; an `if` gives none.
    fn pull_back(
        &self,
        sweep: &Sweep,
        step: &Step,
        adjoint: Expr,
        give: &mut dyn FnMut(usize, Expr),
    ) {
        let mut operands = sweep.operands(step);
        match step.op {
            Op::Add => operands.for_each(|operand| give(operand, adjoint)),
            Op::Mul => self.pull_back_product(sweep, &operands.collect::<Vec<_>>(), adjoint, give),
            Op::Pow => {
                let [base, exponent] = sweep.operand_array(step);
                let (a, b) = (sweep.steps[base].expr, sweep.steps[exponent].expr);
                if let Some(factors) = self.factors_under(sweep, step) {
                    self.pull_back_power(sweep, &factors, [adjoint, b, step.expr], give);
                } else {
                    let lowered = self.pow(a, self.sub(b, ONE));
                    give(base, self.product([adjoint, b, lowered]));
                }
                if self.as_number(b).is_none() {
                    let logarithm = self.logarithm_under_power(a, b);
                    give(exponent, self.product([adjoint, step.expr, logarithm]));
                }
            }
            Op::Call(Function::Sqrt) if let Some(factors) = self.factors_under(sweep, step) => {
                let parts = [adjoint, self.rational(1, 2), step.expr];
                self.pull_back_power(sweep, &factors, parts, give);
            }
            Op::Call(function) if function != Function::If => {
                let (first, second) = (operands.next(), operands.next());
                let expr = |operand: Option<usize>| operand.map_or(ZERO, |o| sweep.steps[o].expr);
                let (a, b) = (expr(first), expr(second));
                let (by_a, by_b) = partial_derivatives(self, function, step.expr, a, b);
                for (operand, slope) in [(first, by_a), (second, by_b)] {
                    if let Some(operand) = operand {
                        give(operand, self.mul(adjoint, slope));
                    }
                }
            }
            Op::Named => operands.enumerate().for_each(|(parameter, operand)| {
                give(operand, self.mul(adjoint, self.named_slope(step.expr, parameter)));
            }),
            Op::Number | Op::Symbol | Op::Pi | Op::Pair | Op::Call(_) => (),
        }
    }

    /// Each factor's share is the product of the adjoint and all other factors.
    fn pull_back_product(
        &self,
        sweep: &Sweep,
        factors: &[usize],
        adjoint: Expr,
        give: &mut dyn FnMut(usize, Expr),
    ) {
        let expr = |factor: usize| sweep.steps[factor].expr;
        if factors.len() <= MERGE_LIMIT as usize {
            for (i, &factor) in factors.iter().enumerate() {
                // The numeric coefficient leads and has no derivative.
                if self.as_number(expr(factor)).is_none() {
                    let others = factors.iter().enumerate().filter(|&(j, _)| j != i);
                    give(factor, self.product(others.map(|(_, &o)| expr(o)).chain([adjoint])));
                }
            }
            return;
        }
        // Products of all factors before and of all after each one keep long products linear.
        let mut after = vec![adjoint];
        for &factor in factors[1..].iter().rev() {
            after.push(self.mul(expr(factor), after[after.len() - 1]));
        }
        let mut before = ONE;
        for (&factor, &after) in factors.iter().zip(after.iter().rev()) {
            give(factor, self.mul(before, after));
            before = self.mul(before, expr(factor));
        }
    }
}
