//! The text notation with the letters that a terminal has: `½·m·ẋ₂²` instead of `0.5*m*x2_dot^2`.

use super::mark::{FunctionName, Mark, MarkPart, SymbolNames};
use super::name::{Name, Word};
use super::text;

/// One and two dots above the letter before.
const DOTS: [char; 2] = ['\u{307}', '\u{308}'];
const SUBSCRIPTS: [char; 10] = ['₀', '₁', '₂', '₃', '₄', '₅', '₆', '₇', '₈', '₉'];
const SUPERSCRIPTS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

/// Appends a mark as text with Unicode letters.
pub(super) fn write(mark: &Mark, names: &SymbolNames<'_>, out: &mut String) {
    match *mark {
        Mark::Pi => out.push('π'),
        Mark::Symbol(symbol) => out.push_str(&name(&names.of(symbol))),
        Mark::RaisedSymbol(symbol, n) => {
            out.push_str(&name(&names.of(symbol)));
            out.push_str(&in_digits(&n.to_string(), &SUPERSCRIPTS));
        }
        Mark::Minus => out.push_str(" − "),
        Mark::Sign => out.push('−'),
        Mark::Times => out.push('·'),
        Mark::Raised(n) => out.push_str(&in_digits(&n.to_string(), &SUPERSCRIPTS)),
        Mark::Root(MarkPart::Start) => out.push_str("√("),
        Mark::Root(_) => out.push(')'),
        Mark::Absolute(_) => out.push('|'),
        Mark::Named(function) => {
            let FunctionName { name: text, primes, by } = names.of_function(function);
            out.extend([name(&text), primes.replace('\'', "′")]);
            out.extend(by.iter().flat_map(|variable| ["_".to_owned(), name(variable)]));
        }
        _ => text::write(mark, names, out),
    }
}

/// An identifier; words stay words: `A_angle_dot` is `Ȧ_angle`.
pub(super) fn name(text: &str) -> String {
    let name = Name::of(text);
    let mut out = word(name.letter);
    if let Some(index) = name.n_dots.checked_sub(1) {
        // The dots go above the first letter of a word.
        let at = out.chars().next().map_or(0, char::len_utf8);
        out.insert(at, DOTS[index]);
    }
    for subscript in name.subscripts {
        if !matches!(subscript, Word::Digits(_)) {
            out.push('_');
        }
        out.push_str(&word(subscript));
    }
    out
}

fn word(word: Word<'_>) -> String {
    match word {
        Word::Greek(_, c) | Word::Letter(c) => c.to_string(),
        Word::Text(text) => text.to_owned(),
        Word::Digits(digits) => in_digits(digits, &SUBSCRIPTS),
    }
}

fn in_digits(text: &str, digits: &[char; 10]) -> String {
    text.chars().map(|c| c.to_digit(10).map_or(c, |d| digits[d as usize])).collect()
}

/// Columns that a text takes on a terminal: dots above letters take none.
pub(super) fn columns(text: &str) -> usize {
    text.chars().filter(|c| !DOTS.contains(c)).count()
}
