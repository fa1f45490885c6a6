//! A function with a name as the arena of a pool holds it.

use crate::handle::{Expr, SymbolId};

/// Handle to a function with a name of a [pool](crate::Pool), or to one of its derivatives.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct FunctionId(pub(crate) u32);

/// A function with a name, or a derivative of one.
#[derive(Clone, Debug)]
pub(crate) struct NamedRow {
    pub(crate) name: String,
    /// Of one argument or two.
    pub(crate) parameters: Vec<SymbolId>,
    /// How often it is differentiated by each of them.
    pub(crate) orders: [u32; 2],
    pub(crate) body: Expr,
    /// The function of which it is a derivative.
    pub(crate) base: Option<FunctionId>,
    /// The derivative by each parameter, once it was asked for.
    pub(crate) derivatives: [Option<FunctionId>; 2],
    /// Made of names and values as those of nodes are.
    pub(crate) hash: u64,
}
