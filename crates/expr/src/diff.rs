//! Differentiation on the shared graph: each node once, operands before users.

use crate::build::MERGE_LIMIT;
use crate::op::{Function, Op};
use crate::pool::{Expr, ONE, Pool, SymbolId, ZERO};
use crate::sweep::{Step, Sweep};
use std::collections::HashMap;

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

impl Pool {
    /// ∂e/∂x
    pub fn diff(&self, e: Expr, x: SymbolId) -> Expr {
        self.total_derivative(e, &[(x, ONE)])
    }

    /// The partial derivatives of `e` with respect to each of `xs`.
    pub fn gradient(&self, e: Expr, xs: &[SymbolId]) -> Vec<Expr> {
        let sweep = self.sweep(&[e]);
        xs.iter().map(|&x| self.tangents(&sweep, &[(x, ONE)])[sweep.roots[0]]).collect()
    }

    /// All ∂rows/∂columns that are not identically zero.
    pub fn jacobian(&self, rows: &[Expr], columns: &[SymbolId]) -> SparseJacobian {
        let sweep = self.sweep(rows);
        let mut entries = Vec::new();
        for (column, &x) in columns.iter().enumerate() {
            let tangents = self.tangents(&sweep, &[(x, ONE)]);
            let derivatives = sweep.roots.iter().map(|&root| tangents[root]);
            entries.extend(
                derivatives.enumerate().filter(|d| d.1 != ZERO).map(|(row, d)| (row, column, d)),
            );
        }
        entries.sort_unstable_by_key(|&(row, column, _)| (row, column));
        SparseJacobian { n_rows: rows.len(), n_columns: columns.len(), entries }
    }

    /// Σ ∂e/∂xᵢ · rateᵢ: the rate of `e` when each symbol changes at its rate, others rest.
    pub fn total_derivative(&self, e: Expr, rates: &[(SymbolId, Expr)]) -> Expr {
        let sweep = self.sweep(&[e]);
        self.tangents(&sweep, rates)[sweep.roots[0]]
    }

    /// Derivative of every step along the given rates of the symbols.
    fn tangents(&self, sweep: &Sweep, rates: &[(SymbolId, Expr)]) -> Vec<Expr> {
        let rates: HashMap<SymbolId, Expr> = rates.iter().copied().collect();
        let mut tangents: Vec<Expr> = Vec::with_capacity(sweep.steps.len());
        for step in &sweep.steps {
            let rests = sweep.operands(step).all(|o| tangents[o] == ZERO);
            let tangent = match step.symbol() {
                Some(symbol) => rates.get(&symbol).copied().unwrap_or(ZERO),
                None if rests => ZERO,
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
            Op::Pow | Op::Pair | Op::Call(_) => {
                let (a, da) = operands.next().unwrap_or((ZERO, ZERO));
                let (b, db) = operands.next().unwrap_or((ZERO, ZERO));
                match step.op {
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
    fn product_rule(&self, factors: &[(Expr, Expr)]) -> Expr {
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

    /// (aⁿ)' = n aⁿ⁻¹ a'; (aᵇ)' = aᵇ (b' ln a + b a'/a)
    fn power_rule(&self, power: Expr, (a, da): (Expr, Expr), (b, db): (Expr, Expr)) -> Expr {
        if db == ZERO {
            let lowered = self.pow(a, self.sub(b, ONE));
            return self.product([b, lowered, da]);
        }
        let from_exponent = self.mul(db, self.ln(a));
        let from_base = if da == ZERO { ZERO } else { self.product([b, da, self.powi(a, -1)]) };
        self.mul(power, self.add(from_exponent, from_base))
    }

    /// f(a, b)' = f_a a' + f_b b'
    fn chain_rule(
        &self,
        function: Function,
        call: Expr,
        (a, da): (Expr, Expr),
        (b, db): (Expr, Expr),
    ) -> Expr {
        match function.derivative(self, call, a, b) {
            Some((by_a, by_b)) => self.add(self.mul(by_a, da), self.mul(by_b, db)),
            None => ZERO,
        }
    }
}
