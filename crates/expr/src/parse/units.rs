//! Units after numbers and other operands.

use super::{Parser, Pending};
use crate::lexer::{Token, is_name_start, name_length};
use crate::number::Number;
use crate::syntax::{BinaryOperator, ParseError, ParseErrorKind, SyntaxKind, UnitFactor, error};
use std::ops::Range;

/// The end of a unit.
fn end_of(factors: &[UnitFactor]) -> usize {
    factors.last().expect("a unit has at least one factor").span.end
}

impl Parser<'_, '_> {
    /// A number and the unit that follows it.
    pub(super) fn number(&mut self, value: Number) -> Result<(), ParseError> {
        let value_span = self.lexer.advance()?;
        // The unit after a power is that of the power: `x^2 m`.
        let is_plain = self.lexer.token != Token::Name || self.is_word() || self.is_exponent();
        if is_plain {
            self.push(SyntaxKind::Number(value), value_span);
            return Ok(());
        }
        let name = self.lexer.slice();
        if !(self.options.is_unit)(name) {
            let kind = ParseErrorKind::UnknownUnit { name: name.to_owned() };
            return Err(error(kind, self.lexer.span.clone()));
        }
        let factors = self.unit()?;
        let whole = value_span.start..end_of(&factors);
        self.push(SyntaxKind::Quantity { value, value_span, factors }, whole);
        Ok(())
    }

    /// True where a unit follows an operand that is no number. A name of the model is none here: between
    /// the two a sign is missing.
    pub(super) fn starts_unit(&self) -> bool {
        let name = self.lexer.slice();
        self.may_go_on(name, self.lexer.span.end) && !(self.options.is_name)(name)
    }

    /// Gives the operand before, with its power, the unit that follows.
    pub(super) fn unit_after_operand(&mut self) -> Result<(), ParseError> {
        while self.is_exponent() {
            self.apply();
        }
        let (operand, operand_span) = self.take_operand();
        let factors = self.unit()?;
        let whole = operand_span.start..end_of(&factors);
        self.push(SyntaxKind::Unit { operand, factors }, whole);
        Ok(())
    }

    /// True of a unit that is a factor or divisor by itself: the second of `t/s`.
    pub(super) fn is_unit_of_product(&self, name: &str) -> bool {
        let is_product = matches!(
            self.pending.last(),
            Some(Pending::Binary(BinaryOperator::Multiply | BinaryOperator::Divide, _))
        );
        let options = self.options;
        let is_free = !(options.is_name)(name) && !(options.is_variable)(name);
        is_product && is_free && (options.is_unit)(name)
    }

    /// One of a unit, whose name was read. What is written after it is not of it: `x/N*m` is `(x/N)*m`.
    pub(super) fn unit_alone(
        &mut self,
        name: String,
        name_span: Range<usize>,
    ) -> Result<(), ParseError> {
        let value_span = name_span.start..name_span.start;
        let factors = vec![self.exponent_of(name, name_span, 1)?];
        let whole = value_span.start..end_of(&factors);
        self.push(SyntaxKind::Quantity { value: Number::from(1), value_span, factors }, whole);
        Ok(())
    }

    /// True where the operand before is an exponent, with or without minus.
    fn is_exponent(&self) -> bool {
        let mut waiting = self.pending.iter().rev();
        let is_sign = |pending: &&Pending| matches!(pending, Pending::Negate(_));
        let before = waiting.find(|pending| !is_sign(pending));
        matches!(before, Some(Pending::Binary(BinaryOperator::Power, _)))
    }

    /// The factors of a unit that begins here.
    fn unit(&mut self) -> Result<Vec<UnitFactor>, ParseError> {
        let mut factors = Vec::new();
        let mut sign = 1;
        loop {
            let name = self.lexer.slice().to_owned();
            let span = self.lexer.advance()?;
            factors.push(self.exponent_of(name, span, sign)?);
            let Some((next, has_sign)) = self.unit_continues() else { return Ok(factors) };
            if has_sign {
                self.lexer.advance()?;
            }
            sign = next;
        }
    }

    /// The sign of the next factor's exponent where another unit follows, and whether `*` or `/` is before it.
    fn unit_continues(&self) -> Option<(i32, bool)> {
        let sign = match self.lexer.token {
            Token::Sign('*') => 1,
            Token::Sign('/') => -1,
            Token::Name => {
                let goes_on = self.may_go_on(self.lexer.slice(), self.lexer.span.end);
                return goes_on.then_some((1, false));
            }
            _ => return None,
        };
        let rest = self.lexer.text[self.lexer.span.end..].trim_start();
        let name = &rest[..name_length(rest)];
        let end = self.lexer.text.len() - rest.len() + name.len();
        let goes_on = name.starts_with(is_name_start) && self.may_go_on(name, end);
        // After a written `*` a name of the model comes first.
        let is_name = sign == 1 && (self.options.is_name)(name);
        (goes_on && !is_name).then_some((sign, true))
    }

    /// True of the name of a unit that ends at a byte, is no variable and is not called.
    fn may_go_on(&self, name: &str, end: usize) -> bool {
        let is_call = self.lexer.text[end..].trim_start().starts_with('(');
        !is_call && (self.options.is_unit)(name) && !(self.options.is_variable)(name)
    }

    /// A unit with, if an integer follows, its exponent.
    fn exponent_of(
        &mut self,
        name: String,
        mut span: Range<usize>,
        sign: i32,
    ) -> Result<UnitFactor, ParseError> {
        let mut exponent = sign;
        if let Token::Raised(power) = self.lexer.token {
            exponent = sign.saturating_mul(power);
            span.end = self.lexer.advance()?.end;
        }
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
}
