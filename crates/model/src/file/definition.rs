//! A parameter between its text and its value.

use bksim_expr::Expr;

use super::value::Lowered;
use crate::diagnostic::Span;

/// A parameter on its way from text to value.
#[derive(Debug)]
pub(super) struct ParameterState {
    pub(super) name: String,
    /// Symbol of the parameter.
    pub(super) symbol: Expr,
    /// Position of its value in the text.
    pub(super) span: Span,
    pub(super) definition: Definition,
    /// True if the definition replaces that of the text.
    pub(super) is_from_outside: bool,
    /// The form in which it is used: its symbol, value and dimension. `None` until it is read, and for ever
    /// when it is faulty.
    pub(super) result: Option<Lowered>,
    /// The expression it is equal to.
    pub(super) expr: Option<Expr>,
}

/// The definition as the author wrote it.
#[derive(Debug)]
pub(super) enum Definition {
    Number { value: f64, digits: String },
    Text { text: String, start: Option<usize>, whole: Span },
    Faulty,
}
