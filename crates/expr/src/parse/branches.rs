//! `if c then a else b`: the call `if(c, a, b)` in words. It counts as a level of parentheses.

use super::{Parser, Pending};
use crate::syntax::{ParseError, ParseErrorKind, SyntaxKind, error};
use std::ops::Range;

impl Parser<'_, '_> {
    /// Opens a condition; `span` is that of `if`.
    pub(super) fn begin_if(&mut self, span: Range<usize>) -> Result<(), ParseError> {
        self.depth += 1;
        let limit = self.options.max_depth;
        if self.depth > limit {
            return Err(error(ParseErrorKind::TooDeep { limit }, span));
        }
        self.pending.push(Pending::If(span));
        Ok(())
    }

    /// Reads `then` or `else` where an operator may stand.
    pub(super) fn branch(&mut self) -> Result<(), ParseError> {
        self.reduce(1);
        let next = match (self.lexer.slice(), self.pending.last()) {
            ("then", Some(Pending::If(span))) => Pending::Then(span.clone()),
            ("else", Some(Pending::Then(span))) => Pending::Else(span.clone()),
            _ => {
                self.no_branch_is_missing()?;
                return Err(self.lexer.unexpected(super::EXPECTED_OPERATOR));
            }
        };
        self.pending.pop();
        self.pending.push(next);
        self.lexer.advance()?;
        Ok(())
    }

    /// The fault where an `if` lacks its `then` or `else` and the text ends or goes on outside of it.
    pub(super) fn no_branch_is_missing(&self) -> Result<(), ParseError> {
        let expected = match self.pending.last() {
            Some(Pending::If(_)) => "`then`",
            Some(Pending::Then(_)) => "`else`",
            _ => return Ok(()),
        };
        Err(match self.lexer.unexpected(expected) {
            ParseError { kind: ParseErrorKind::UnopenedParenthesis, span } => {
                let found = self.lexer.slice().to_owned();
                error(ParseErrorKind::UnexpectedToken { found, expected }, span)
            }
            fault => fault,
        })
    }

    /// A call of `if` with the two operands before and the last, which ends at a byte.
    pub(super) fn push_branches(&mut self, name_span: Range<usize>, last: (usize, usize)) {
        self.depth -= 1;
        let (then, _) = self.take_operand();
        let (condition, _) = self.take_operand();
        let whole = name_span.start..last.1;
        let arguments = vec![condition, then, last.0];
        self.push(SyntaxKind::Call { name: "if".to_owned(), name_span, arguments }, whole);
    }
}
