//! The syntax tree of an expression in text: flat, with byte spans, unaware of any meaning.

use crate::number::Number;
use std::ops::Range;

/// A syntax tree as nodes in post-order: children come before their parent, the root is last.
#[derive(Clone, PartialEq, Debug)]
pub struct Syntax {
    /// All nodes; the last one is the whole expression.
    pub nodes: Vec<SyntaxNode>,
}

/// One node of a [`Syntax`].
#[derive(Clone, PartialEq, Debug)]
pub struct SyntaxNode {
    /// The kind of node, with its parts.
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
        /// Bytes of the number.
        value_span: Range<usize>,
        /// The unit's factors in the order written, exponents of divisors negated.
        factors: Vec<UnitFactor>,
    },
    /// An operand with a unit after it, such as `2*(1 + pi) rad/s`.
    Unit {
        /// The operand.
        operand: usize,
        /// The unit's factors, as in a [`SyntaxKind::Quantity`].
        factors: Vec<UnitFactor>,
    },
    /// A name, such as `m1` or `crank.B.x`.
    Name(String),
    /// `name(arguments)`; neither the name nor the number of arguments is checked.
    Call {
        /// Name of the function.
        name: String,
        /// Bytes of the name.
        name_span: Range<usize>,
        /// The arguments.
        arguments: Vec<usize>,
    },
    /// `−operand`
    Negate(usize),
    /// `left operator right`
    Binary {
        /// The operation.
        operator: BinaryOperator,
        /// Bytes of its sign.
        operator_span: Range<usize>,
        /// The left operand.
        left: usize,
        /// The right operand.
        right: usize,
    },
}

impl SyntaxKind {
    /// The indices of its operands.
    pub(crate) fn operands_mut(&mut self) -> Box<dyn Iterator<Item = &mut usize> + '_> {
        match self {
            Self::Number(_) | Self::Quantity { .. } | Self::Name(_) => Box::new(std::iter::empty()),
            Self::Call { arguments, .. } => Box::new(arguments.iter_mut()),
            Self::Negate(operand) | Self::Unit { operand, .. } => {
                Box::new(std::iter::once(operand))
            }
            Self::Binary { left, right, .. } => Box::new([left, right].into_iter()),
        }
    }
}

/// The operators between two operands.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[expect(missing_docs, reason = "each variant is the operation of its name")]
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
    /// Bytes of the factor, with its exponent.
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

/// Reason why text is no expression, and its span.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{kind}")]
pub struct ParseError {
    /// The kind of fault.
    pub kind: ParseErrorKind,
    /// The offending bytes of the text; empty at its end when something is missing.
    pub span: Range<usize>,
}

/// The fault of a text.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ParseErrorKind {
    /// An opening parenthesis is never closed; the span is the opening one.
    #[error("this parenthesis is never closed")]
    UnclosedParenthesis,
    /// A closing parenthesis closes nothing.
    #[error("this parenthesis was never opened")]
    UnopenedParenthesis,
    /// A token where another one must be.
    #[error("found `{found}`, expected {expected}")]
    UnexpectedToken {
        /// The token found.
        found: String,
        /// The tokens that could be there.
        expected: &'static str,
    },
    /// The text ends too early.
    #[error("the expression ends here, expected {expected}")]
    UnexpectedEnd {
        /// The tokens that could follow.
        expected: &'static str,
    },
    /// A character that no expression contains.
    #[error("unexpected character `{found}`")]
    UnexpectedCharacter {
        /// The character.
        found: char,
    },
    /// Parentheses nest deeper than allowed.
    #[error("parentheses nest deeper than {limit} levels")]
    TooDeep {
        /// The limit.
        limit: usize,
    },
    /// Something that starts like a number and is none, such as `1.2.3`.
    #[error("`{found}` is no number")]
    BadNumber {
        /// The text of the number.
        found: String,
    },
    /// A number with more digits than are written out.
    #[error("the number has more than {limit} digits when it is written out")]
    NumberTooLong {
        /// The limit.
        limit: u64,
    },
    /// The identifier after a number is no unit.
    #[error("unknown unit `{name}`")]
    UnknownUnit {
        /// The identifier.
        name: String,
    },
    /// A call of a function that does not exist.
    #[error("unknown function `{name}`")]
    UnknownFunction {
        /// The name.
        name: String,
    },
    /// A call with too few or too many arguments.
    #[error("`{name}` takes {expected} arguments, found {found}")]
    WrongArity {
        /// The function.
        name: String,
        /// Number of arguments it takes.
        expected: usize,
        /// Number of arguments written.
        found: usize,
    },
    /// A number with a unit where only plain numbers make sense.
    #[error("a unit is not allowed here")]
    UnitNotAllowed,
}

/// The error of a kind at a span.
pub(crate) fn error(kind: ParseErrorKind, span: Range<usize>) -> ParseError {
    ParseError { kind, span }
}
