//! Marks of word processors and of other languages: typographic quotes, and commas in decimals.

use super::codes;
use super::token::token_length;
use crate::diagnostic::{Diagnostic, Span};

/// Quotes of word processors: of texts, and of texts within texts.
const QUOTES: [char; 12] = ['“', '”', '„', '‟', '«', '»', '‘', '’', '‚', '‛', '‹', '›'];

/// More texts in such quotes than this are not looked up.
const MAX_QUOTED: usize = 20;

/// True of a quote that is not a straight one.
pub(super) fn is_typographic(c: char) -> bool {
    QUOTES.contains(&c)
}

/// Texts of the file that stand between typographic quotes, or between one and a straight one.
pub(super) fn typographic_quotes(text: &str) -> Vec<Diagnostic> {
    let mut faults = Vec::new();
    let mut at = 0;
    let is_mark = |c| is_typographic(c) || matches!(c, '"' | '\'' | '#');
    while let Some(next) = text[at..].find(is_mark) {
        let start = at + next;
        let tail = &text[start..];
        let Some(first) = tail.chars().next() else { break };
        let length = if is_typographic(first) { 0 } else { token_length(tail) };
        let is_closed = length > 1 && tail[..length].ends_with(first);
        if first == '#' || is_closed {
            at = start + length.max(1);
            continue;
        }
        let line = tail.lines().next().unwrap_or_default();
        let inside = &line[first.len_utf8()..];
        let is_end = |c| is_typographic(c) || is_typographic(first) && c == '"';
        let Some(end) = inside.find(is_end) else {
            at = start + line.len();
            continue;
        };
        let closing = inside[end..].chars().next().map_or(0, char::len_utf8);
        let stop = start + first.len_utf8() + end + closing;
        faults.push(
            Diagnostic::error(codes::SYNTAX, "typographic quotes around a text")
                .at(start..stop, "its quotes are those of a word processor")
                .help(format!("write \"{}\"", &inside[..end])),
        );
        if faults.len() == MAX_QUOTED {
            break;
        }
        at = stop;
    }
    faults
}

/// A value of this line of the file that is a number with a comma, `0,5`, and may have a unit.
pub(super) fn decimal_comma(text: &str, line: Span) -> Option<Diagnostic> {
    let whole = &text[line.clone()];
    let (place, number, rest) = whole.match_indices('=').find_map(|(equals, _)| {
        let after = &whole[equals + 1..];
        let value = after.trim_start();
        let number = number_with_comma(value)?;
        Some((line.start + equals + 1 + after.len() - value.len(), number, &value[number.len()..]))
    })?;
    let unit = rest[..rest.find([',', '}', ']', '#']).unwrap_or(rest.len())].trim_end();
    let point = number.replace(',', ".");
    let written = if unit.is_empty() { point } else { format!("\"{point}{unit}\"") };
    Some(
        Diagnostic::error(codes::SYNTAX, "a comma in a number")
            .at(place..place + number.len() + unit.len(), "decimals have a point")
            .help(format!("write {written}")),
    )
}

/// The number at the start of a value whose decimals follow a comma.
fn number_with_comma(value: &str) -> Option<&str> {
    let digits = |from: usize| value[from..].bytes().take_while(u8::is_ascii_digit).count();
    let sign = usize::from(value.starts_with(['+', '-']));
    let comma = sign + digits(sign);
    let end = comma + 1;
    let is_one = comma > sign && value[comma..].starts_with(',') && digits(end) > 0;
    let end = if is_one { end + digits(end) } else { return None };
    // Several are entries of something, or thousands.
    let is_list =
        value[end..].trim_start_matches([',', '.', ' ']).starts_with(|c: char| c.is_ascii_digit());
    (!is_list).then_some(&value[..end])
}

/// An expression with a point for every comma between digits; none where there is no such comma, or one whose
/// digits have a point already.
pub(super) fn with_points(expression: &str) -> Option<String> {
    let is_digit = |at: usize| expression.as_bytes().get(at).is_some_and(u8::is_ascii_digit);
    let mut written = expression.to_owned();
    for (at, _) in expression.match_indices(',') {
        let is_decimal = at > 0 && is_digit(at - 1) && is_digit(at + 1);
        let whole = expression[..at].trim_end_matches(|c: char| c.is_ascii_digit());
        if is_decimal && !whole.ends_with(['.', ',']) {
            written.replace_range(at..=at, ".");
        }
    }
    (written != expression).then_some(written)
}
