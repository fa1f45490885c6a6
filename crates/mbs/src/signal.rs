//! Signals of loads and drives as expressions of the motion.

use bksim_expr::{Expr, SymbolId};
use bksim_model::{Model, Signal};

use crate::kinematics::Kinematics;

/// Each signal symbol with the measure it stands for, as an expression.
pub fn signal_values(model: &Model, kinematics: &Kinematics) -> Vec<(SymbolId, Expr)> {
    let value = |signal: &Signal| {
        (signal.symbol, model.pool.simplify(kinematics.measure(model, signal.measure)))
    };
    model.signals.iter().map(value).collect()
}
