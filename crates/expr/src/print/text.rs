//! Infix text that this crate and others can parse; functions with names must be known to the pool.

use super::mark::{FunctionName, Mark, MarkPart, SymbolNames};

/// Appends a mark as text.
pub(super) fn write(mark: &Mark, names: &SymbolNames<'_>, out: &mut String) {
    match *mark {
        Mark::Number(ref n) => out.push_str(&n.to_string()),
        Mark::Pi => out.push_str("pi"),
        Mark::Symbol(symbol) => out.push_str(&names.of(symbol)),
        Mark::RaisedSymbol(symbol, n) => out.extend([&names.of(symbol), "^", &n.to_string()]),
        Mark::Plus => out.push_str(" + "),
        Mark::Minus => out.push_str(" - "),
        Mark::Sign => out.push('-'),
        Mark::Times => out.push('*'),
        Mark::Over => out.push('/'),
        Mark::Power(MarkPart::Middle) => out.push('^'),
        Mark::Raised(n) => out.extend(["^", &n.to_string()]),
        Mark::Parenthesis(MarkPart::Start, _) | Mark::Arguments(MarkPart::Start, _) => {
            out.push('(');
        }
        Mark::Parenthesis(MarkPart::End, _) | Mark::Arguments(MarkPart::End, _) => out.push(')'),
        Mark::Arguments(MarkPart::Middle, _) => out.push_str(", "),
        Mark::Function(function, _) => out.push_str(function.name()),
        Mark::Named(function) => {
            let FunctionName { name, primes, by } = names.of_function(function);
            out.extend([name, primes]);
            out.extend(by.into_iter().flat_map(|variable| ["_".to_owned(), variable]));
        }
        Mark::Power(_) => (),
        Mark::Fraction(_)
        | Mark::Root(_)
        | Mark::Absolute(_)
        | Mark::Parenthesis(MarkPart::Middle, _)
        | Mark::Apply
        | Mark::Cases(_)
        | Mark::Otherwise
        | Mark::Relation(_)
        | Mark::NotZero
        | Mark::Truth(_) => unreachable!("no {mark:?} within the line"),
    }
}
