//! Text to tokens, one at a time, with byte spans.

use crate::number::{MAX_DIGITS, Number};
use crate::syntax::{ParseError, ParseErrorKind, error};
use std::ops::Range;

/// One token of a text.
#[derive(Clone, PartialEq, Debug)]
pub(crate) enum Token {
    Number(Number),
    Name,
    Sign(char),
    /// A comparison sign, as the name of its function: `<` is `lt`.
    Comparison(&'static str),
    /// An exponent in raised digits: `²`, `⁻¹`.
    Raised(i32),
    End,
}

/// Splits text into tokens on demand; `span` covers the current one.
pub(crate) struct Lexer<'t> {
    pub(crate) text: &'t str,
    pub(crate) token: Token,
    pub(crate) span: Range<usize>,
}

impl<'t> Lexer<'t> {
    pub(crate) fn new(text: &'t str) -> Result<Self, ParseError> {
        let mut lexer = Self { text, token: Token::End, span: 0..0 };
        lexer.advance()?;
        Ok(lexer)
    }

    pub(crate) fn slice(&self) -> &'t str {
        &self.text[self.span.clone()]
    }

    /// Moves to the next token and returns the span of the one before.
    pub(crate) fn advance(&mut self) -> Result<Range<usize>, ParseError> {
        let left = self.span.clone();
        let rest = self.text[self.span.end..].trim_start();
        let start = self.text.len() - rest.len();
        let Some(first) = rest.chars().next() else {
            (self.token, self.span) = (Token::End, start..start);
            return Ok(left);
        };
        let (token, length) = match first {
            '0'..='9' | '.' => {
                let length = number_length(rest);
                let span = start..start + length;
                let found = &rest[..length];
                let fault = || {
                    if Number::is_literal(found) {
                        ParseErrorKind::NumberTooLong { limit: MAX_DIGITS }
                    } else {
                        ParseErrorKind::BadNumber { found: found.to_owned() }
                    }
                };
                let number = Number::parse(found).ok_or_else(|| error(fault(), span))?;
                (Token::Number(number), length)
            }
            '*' if rest.starts_with("**") => (Token::Sign('^'), 2),
            '+' | '-' | '*' | '/' | '^' | '(' | ')' | ',' => (Token::Sign(first), 1),
            // The signs of books.
            '·' | '⋅' | '×' => (Token::Sign('*'), first.len_utf8()),
            '−' => (Token::Sign('-'), first.len_utf8()),
            '≤' => (Token::Comparison("le"), first.len_utf8()),
            '≥' => (Token::Comparison("ge"), first.len_utf8()),
            c if raised_digit(c).is_some() || c == '⁻' => {
                let length = rest.find(|c| raised_digit(c).is_none() && c != '⁻');
                let length = length.unwrap_or(rest.len());
                let exponent = raised(&rest[..length]).ok_or_else(|| {
                    let found = rest[..length].to_owned();
                    error(ParseErrorKind::BadNumber { found }, start..start + length)
                })?;
                (Token::Raised(exponent), length)
            }
            '<' if rest.starts_with("<=") => (Token::Comparison("le"), 2),
            '<' => (Token::Comparison("lt"), 1),
            '>' if rest.starts_with(">=") => (Token::Comparison("ge"), 2),
            '>' => (Token::Comparison("gt"), 1),
            c if is_name_start(c) => {
                let length = name_length(rest);
                (Token::Name, length + primes_length(&rest[length..]))
            }
            // A unit by itself.
            '°' => (Token::Name, first.len_utf8()),
            found => {
                let span = start..start + found.len_utf8();
                return Err(error(ParseErrorKind::UnexpectedCharacter { found }, span));
            }
        };
        (self.token, self.span) = (token, start..start + length);
        Ok(left)
    }

    pub(crate) fn unexpected(&self, expected: &'static str) -> ParseError {
        let kind = match self.token {
            Token::End => ParseErrorKind::UnexpectedEnd { expected },
            Token::Sign(')') => ParseErrorKind::UnopenedParenthesis,
            _ => ParseErrorKind::UnexpectedToken { found: self.slice().to_owned(), expected },
        };
        error(kind, self.span.clone())
    }
}

/// The value of a raised digit.
fn raised_digit(c: char) -> Option<i32> {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    (0..).zip(DIGITS).find_map(|(value, digit)| (digit == c).then_some(value))
}

/// The exponent of raised digits with or without a sign; `None` where it has no digits or too many.
fn raised(text: &str) -> Option<i32> {
    let (sign, digits) = text.strip_prefix('⁻').map_or((1, text), |digits| (-1, digits));
    let value = digits
        .chars()
        .try_fold(0_i32, |value, digit| value.checked_mul(10)?.checked_add(raised_digit(digit)?));
    value.filter(|_| !digits.is_empty()).map(|value| sign * value)
}

pub(crate) fn is_name_start(c: char) -> bool {
    c.is_alphabetic() || c == '_'
}

/// Bytes of the name at the start: letters, digits, underscores, and dots before a letter.
pub(crate) fn name_length(text: &str) -> usize {
    let mut chars = text.char_indices().peekable();
    while let Some((at, c)) = chars.next() {
        let joins = c == '.' && chars.peek().is_some_and(|&(_, next)| is_name_start(next));
        let is_letter = c.is_alphanumeric() && raised_digit(c).is_none();
        if !(is_letter || c == '_' || joins) {
            return at;
        }
    }
    text.len()
}

/// Bytes of the primes between the name of a function and its arguments.
fn primes_length(text: &str) -> usize {
    let length = text.len() - text.trim_start_matches('\'').len();
    if text[length..].starts_with('(') { length } else { 0 }
}

/// Bytes of the number at the start; digits and dots are taken together, so that `1.2.3` is one
/// bad number. An `e` belongs to it only if digits follow.
fn number_length(text: &str) -> usize {
    let digits =
        |from: usize| text[from..].bytes().take_while(|b| b.is_ascii_digit() || *b == b'.').count();
    let mantissa = digits(0);
    let mut exponent = text[mantissa..].bytes().peekable();
    if !matches!(exponent.next(), Some(b'e' | b'E')) {
        return mantissa;
    }
    let sign = usize::from(matches!(exponent.peek(), Some(b'+' | b'-')));
    let power = text[mantissa + 1 + sign..].bytes().take_while(u8::is_ascii_digit).count();
    if power == 0 { mantissa } else { mantissa + 1 + sign + power }
}
