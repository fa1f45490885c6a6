//! Functions that have a name: tables, laws of motion and paths; calls of tables that have no value beyond their
//! rows.

use bksim_expr::{Expr, FunctionId};

use crate::diagnostic::Span;

/// A place where a table is called whose argument must stay within its rows.
#[derive(Clone, Debug)]
pub struct TableCall {
    /// Name of the table.
    pub table: String,
    /// Argument of the table call, SI: an expression of time, parameters and signals.
    pub argument: Expr,
    /// First and last argument of the table, SI.
    pub range: [f64; 2],
    /// SI unit of the argument as text.
    pub unit: String,
    /// Position of the call.
    pub span: Span,
}

/// Measured values over one argument, whether or not an expression calls them.
#[derive(Clone, PartialEq, Debug)]
pub struct MeasuredCurve {
    /// Name of the table.
    pub name: String,
    /// SI units of the argument and of the value; empty for numbers without one.
    pub units: [String; 2],
    /// One after the other; there are no values where none holds.
    pub pieces: Vec<FunctionPiece>,
}

/// A function that expressions call by its name.
#[derive(Clone, Debug)]
pub struct NamedFunction {
    /// The function, known by its name in the pool.
    pub function: FunctionId,
    /// One after the other; the function has no value where none holds.
    pub pieces: Vec<FunctionPiece>,
}

/// A part of a function with one formula: Σ c (x − x₀)ⁿ (y − y₀)ᵐ + A sin(ω (x − x₀) + φ).
#[derive(Clone, PartialEq, Debug)]
pub struct FunctionPiece {
    /// First and last value of each argument, SI; infinite where there is none.
    pub ranges: Vec<[f64; 2]>,
    /// x₀, and y₀ of two arguments.
    pub origin: Vec<f64>,
    /// n and m, and c.
    pub terms: Vec<([usize; 2], f64)>,
    /// A, ω and φ.
    pub sine: Option<[f64; 3]>,
}
