//! Evaluation of the graph itself, operands first: the reference for every other evaluator.

use crate::op::{Function, Op, power, select};
use crate::pool::{Expr, Pool, SymbolId};
use crate::sweep::{Step, Sweep};
use std::convert::Infallible;

/// Reason why an expression has no value.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvalError {
    /// A symbol was not given a value.
    #[error("symbol `{name}` has no value")]
    Unbound {
        /// The symbol.
        symbol: SymbolId,
        /// Name of the symbol.
        name: String,
    },
}

/// The first operation that left the real numbers.
#[derive(Clone, PartialEq, Debug)]
pub struct DomainFault {
    /// The operation with its operands.
    pub expr: Expr,
    /// Kind of the operation: a function's name, `division`, `power`, `sum` or `product`.
    pub operation: &'static str,
    /// The finite operand values that made the result infinite or NaN.
    pub operands: Vec<f64>,
}

impl Pool {
    /// The value of `e` in `f64` arithmetic; infinities and NaN are values like others.
    ///
    /// # Errors
    /// [`EvalError::Unbound`] names a symbol for which `value` has none.
    pub fn evaluate(
        &self,
        e: Expr,
        value: &dyn Fn(SymbolId) -> Option<f64>,
    ) -> Result<f64, EvalError> {
        let sweep = self.sweep(&self.expand_named(&[e]));
        let bound = |symbol| {
            let unbound = || EvalError::Unbound { symbol, name: self.symbol_name(symbol) };
            value(symbol).ok_or_else(unbound)
        };
        Ok(self.values(&sweep, &bound)?[sweep.roots[0]])
    }

    /// The first operation (operands first) whose value is infinite or NaN though its operands
    /// are finite. Branches of `if` that are not taken, and symbols without a value, are no fault.
    pub fn domain_fault(
        &self,
        e: Expr,
        value: &dyn Fn(SymbolId) -> Option<f64>,
    ) -> Option<DomainFault> {
        let sweep = self.sweep(&self.expand_named(&[e]));
        let bound = |symbol| Ok::<_, Infallible>(value(symbol).unwrap_or(f64::NAN));
        let Ok(values) = self.values(&sweep, &bound);
        let needed = needed_steps(&sweep, &values);
        sweep.steps.iter().zip(&values).zip(needed).find_map(|((step, result), is_needed)| {
            let operands: Vec<f64> = sweep.operands(step).map(|o| values[o]).collect();
            let is_fault = is_needed
                && !result.is_finite()
                && !operands.is_empty()
                && step.op != Op::Pair
                && operands.iter().all(|v| v.is_finite());
            is_fault.then(|| fault(step, operands))
        })
    }

    /// Values of all steps, or the error of a symbol without one; functions with names are expanded before.
    pub(crate) fn values<E>(
        &self,
        sweep: &Sweep,
        value: &dyn Fn(SymbolId) -> Result<f64, E>,
    ) -> Result<Vec<f64>, E> {
        let mut values: Vec<f64> = Vec::with_capacity(sweep.steps.len());
        for step in &sweep.steps {
            let result = match step.op {
                // Leaves.
                Op::Number => self.number_of(step.expr).to_f64(),
                Op::Pi => std::f64::consts::PI,
                Op::Symbol => value(SymbolId(step.data))?,
                // Arithmetic.
                Op::Add => {
                    let terms = sweep.operands(step).map(|o| values[o]);
                    terms.reduce(|sum, term| sum + term).expect("a sum has terms")
                }
                Op::Mul => product_value(sweep, step, &values),
                Op::Pow => {
                    let [base, exponent] = sweep.operand_array(step);
                    power(values[base], values[exponent])
                }
                // Functions; a pair has no value of its own, as `if` takes those of its branches.
                Op::Pair => 0.0,
                Op::Named => f64::NAN,
                Op::Call(Function::If) => {
                    let [condition, then, otherwise] = sweep.branches(step);
                    select(values[condition], values[then], values[otherwise])
                }
                Op::Call(function) if function.arity() == 1 => {
                    let [a] = sweep.operand_array(step);
                    function.value(values[a], 0.0)
                }
                Op::Call(function) => {
                    let [a, b] = sweep.operand_array(step);
                    function.value(values[a], values[b])
                }
            };
            values.push(result);
        }
        Ok(values)
    }
}

/// Numerator over denominator: factors `b^(−1)` divide instead of multiplying by `1/b`.
fn product_value(sweep: &Sweep, step: &Step, values: &[f64]) -> f64 {
    let (mut numerator, mut denominator) = (1.0, 1.0);
    for o in sweep.operands(step) {
        match reciprocal_base(sweep, o, values) {
            Some(base) => denominator *= base,
            None => numerator *= values[o],
        }
    }
    numerator / denominator
}

/// The value of `b` where the step at `position` is `b^(−1)`.
fn reciprocal_base(sweep: &Sweep, position: usize, values: &[f64]) -> Option<f64> {
    let step = &sweep.steps[position];
    if step.op != Op::Pow {
        return None;
    }
    let [base, exponent] = sweep.operand_array(step);
    (values[exponent] == -1.0 && sweep.steps[exponent].op == Op::Number).then(|| values[base])
}

/// Which steps the roots' values depend on, leaving out branches not taken.
fn needed_steps(sweep: &Sweep, values: &[f64]) -> Vec<bool> {
    let mut needed = vec![false; sweep.steps.len()];
    for &root in &sweep.roots {
        needed[root] = true;
    }
    for (position, step) in sweep.steps.iter().enumerate().rev() {
        if !needed[position] {
            continue;
        }
        if step.op == Op::Call(Function::If) {
            let [condition, then, otherwise] = sweep.branches(step);
            needed[condition] = true;
            needed[if values[condition] == 0.0 { otherwise } else { then }] = true;
        } else {
            sweep.operands(step).for_each(|o| needed[o] = true);
        }
    }
    needed
}

/// Describes the fault of a step at finite operands.
fn fault(step: &Step, mut operands: Vec<f64>) -> DomainFault {
    let operation = match step.op {
        Op::Call(function) => function.name(),
        Op::Pow if operands[0] == 0.0 && operands[1] < 0.0 => {
            operands.truncate(1);
            "division"
        }
        Op::Pow => "power",
        Op::Mul => "product",
        Op::Add => "sum",
        Op::Number | Op::Symbol | Op::Pi | Op::Pair | Op::Named => {
            unreachable!("{:?} computes nothing from its operands", step.op)
        }
    };
    DomainFault { expr: step.expr, operation, operands }
}
