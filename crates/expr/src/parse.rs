//! Text to syntax tree, by operator precedence on an explicit stack.
//!
//! ```text
//! sum      + −   left to right        power    ^   right to left, binds tighter than minus
//! product  * /   left to right        minus    −a^b is −(a^b), and a^−b is allowed
//! compare  < <= > >=   weakest: 1 where it holds, 0 where not, as the functions lt, le, gt, ge
//! ```

use crate::lexer::{Lexer, Token, is_name_start, name_length};
use crate::number::Number;
use crate::syntax::{
    BinaryOperator, ParseError, ParseErrorKind, Syntax, SyntaxKind, SyntaxNode, UnitFactor, error,
};
use std::ops::Range;

/// Options of reading text.
#[derive(Clone, Copy)]
pub struct ParseOptions<'a> {
    /// How deep parentheses may nest; default 64.
    pub max_depth: usize,
    /// Whether an identifier is a unit; default: none is, so no number may carry one.
    pub is_unit: &'a dyn Fn(&str) -> bool,
    /// Whether an identifier is a name of the model, which wins over a unit after `*` and `/`;
    /// default: none is.
    pub is_name: &'a dyn Fn(&str) -> bool,
}

impl Default for ParseOptions<'_> {
    fn default() -> Self {
        Self { max_depth: 64, is_unit: &|_| false, is_name: &|_| false }
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
        Pending::Open { .. } => 0,
        Pending::Or(_) => 1,
        Pending::And(_) => 2,
        Pending::Not(_) => 3,
        Pending::Comparison(..) => 4,
        Pending::Binary(BinaryOperator::Add | BinaryOperator::Subtract, _) => 5,
        Pending::Binary(BinaryOperator::Multiply | BinaryOperator::Divide, _) => 6,
        Pending::Negate(_) => 7,
        Pending::Binary(BinaryOperator::Power, _) => 8,
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
                Token::Name if self.lexer.slice() == "not" && !(self.options.is_name)("not") => {
                    let span = self.lexer.advance()?;
                    self.pending.push(Pending::Not(span));
                }
                Token::Name => {
                    let name = self.lexer.slice().to_owned();
                    let name_span = self.lexer.advance()?;
                    if self.lexer.token != Token::Sign('(') {
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
                Token::Sign(_) | Token::Comparison(_) => return Err(self.unexpected_operand()),
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
                Token::Sign(')') => {
                    self.reduce(1);
                    let end = self.lexer.span.clone();
                    self.close(&end)?;
                    self.lexer.advance()?;
                    continue;
                }
                Token::Sign(',') => {
                    self.reduce(1);
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
            let arguments = self.operands.drain(floor..).map(|operand| operand.0).collect();
            let whole = name_span.start..end.end;
            self.push(SyntaxKind::Call { name, name_span, arguments }, whole);
        } else {
            let inside = self.operands.last_mut();
            inside.expect("an operand was read before `)`").1 = span.start..end.end;
        }
        Ok(())
    }

    /// The operand of an operator, which is read before the operator is applied.
    fn take_operand(&mut self) -> (usize, Range<usize>) {
        self.operands.pop().expect("an operator is applied after its operands are read")
    }

    /// Applies the waiting operators that hold at least as tightly as `least`.
    fn reduce(&mut self, least: u8) {
        while self.pending.last().is_some_and(|top| strength(top) >= least) {
            let top = self.pending.pop().expect("it was just looked at");
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
                Pending::Open { .. } => unreachable!("parentheses hold less tightly than anything"),
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

    /// A number and the unit that follows it.
    fn number(&mut self, value: Number) -> Result<(), ParseError> {
        let value_span = self.lexer.advance()?;
        if self.lexer.token != Token::Name || self.connective().is_some() {
            self.push(SyntaxKind::Number(value), value_span);
            return Ok(());
        }
        let name = self.lexer.slice();
        if !(self.options.is_unit)(name) {
            let kind = ParseErrorKind::UnknownUnit { name: name.to_owned() };
            return Err(error(kind, self.lexer.span.clone()));
        }
        let mut factors = vec![self.unit_factor(1)?];
        while let Some(sign) = self.unit_continues() {
            self.lexer.advance()?;
            factors.push(self.unit_factor(sign)?);
        }
        let last = factors.last().expect("a unit has at least one factor");
        let whole = value_span.start..last.span.end;
        self.push(SyntaxKind::Quantity { value, value_span, factors }, whole);
        Ok(())
    }

    /// Whether `*` or `/` and another unit follow; gives the sign of its exponent.
    fn unit_continues(&self) -> Option<i32> {
        let sign = match self.lexer.token {
            Token::Sign('*') => 1,
            Token::Sign('/') => -1,
            _ => return None,
        };
        let rest = self.lexer.text[self.lexer.span.end..].trim_start();
        let name = &rest[..name_length(rest)];
        let starts_name = name.starts_with(is_name_start);
        let is_call = rest[name.len()..].trim_start().starts_with('(');
        let is_unit = starts_name && !is_call && (self.options.is_unit)(name);
        (is_unit && !(self.options.is_name)(name)).then_some(sign)
    }

    /// A unit's name and, if an integer follows, its exponent.
    fn unit_factor(&mut self, sign: i32) -> Result<UnitFactor, ParseError> {
        let name = self.lexer.slice().to_owned();
        let mut span = self.lexer.advance()?;
        let mut exponent = sign;
        if self.lexer.token == Token::Sign('^') {
            self.lexer.advance()?;
            let is_negative = self.lexer.token == Token::Sign('-');
            if is_negative {
                self.lexer.advance()?;
            }
            let expected = "an integer exponent of the unit";
            let Token::Number(power) = &self.lexer.token else {
                return Err(self.lexer.unexpected(expected));
            };
            let power = power.as_integer().and_then(|n| i32::try_from(n).ok());
            let power = power.ok_or_else(|| self.lexer.unexpected(expected))?;
            exponent = if is_negative { -sign * power } else { sign * power };
            span.end = self.lexer.advance()?.end;
        }
        Ok(UnitFactor { name, span, exponent })
    }

    /// The fault at the end of the text: the innermost open parenthesis, or the missing part.
    fn unclosed_or(&self, expected: &'static str) -> ParseError {
        let is_dangling =
            matches!(self.pending.last(), Some(Pending::Binary(..) | Pending::Negate(_)));
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
