//! The syntax tree of an expression in text: flat, with byte spans, unaware of any meaning.

use crate::number::Number;
use std::ops::Range;

/// What was written, as nodes in post-order: children come before their parent, the root is last.
#[derive(Clone, PartialEq, Debug)]
pub struct Syntax {
    /// All nodes; the last one is the whole expression.
    pub nodes: Vec<SyntaxNode>,
}

/// One node of a [`Syntax`].
#[derive(Clone, PartialEq, Debug)]
pub struct SyntaxNode {
    /// What it is.
    pub kind: SyntaxKind,
    /// Bytes of the source it covers, enclosing parentheses left out.
    pub span: Range<usize>,
}

/// The kinds of nodes; children are given by their index.
#[derive(Clone, PartialEq, Debug)]
pub enum SyntaxKind {
    /// A plain number.
    Number(Number),
    /// A number with a unit, such as `9.81 m/s^2`.
    Quantity {
        /// The number.
        value: Number,
        /// Where the number stands.
        value_span: Range<usize>,
        /// The unit's factors in the order written, exponents of divisors negated.
        factors: Vec<UnitFactor>,
    },
    /// A name, such as `m1` or `crank.B.x`.
    Name(String),
    /// `name(arguments)`; neither the name nor the number of arguments is checked.
    Call {
        /// Name of the function.
        name: String,
        /// Where the name stands.
        name_span: Range<usize>,
        /// The arguments.
        arguments: Vec<usize>,
    },
    /// `−operand`
    Negate(usize),
    /// `left operator right`
    Binary {
        /// Which operation.
        operator: BinaryOperator,
        /// Where its sign stands.
        operator_span: Range<usize>,
        /// The left operand.
        left: usize,
        /// The right operand.
        right: usize,
    },
}

/// The operators between two operands.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[expect(missing_docs, reason = "the names say it")]
pub enum BinaryOperator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

/// One factor of a unit, such as `s^2` in `m/s^2`, which has exponent −2.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct UnitFactor {
    /// The unit's name as written.
    pub name: String,
    /// Where the factor stands, with its exponent.
    pub span: Range<usize>,
    /// The exponent; negative for a divisor.
    pub exponent: i32,
}

impl Syntax {
    /// The node that is the whole expression.
    ///
    /// # Panics
    /// When there are no nodes, which parsing never gives.
    pub fn root(&self) -> &SyntaxNode {
        self.nodes.last().expect("a parsed expression has at least one node")
    }

    /// The names that occur outside of calls and units, with their spans, as written.
    pub fn names(&self) -> impl Iterator<Item = (&str, Range<usize>)> {
        self.nodes.iter().filter_map(|node| match &node.kind {
            SyntaxKind::Name(name) => Some((name.as_str(), node.span.clone())),
            _ => None,
        })
    }
}
