//! Calls of tables that have no value beyond their rows.

use bksim_expr::Expr;

use crate::diagnostic::Span;

/// A place where a table is called whose argument must stay within its rows.
#[derive(Clone, Debug)]
pub struct TableCall {
    /// Name of the table.
    pub table: String,
    /// Its argument, SI: an expression of time, parameters and signals.
    pub argument: Expr,
    /// First and last argument of the table, SI.
    pub range: [f64; 2],
    /// SI unit of the argument as text.
    pub unit: String,
    /// Position of the call.
    pub span: Span,
}
