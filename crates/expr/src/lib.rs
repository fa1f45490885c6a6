//! Scalar expressions as a shared graph: build, differentiate, simplify, print, parse, compile.
//!
//! A [`Pool`] owns interned nodes; an [`Expr`] is a handle, and structurally equal expressions
//! share one. Constructors put expressions into a canonical form that does not depend on the order
//! of building.
//!
//! ```
//! use bksim_expr::{Pool, Quantity, Signature, Tape};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let pool = Pool::new();
//! let speed = pool.parse("(l*w*cos(q))^2 + (l*w*sin(q))^2 + l*w*(cos(q)*cos(p) - sin(q)*sin(p))")?;
//!
//! // Sums of angles and sin² + cos² fold; common factors move out.
//! let simple = pool.simplify(speed);
//! assert_eq!(pool.to_text(simple), "l*w*(l*w + cos(p + q))");
//! assert!(pool.certificate(speed, simple).is_equal()); // at random points, with 30 digits
//!
//! // Derivatives share the graph.
//! let q = pool.find_symbol("q").ok_or("q was parsed")?;
//! let slope = pool.diff(simple, q);
//! assert_eq!(pool.to_text(slope), "-l*w*sin(p + q)");
//! assert_eq!(pool.to_latex(slope), r"-l \, w \, \sin(p + q)");
//!
//! // A tape computes many outputs at once; parts that depend on parameters only are computed ahead.
//! let ids = ["q", "p", "w", "l"].map(|name| pool.find_symbol(name).expect("was parsed"));
//! let tape = Tape::compile(&pool, &[simple, slope], &ids[..3], &ids[3..])?;
//! let mut workspace = tape.workspace(&[2.0]);
//! let mut out = [0.0; 2];
//! tape.evaluate(&mut workspace, &[0.0, 0.0, 1.5], &mut out);
//! assert_eq!(out, [12.0, 0.0]);
//!
//! // It also travels as C, Rust, Python or JSON, with names, units and test points.
//! let named = |names: &[&str]| names.iter().map(|name| Quantity::new(name, "")).collect();
//! let (inputs, parameters) = (named(&["q", "p", "w"]), named(&["l"]));
//! let outputs = named(&["speed", "slope"]);
//! let signature = Signature { name: "tour".to_owned(), inputs, parameters, outputs };
//! assert!(tape.program(&signature)?.to_c().header.contains("void tour("));
//! # Ok(())
//! # }
//! ```

mod arctangent;
mod arena;
mod build;
mod call;
mod certificate;
mod codegen;
mod composed;
mod diff;
mod elementary;
mod eval;
mod handle;
mod kink;
mod lexer;
mod listing;
mod lower;
mod named;
mod named_row;
mod number;
mod op;
mod parse;
mod pool;
mod print;
mod series;
mod sign;
mod simplify;
mod sincos;
mod solve;
mod substitute;
mod sweep;
mod syntax;
mod tape;

pub use certificate::Certificate;
pub use codegen::{
    CCode, CodegenError, Program, Quantity, ScriptBody, ScriptLanguage, Signature, TestPoint,
    c_prelude,
};
pub use composed::{COMPOSED, Composed, function_names};
pub use diff::SparseJacobian;
pub use eval::{
    Batch, DomainFault, EvalError, Jit, LaneRunner, LaneValues, LaneWorkspace, Runner, Workspace,
    widest_lanes,
};
pub use listing::ListingError;
pub use lower::LowerError;
pub use named_row::FunctionId;
pub use number::Number;
pub use op::Function;
pub use parse::{ParseOptions, parse};
pub use pool::{Expr, Pool, PoolSnapshot, SymbolId};
pub use print::{Notation, OperationCount, Operations, Printer, SplitTerm};
pub use simplify::Cancelled;
pub use solve::{LinearSolution, SolveError};
pub use syntax::{
    BinaryOperator, ParseError, ParseErrorKind, Syntax, SyntaxKind, SyntaxNode, UnitFactor,
};
pub use tape::{Composition, Tape, TapeError, Value};
