//! Text to syntax tree, by operator precedence on an explicit stack.
//!
//! ```text
//! sum      + −   left to right        power    ^ **   right to left, binds tighter than minus
//! product  * /   left to right        minus    −a^b is −(a^b), and a^−b is allowed
//! compare  < <= > >=   1 where it holds, 0 where not, as the functions lt, le, gt, ge
//! words    not, and, or   weaker, in this order;  if c then a else b   weakest: b goes on to the end
//! unit     after an operand and its power, tighter than a product: 2*x^2 m is 2*((x^2) m)
//! ```

mod branches;
mod units;

use crate::lexer::{Lexer, Token};
use crate::number::Number;
use crate::syntax::{
    BinaryOperator, ParseError, ParseErrorKind, Syntax, SyntaxKind, SyntaxNode, error,
};
use std::ops::Range;

/// Options of reading text.
#[derive(Clone, Copy)]
pub struct ParseOptions<'a> {
    /// How deep parentheses may nest; default 64.
    pub max_depth: usize,
    /// Whether an identifier is a unit; default: none is, so no number may carry one.
    pub is_unit: &'a dyn Fn(&str) -> bool,
    /// Whether an identifier is a name of the model. It wins over a unit where an operand stands, but not
    /// right after a number, nor after a space or `/` within a unit: the `m` of `3 N/m` is the metre.
    /// Default: none is.
    pub is_name: &'a dyn Fn(&str) -> bool,
    /// Whether an identifier goes on no unit at all, as the time `t`; default: none.
    pub is_variable: &'a dyn Fn(&str) -> bool,
}

impl Default for ParseOptions<'_> {
    fn default() -> Self {
        Self { max_depth: 64, is_unit: &|_| false, is_name: &|_| false, is_variable: &|_| false }
    }
}

impl std::fmt::Debug for ParseOptions<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ParseOptions").field("max_depth", &self.max_depth).finish_non_exhaustive()
    }
}

/// An entry of the operator stack.
enum Pending {
    Binary(BinaryOperator, Range<usize>),
    /// `left < right` and its kin: a call of the function named, without parentheses.
    Comparison(&'static str, Range<usize>),
    /// Both conditions, each 1 or 0: their product.
    And(Range<usize>),
    /// One of them at least: the larger.
    Or(Range<usize>),
    /// The opposite of a condition: 1 less it.
    Not(Range<usize>),
    Negate(Range<usize>),
    /// `if`, before `then`; the span is that of `if`, as in the next two.
    If(Range<usize>),
    /// `then`, before `else`.
    Then(Range<usize>),
    /// `else`: a call of `if` with the two operands before and the one to come.
    Else(Range<usize>),
    /// An opening parenthesis; of a call when it has a name.
    Open {
        span: Range<usize>,
        call: Option<Call>,
    },
}

struct Call {
    name: String,
    name_span: Range<usize>,
    /// Height of the operand stack at the opening parenthesis.
    floor: usize,
}

/// Binding strength of an operator on its right operand.
fn strength(pending: &Pending) -> u8 {
    match pending {
        Pending::Open { .. } | Pending::If(_) | Pending::Then(_) => 0,
        Pending::Else(_) => 1,
        Pending::Or(_) => 2,
        Pending::And(_) => 3,
        Pending::Not(_) => 4,
        Pending::Comparison(..) => 5,
        Pending::Binary(BinaryOperator::Add | BinaryOperator::Subtract, _) => 6,
        Pending::Binary(BinaryOperator::Multiply | BinaryOperator::Divide, _) => 7,
        Pending::Negate(_) => 8,
        Pending::Binary(BinaryOperator::Power, _) => 9,
    }
}

struct Parser<'t, 'o> {
    lexer: Lexer<'t>,
    options: &'o ParseOptions<'o>,
    nodes: Vec<SyntaxNode>,
    /// Finished operands: index and the span they cover with their parentheses.
    operands: Vec<(usize, Range<usize>)>,
    pending: Vec<Pending>,
    depth: usize,
}

/// Reads text into a syntax tree.
///
/// # Errors
/// A [`ParseError`] names the first fault and its span.
pub fn parse(text: &str, options: &ParseOptions<'_>) -> Result<Syntax, ParseError> {
    let mut parser = Parser {
        lexer: Lexer::new(text)?,
        options,
        nodes: Vec::new(),
        operands: Vec::new(),
        pending: Vec::new(),
        depth: 0,
    };
    loop {
        parser.operand()?;
        if !parser.operator()? {
            return Ok(Syntax { nodes: parser.nodes });
        }
    }
}

const EXPECTED_OPERAND: &str = "a number, a name or `(`";
const EXPECTED_OPERATOR: &str = "an operator";

impl Parser<'_, '_> {
    /// Reads prefixes and opening parentheses up to and including one operand.
    fn operand(&mut self) -> Result<(), ParseError> {
        loop {
            match self.lexer.token {
                Token::Sign('-') => {
                    let span = self.lexer.advance()?;
                    self.pending.push(Pending::Negate(span));
                }
                Token::Sign('(') => {
                    let span = self.lexer.advance()?;
                    self.open(span, None)?;
                }
                Token::Number(ref value) => return self.number(value.clone()),
                Token::Name if self.lexer.slice() == "not" => {
                    let span = self.lexer.advance()?;
                    self.pending.push(Pending::Not(span));
                }
                Token::Name if self.is_word() => return Err(self.unexpected_operand()),
                Token::Name => {
                    let name = self.lexer.slice().to_owned();
                    let name_span = self.lexer.advance()?;
                    if self.lexer.token != Token::Sign('(') {
                        if name == "if" {
                            self.begin_if(name_span)?;
                            continue;
                        }
                        if self.is_unit_of_product(&name) {
                            return self.unit_alone(name, name_span);
                        }
                        self.push(SyntaxKind::Name(name), name_span);
                        return Ok(());
                    }
                    let span = self.lexer.advance()?;
                    let floor = self.operands.len();
                    self.open(span, Some(Call { name, name_span, floor }))?;
                    // A call without arguments is an operand already.
                    if self.lexer.token == Token::Sign(')') {
                        let end = self.lexer.advance()?;
                        self.close(&end)?;
                        return Ok(());
                    }
                }
                Token::End => return Err(self.unclosed_or(EXPECTED_OPERAND)),
                Token::Sign(_) | Token::Comparison(_) | Token::Raised(_) => {
                    return Err(self.unexpected_operand());
                }
            }
        }
    }

    /// Reads closing parentheses up to and including one operator or comma; false at the end.
    fn operator(&mut self) -> Result<bool, ParseError> {
        loop {
            let operator = match self.lexer.token {
                Token::Sign('+') => BinaryOperator::Add,
                Token::Sign('-') => BinaryOperator::Subtract,
                Token::Sign('*') => BinaryOperator::Multiply,
                Token::Sign('/') => BinaryOperator::Divide,
                Token::Sign('^') => BinaryOperator::Power,
                Token::Comparison(_) | Token::Name if self.connective().is_some() => {
                    let pending = self.connective().expect("it was just looked at");
                    self.reduce(strength(&pending));
                    self.pending.push(pending);
                    self.lexer.advance()?;
                    return Ok(true);
                }
                Token::Raised(exponent) => {
                    self.raise(exponent)?;
                    continue;
                }
                Token::Name if ["then", "else"].contains(&self.lexer.slice()) => {
                    self.branch()?;
                    return Ok(true);
                }
                Token::Name if self.starts_unit() => {
                    self.unit_after_operand()?;
                    continue;
                }
                Token::Sign(')') => {
                    self.reduce(1);
                    self.no_branch_is_missing()?;
                    let end = self.lexer.span.clone();
                    self.close(&end)?;
                    self.lexer.advance()?;
                    continue;
                }
                Token::Sign(',') => {
                    self.reduce(1);
                    self.no_branch_is_missing()?;
                    let in_call =
                        matches!(self.pending.last(), Some(Pending::Open { call: Some(_), .. }));
                    if !in_call {
                        return Err(self.lexer.unexpected(EXPECTED_OPERATOR));
                    }
                    self.lexer.advance()?;
                    return Ok(true);
                }
                Token::End => {
                    self.reduce(1);
                    self.no_branch_is_missing()?;
                    return if self.pending.is_empty() {
                        Ok(false)
                    } else {
                        Err(self.unclosed_or(EXPECTED_OPERATOR))
                    };
                }
                _ => return Err(self.lexer.unexpected(EXPECTED_OPERATOR)),
            };
            // Powers wait for their right side, all others bind to the left first.
            let pending = Pending::Binary(operator, self.lexer.span.clone());
            let is_power = operator == BinaryOperator::Power;
            self.reduce(strength(&pending) + u8::from(is_power));
            self.pending.push(pending);
            self.lexer.advance()?;
            return Ok(true);
        }
    }

    /// A comparison, `and` or `or` where an operator must stand.
    fn connective(&self) -> Option<Pending> {
        let span = self.lexer.span.clone();
        match (&self.lexer.token, self.lexer.slice()) {
            (Token::Comparison(function), _) => Some(Pending::Comparison(function, span)),
            (Token::Name, "and") => Some(Pending::And(span)),
            (Token::Name, "or") => Some(Pending::Or(span)),
            _ => None,
        }
    }

    /// True of a word that no unit and no operand is: what comes before it is complete.
    fn is_word(&self) -> bool {
        ["and", "or", "then", "else"].contains(&self.lexer.slice())
    }

    fn push(&mut self, kind: SyntaxKind, span: Range<usize>) {
        self.operands.push((self.nodes.len(), span.clone()));
        self.nodes.push(SyntaxNode { kind, span });
    }

    fn open(&mut self, span: Range<usize>, call: Option<Call>) -> Result<(), ParseError> {
        self.depth += 1;
        let limit = self.options.max_depth;
        if self.depth > limit {
            return Err(error(ParseErrorKind::TooDeep { limit }, span));
        }
        self.pending.push(Pending::Open { span, call });
        Ok(())
    }

    /// Closes the innermost parenthesis, on top of the stack after reducing.
    fn close(&mut self, end: &Range<usize>) -> Result<(), ParseError> {
        let Some(Pending::Open { span, call }) = self.pending.pop() else {
            return Err(error(ParseErrorKind::UnopenedParenthesis, end.clone()));
        };
        self.depth -= 1;
        if let Some(Call { name, name_span, floor }) = call {
            // `if (a > b) and c > d then …`: the parentheses of a condition, not of a call.
            if name == "if" && self.operands.len() == floor + 1 {
                self.operands[floor].1 = span.start..end.end;
                return self.begin_if(name_span);
            }
            let arguments = self.operands.drain(floor..).map(|operand| operand.0).collect();
            let whole = name_span.start..end.end;
            self.push(SyntaxKind::Call { name, name_span, arguments }, whole);
        } else {
            let inside = self.operands.last_mut();
            inside.expect("an operand was read before `)`").1 = span.start..end.end;
        }
        Ok(())
    }

    /// Raises the operand before to a power in raised digits, which binds tighter than anything.
    fn raise(&mut self, exponent: i32) -> Result<(), ParseError> {
        let operator_span = self.lexer.advance()?;
        let (left, left_span) = self.take_operand();
        let (right, end) = (self.nodes.len(), operator_span.end);
        let kind = SyntaxKind::Number(Number::from(i64::from(exponent)));
        self.nodes.push(SyntaxNode { kind, span: operator_span.clone() });
        let operator = BinaryOperator::Power;
        let kind = SyntaxKind::Binary { operator, operator_span, left, right };
        self.push(kind, left_span.start..end);
        Ok(())
    }

    /// The operand of an operator, which is read before the operator is applied.
    fn take_operand(&mut self) -> (usize, Range<usize>) {
        self.operands.pop().expect("an operator is applied after its operands are read")
    }

    /// Applies the waiting operators that hold at least as tightly as `least`.
    fn reduce(&mut self, least: u8) {
        while self.pending.last().is_some_and(|top| strength(top) >= least) {
            self.apply();
        }
    }

    /// Applies the last waiting operator to its operands.
    fn apply(&mut self) {
        let top = self.pending.pop().expect("the caller has looked at it");
        let (right, right_span) = self.take_operand();
        match top {
            Pending::Negate(sign) => {
                self.push(SyntaxKind::Negate(right), sign.start..right_span.end);
            }
            Pending::Binary(operator, operator_span) => {
                let (left, left_span) = self.take_operand();
                let kind = SyntaxKind::Binary { operator, operator_span, left, right };
                self.push(kind, left_span.start..right_span.end);
            }
            Pending::Comparison(function, name_span) => {
                self.push_call(function, name_span, (right, right_span.end));
            }
            Pending::Or(span) => self.push_call("max", span, (right, right_span.end)),
            Pending::And(operator_span) => {
                let (left, left_span) = self.take_operand();
                let operator = BinaryOperator::Multiply;
                let kind = SyntaxKind::Binary { operator, operator_span, left, right };
                self.push(kind, left_span.start..right_span.end);
            }
            Pending::Not(sign) => {
                let (operator, left) = (BinaryOperator::Subtract, self.nodes.len());
                let kind = SyntaxKind::Number(Number::from(1));
                self.nodes.push(SyntaxNode { kind, span: sign.clone() });
                let whole = sign.start..right_span.end;
                let kind = SyntaxKind::Binary { operator, operator_span: sign, left, right };
                self.push(kind, whole);
            }
            Pending::Else(name_span) => self.push_branches(name_span, (right, right_span.end)),
            Pending::Open { .. } | Pending::If(_) | Pending::Then(_) => {
                unreachable!("these hold less tightly than anything")
            }
        }
    }

    /// A function of the operand before and of `right`, which ends at `end`.
    fn push_call(&mut self, function: &str, name_span: Range<usize>, (right, end): (usize, usize)) {
        let (left, left_span) = self.take_operand();
        let (name, arguments) = (function.to_owned(), vec![left, right]);
        let kind = SyntaxKind::Call { name, name_span, arguments };
        self.push(kind, left_span.start..end);
    }

    /// The fault at the end of the text: the innermost open parenthesis, or the missing part.
    fn unclosed_or(&self, expected: &'static str) -> ParseError {
        let is_dangling = !matches!(self.pending.last(), None | Some(Pending::Open { .. }));
        let open = self.pending.iter().rev().find_map(|pending| match pending {
            Pending::Open { span, .. } => Some(span.clone()),
            _ => None,
        });
        match open {
            Some(span) if !is_dangling => error(ParseErrorKind::UnclosedParenthesis, span),
            _ => self.lexer.unexpected(expected),
        }
    }

    /// The fault of a sign in place of an operand; `)` is named as such when it has a partner.
    fn unexpected_operand(&self) -> ParseError {
        if self.lexer.token == Token::Sign(')') && self.depth > 0 {
            let found = ")".to_owned();
            let kind = ParseErrorKind::UnexpectedToken { found, expected: EXPECTED_OPERAND };
            return error(kind, self.lexer.span.clone());
        }
        self.lexer.unexpected(EXPECTED_OPERAND)
    }
}
