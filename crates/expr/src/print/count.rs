//! Operations of an expression, on the shared graph and as printed.

use crate::number::Number;
use crate::op::Op;
use crate::pool::{Expr, Pool};
use crate::sweep::{Step, Sweep};

/// Operations of some expressions. Signs are free; `x^n` takes n − 1 multiplications.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct OperationCount {
    /// Multiplications, shared parts counted once.
    pub multiplications: u64,
    /// Additions and subtractions, shared parts counted once.
    pub additions: u64,
    /// Divisions, shared parts counted once.
    pub divisions: u64,
    /// Function calls and general powers, shared parts counted once.
    pub calls: u64,
    /// All operations when every expression is written out in full; saturates.
    pub as_printed: u64,
}

impl OperationCount {
    /// All operations on the shared graph.
    pub fn shared(&self) -> u64 {
        self.multiplications + self.additions + self.divisions + self.calls
    }
}

/// Operations by kind.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Operations {
    /// Multiplications.
    pub multiplications: u64,
    /// Additions and subtractions.
    pub additions: u64,
    /// Divisions.
    pub divisions: u64,
    /// Function calls and general powers.
    pub calls: u64,
}

impl Operations {
    /// All of them.
    pub fn total(self) -> u64 {
        [self.additions, self.divisions, self.calls]
            .iter()
            .fold(self.multiplications, |sum, &n| sum.saturating_add(n))
    }

    /// Adds other operations; saturates.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            multiplications: self.multiplications.saturating_add(other.multiplications),
            additions: self.additions.saturating_add(other.additions),
            divisions: self.divisions.saturating_add(other.divisions),
            calls: self.calls.saturating_add(other.calls),
        }
    }
}

impl OperationCount {
    /// The operations on the shared graph by kind.
    pub fn operations(&self) -> Operations {
        Operations {
            multiplications: self.multiplications,
            additions: self.additions,
            divisions: self.divisions,
            calls: self.calls,
        }
    }
}

impl Pool {
    /// Operations by kind when every expression is written out in full; saturates.
    pub fn printed_operations(&self, roots: &[Expr]) -> Operations {
        let sweep = self.sweep(roots);
        let stands_alone = stands_alone(&sweep);
        let mut printed: Vec<Operations> = Vec::with_capacity(sweep.steps.len());
        for (position, step) in sweep.steps.iter().enumerate() {
            let mut own = self.own_operations(&sweep, step);
            if !stands_alone[position] {
                own.divisions = own.divisions.min(u64::from(step.op == Op::Mul));
            }
            let below = sweep.operands(step).map(|o| printed[o]);
            printed.push(below.fold(own.operations(), Operations::plus));
        }
        sweep.roots.iter().map(|&root| printed[root]).fold(Operations::default(), Operations::plus)
    }

    /// Counts the operations of `roots` together.
    pub fn operation_count(&self, roots: &[Expr]) -> OperationCount {
        let sweep = &self.sweep(roots);
        let stands_alone = stands_alone(sweep);
        let mut total = OperationCount::default();
        let mut printed: Vec<u64> = Vec::with_capacity(sweep.steps.len());
        for (position, step) in sweep.steps.iter().enumerate() {
            let mut own = self.own_operations(sweep, step);
            if !stands_alone[position] {
                own.divisions = own.divisions.min(u64::from(step.op == Op::Mul));
            }
            total.multiplications += own.multiplications;
            total.additions += own.additions;
            total.divisions += own.divisions;
            total.calls += own.calls;
            let below = sweep.operands(step).fold(0u64, |sum, o| sum.saturating_add(printed[o]));
            printed.push(below.saturating_add(own.shared()));
        }
        total.as_printed =
            sweep.roots.iter().fold(0u64, |sum, &root| sum.saturating_add(printed[root]));
        total
    }

    /// Operations of one step itself. A product with divisors is one division; a negative power
    /// outside of products is one too.
    fn own_operations(&self, sweep: &Sweep, step: &Step) -> OperationCount {
        let mut own = OperationCount::default();
        let operands = sweep.operands(step).map(|o| sweep.steps[o].expr);
        let n_operands = operands.len() as u64;
        match step.op {
            Op::Number | Op::Symbol | Op::Pi | Op::Pair => (),
            Op::Add => own.additions = n_operands - 1,
            Op::Mul => {
                let is_sign = |e: &Expr| self.as_number(*e) == Some(Number::MINUS_ONE);
                let n_signs = operands.clone().filter(is_sign).count() as u64;
                let n_divisors = operands.filter(|&e| self.split_power(e).1 < 0).count() as u64;
                let n_factors = n_operands - n_signs - n_divisors;
                own.divisions = u64::from(n_divisors > 0);
                own.multiplications = n_factors.saturating_sub(1) + n_divisors.saturating_sub(1);
            }
            Op::Pow => match self.split_power(step.expr) {
                (base, n) if base != step.expr => {
                    own.multiplications = n.unsigned_abs() - 1;
                    own.divisions = u64::from(n < 0);
                }
                _ => own.calls = 1,
            },
            Op::Call(_) | Op::Named => own.calls = 1,
        }
        own
    }
}

/// Which steps are used by something other than a product.
fn stands_alone(sweep: &Sweep) -> Vec<bool> {
    let mut alone = vec![false; sweep.steps.len()];
    sweep.roots.iter().for_each(|&root| alone[root] = true);
    for step in sweep.steps.iter().filter(|step| step.op != Op::Mul) {
        sweep.operands(step).for_each(|operand| alone[operand] = true);
    }
    alone
}
