//! The marks a formula is made of; every notation is a table from marks to text.

use crate::named_row::FunctionId;
use crate::number::Number;
use crate::op::Function;
use crate::pool::{Pool, SymbolId};

/// The beginning, the separation and the end of a mark that encloses others.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum MarkPart {
    Start,
    Middle,
    End,
}

/// One mark of a formula, in writing order.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Mark {
    /// A number without its sign.
    Number(Number),
    /// π.
    Pi,
    Symbol(SymbolId),
    /// A symbol to a natural power.
    RaisedSymbol(SymbolId, u64),
    /// Between terms.
    Plus,
    Minus,
    /// In front of a first term.
    Sign,
    /// Between factors.
    Times,
    /// Division within the line.
    Over,
    /// Numerator, middle, denominator; not within the line.
    Fraction(MarkPart),
    /// Base, then [`Mark::Raised`], or middle, exponent, end.
    Power(MarkPart),
    /// Ends a power whose exponent is a natural number.
    Raised(u64),
    Root(MarkPart),
    Absolute(MarkPart),
    /// Parentheses around a sum; they grow when their content is tall.
    Parenthesis(MarkPart, Height),
    /// A function's name, with the power of its value: sin² is `(Sin, 2)`.
    Function(Function, u64),
    /// The name of a function that has one of its own, with its derivatives.
    Named(FunctionId),
    /// Between a function's name and an argument without parentheses.
    Apply,
    /// Parentheses around arguments; middle is the comma.
    Arguments(MarkPart, Height),
    /// First value, middle, condition; then [`Mark::Otherwise`], other value, end.
    Cases(MarkPart),
    Otherwise,
    /// A comparison, as a condition or enclosed by [`Mark::Truth`].
    Relation(Function),
    /// A condition that is no comparison holds where its value is not zero.
    NotZero,
    /// Encloses a comparison used as a number, 1 or 0.
    Truth(MarkPart),
}

/// How parentheses are set.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Height {
    /// Height of a line.
    Line,
    /// Height of the content.
    Tall,
    /// The partner is in another line.
    Split,
}

/// The names of symbols.
pub(super) struct SymbolNames<'p> {
    pub(super) pool: &'p Pool,
}

impl SymbolNames<'_> {
    pub(super) fn of(&self, symbol: SymbolId) -> String {
        self.pool.symbol_name(symbol)
    }

    /// The name of a function; behind it the primes of one variable, and before it the variables by which one of
    /// two is differentiated.
    pub(super) fn of_function(&self, function: FunctionId) -> FunctionName {
        let (name, parameters) = self.pool.signature_of(function);
        let orders = self.pool.named(function, |row| row.orders);
        if let [_] = parameters[..] {
            let primes = "'".repeat(orders[0] as usize);
            return FunctionName { name, primes, by: Vec::new() };
        }
        let by = parameters.iter().zip(orders);
        let by = by.flat_map(|(&s, n)| std::iter::repeat_n(self.of(s), n as usize)).collect();
        FunctionName { name, primes: String::new(), by }
    }
}

/// The name of a function and of which derivative of it.
pub(super) struct FunctionName {
    pub(super) name: String,
    pub(super) primes: String,
    /// The variables by which it is differentiated.
    pub(super) by: Vec<String>,
}

/// The sign of a comparison; `None` for other functions.
pub(super) fn relation(function: Function) -> Option<char> {
    Some(match function {
        Function::Lt => '<',
        Function::Le => '≤',
        Function::Gt => '>',
        Function::Ge => '≥',
        _ => return None,
    })
}

/// Name of a function in a formula.
pub(super) fn function_name(function: Function) -> &'static str {
    match function {
        Function::Asin => "arcsin",
        Function::Acos => "arccos",
        Function::Atan => "arctan",
        Function::Sign => "sgn",
        other => other.name(),
    }
}

/// Mantissa and power of ten of a number's digits; a fraction of long numbers is a decimal.
pub(super) fn digits(n: &Number) -> (String, Option<String>) {
    let mut text = n.magnitude().to_string();
    if text.contains('/') && n.is_finite() {
        text = format!("{:?}", n.magnitude().to_f64());
    }
    match text.split_once('e') {
        Some((mantissa, exponent)) => (mantissa.to_owned(), Some(exponent.to_owned())),
        None => (text, None),
    }
}
