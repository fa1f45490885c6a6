//! Forward sweeps: the derivatives of every step along one direction.

use super::MatrixEntry;
use super::dependence::Dependence;
use super::rules::partial_derivatives;
use crate::build::MERGE_LIMIT;
use crate::op::{Function, Op};
use crate::pool::{Expr, ONE, Pool, SymbolId, ZERO};
use crate::sweep::{Step, Sweep};
use std::collections::HashMap;

impl Pool {
    /// The derivatives of some rows, one column after the other.
    pub(super) fn forward_rows(
        &self,
        sweep: &Sweep,
        dependence: &Dependence,
        rows: &[usize],
    ) -> Vec<MatrixEntry> {
        let roots: Vec<usize> = rows.iter().map(|&row| sweep.roots[row]).collect();
        let found = self.forward_steps(sweep, dependence, &roots);
        let at_row = |(index, column, derivative)| (rows[index], column, derivative);
        found.into_iter().map(at_row).collect()
    }

    /// The derivatives of the steps at `targets`, each with its index there, by every column.
    pub(super) fn forward_steps(
        &self,
        sweep: &Sweep,
        dependence: &Dependence,
        targets: &[usize],
    ) -> Vec<MatrixEntry> {
        let mut changing = vec![Vec::new(); dependence.n_columns];
        for position in dependence.reach(sweep, targets).into_iter().rev() {
            for column in dependence.columns(position) {
                changing[column].push(position);
            }
        }
        let mut targets_of = vec![Vec::new(); dependence.n_columns];
        for (index, &position) in targets.iter().enumerate() {
            for column in dependence.columns(position) {
                targets_of[column].push((index, position));
            }
        }
        let mut tangents = vec![ZERO; sweep.steps.len()];
        let mut entries = Vec::new();
        for (column, positions) in changing.iter().enumerate() {
            for &position in positions {
                let step = &sweep.steps[position];
                let is_constant = sweep.operands(step).all(|o| tangents[o] == ZERO);
                tangents[position] = match step.op {
                    Op::Symbol => ONE,
                    _ if is_constant => ZERO,
                    _ => self.tangent(sweep, step, &tangents),
                };
            }
            let derivatives = targets_of[column].iter().map(|&(i, p)| (i, column, tangents[p]));
            entries.extend(derivatives.filter(|entry| entry.2 != ZERO));
            for &position in positions {
                tangents[position] = ZERO;
            }
        }
        entries
    }

    /// Derivative of every step along the given rates of the symbols.
    pub(super) fn tangents(&self, sweep: &Sweep, rates: &[(SymbolId, Expr)]) -> Vec<Expr> {
        let mut rate_of: HashMap<SymbolId, Expr> = HashMap::with_capacity(rates.len());
        for &(symbol, rate) in rates {
            let sum = rate_of.entry(symbol).or_insert(ZERO);
            *sum = self.add(*sum, rate);
        }
        let mut tangents: Vec<Expr> = Vec::with_capacity(sweep.steps.len());
        for step in &sweep.steps {
            let is_constant = sweep.operands(step).all(|o| tangents[o] == ZERO);
            let tangent = match step.symbol() {
                Some(symbol) => rate_of.get(&symbol).copied().unwrap_or(ZERO),
                None if is_constant => ZERO,
                None => self.tangent(sweep, step, &tangents),
            };
            tangents.push(tangent);
        }
        tangents
    }

    /// Derivative of one step from those of its operands, not all of which are zero.
    fn tangent(&self, sweep: &Sweep, step: &Step, tangents: &[Expr]) -> Expr {
        let mut operands = sweep.operands(step).map(|o| (sweep.steps[o].expr, tangents[o]));
        match step.op {
            Op::Number | Op::Symbol | Op::Pi => ZERO,
            Op::Add => self.sum(operands.map(|(_, d)| d)),
            Op::Mul => self.product_rule(&operands.collect::<Vec<_>>()),
            Op::Named => self.sum(
                operands
                    .enumerate()
                    .filter(|(_, (_, d))| *d != ZERO)
                    .map(|(parameter, (_, d))| self.mul(self.named_slope(step.expr, parameter), d)),
            ),
            Op::Pow | Op::Pair | Op::Call(_) => {
                let (a, da) = operands.next().expect("a function has an argument");
                // Functions of one argument have no second.
                let (b, db) = operands.next().unwrap_or((ZERO, ZERO));
                match step.op {
                    Op::Pow | Op::Call(Function::Sqrt)
                        if let Some(moving) = self.moving_factors(sweep, step, tangents) =>
                    {
                        self.power_of_product_rule(step, &moving)
                    }
                    Op::Pow => self.power_rule(step.expr, (a, da), (b, db)),
                    Op::Call(Function::If) => {
                        let branches = self.node(db);
                        match branches.op {
                            Op::Pair => self.select(a, branches.left, branches.right),
                            // Neither branch changes.
                            _ => ZERO,
                        }
                    }
                    Op::Call(function) => self.chain_rule(function, step.expr, (a, da), (b, db)),
                    _ => self.intern(Op::Pair, da, db, 0),
                }
            }
        }
    }

    /// (f g h)' = f' g h + f g' h + f g h'
    pub(super) fn product_rule(&self, factors: &[(Expr, Expr)]) -> Expr {
        if factors.len() <= MERGE_LIMIT as usize {
            return self.sum(factors.iter().enumerate().filter(|(_, f)| f.1 != ZERO).map(
                |(i, &(_, derivative))| {
                    let others = factors.iter().enumerate().filter(|&(j, _)| j != i);
                    self.product(others.map(|(_, f)| f.0).chain([derivative]))
                },
            ));
        }
        // (F g)' = F' g + F g' from left to right keeps long products linear.
        let (_, derivative) = factors.iter().fold((ONE, ZERO), |(product, d), &(g, dg)| {
            (self.mul(product, g), self.add(self.mul(d, g), self.mul(product, dg)))
        });
        derivative
    }

    /// f(a, b)' = f_a a' + f_b b'
    fn chain_rule(
        &self,
        function: Function,
        call: Expr,
        (a, da): (Expr, Expr),
        (b, db): (Expr, Expr),
    ) -> Expr {
        let (by_a, by_b) = partial_derivatives(self, function, call, a, b);
        self.add(self.mul(by_a, da), self.mul(by_b, db))
    }
}
