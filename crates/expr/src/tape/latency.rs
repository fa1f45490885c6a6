//! Processor cycles until the results of operations are known: what the order of sums goes by.

use super::Action;
use crate::op::Function;

/// Cycles until the result of an operation is known, once its operands are, about as processors of 2020 to 2025 have them
/// (A. Fog, *Instruction tables*; those of Intel and AMD differ by one or two).
pub(super) fn cycles(action: Action) -> u32 {
    match action {
        Action::Negate | Action::Call(Function::Abs) => 1,
        Action::Add | Action::Subtract => 3,
        Action::Multiply => 4,
        Action::Divide => 14,
        Action::Call(Function::Sqrt) => 20,
        Action::Call(
            Function::Min
            | Function::Max
            | Function::Lt
            | Function::Le
            | Function::Gt
            | Function::Ge
            | Function::If,
        ) => 5,
        Action::Power | Action::Turn | Action::Call(_) => 60,
    }
}
