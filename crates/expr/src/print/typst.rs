//! Typst, for mathematics mode.

use super::mark::{
    FunctionName, Height, Mark, MarkPart, SymbolNames, digits, function_name, relation,
};
use super::name::{Name, Word};
use crate::op::Function;

/// Functions that Typst knows by name; the others are set by `op`.
const OPERATORS: [&str; 13] = [
    "sin", "cos", "tan", "arcsin", "arccos", "arctan", "sinh", "cosh", "tanh", "exp", "ln", "min",
    "max",
];

/// Between the arguments of a function of Typst.
const COMMA: &str = ", ";

/// Appends a mark as Typst.
pub(super) fn write(mark: &Mark, names: &SymbolNames<'_>, out: &mut String) {
    let fixed = match *mark {
        // Marks with a number or a name in them.
        Mark::Number(ref n) => {
            let (mantissa, exponent) = digits(n);
            out.push_str(&mantissa);
            if let Some(exponent) = exponent {
                out.extend([" dot 10^(", &exponent, ")"]);
            }
            return;
        }
        Mark::Symbol(symbol) => return out.push_str(&name(&names.of(symbol))),
        Mark::RaisedSymbol(symbol, n) => {
            return out.extend([name(&names.of(symbol)), raised(n)]);
        }
        Mark::Raised(n) => return out.push_str(&raised(n)),
        Mark::Function(function, power) => {
            out.push_str(&operator(function));
            if power != 1 {
                out.push_str(&raised(power));
            }
            return;
        }
        Mark::Named(function) => {
            let FunctionName { name: text, primes, by } = names.of_function(function);
            let by = by.iter().map(|variable| name(variable)).collect::<Vec<_>>().join(" ");
            if !by.is_empty() {
                out.extend(["diff_(", &by, ") "]);
            }
            return out.extend([name(&text), primes]);
        }
        Mark::Relation(function) => match relation(function) {
            Some('≤') => " <= ",
            Some('≥') => " >= ",
            Some('>') => " > ",
            _ => " < ",
        },
        // Signs.
        Mark::Pi => "pi",
        Mark::Plus => " + ",
        Mark::Minus => " - ",
        Mark::Sign => "-",
        Mark::Times => " thin ",
        Mark::Over => r"\/",
        // Fractions, powers, roots, bars and parentheses around others.
        Mark::Fraction(MarkPart::Start) => "frac(",
        Mark::Fraction(MarkPart::Middle) | Mark::Otherwise => COMMA,
        Mark::Power(MarkPart::Start) => "",
        Mark::Power(MarkPart::Middle) => "^(",
        Mark::Root(MarkPart::Start) => "sqrt(",
        Mark::Absolute(MarkPart::Start) => "abs(",
        Mark::Fraction(_) | Mark::Power(_) | Mark::Root(_) | Mark::Absolute(_) => ")",
        Mark::Parenthesis(part, height) | Mark::Arguments(part, height) => match (part, height) {
            (MarkPart::Start, Height::Split) => r"\(",
            (MarkPart::End, Height::Split) => r"\)",
            (MarkPart::Start, _) => "(",
            (MarkPart::Middle, _) => COMMA,
            (MarkPart::End, _) => ")",
        },
        // Functions and conditions.
        Mark::Apply => " ",
        Mark::Cases(MarkPart::Start) => "cases(",
        Mark::Cases(MarkPart::Middle) => r#" & "if " "#,
        Mark::Cases(MarkPart::End) => r#" & "otherwise")"#,
        Mark::NotZero => " != 0",
        Mark::Truth(MarkPart::Start) => "[",
        Mark::Truth(_) => "]",
    };
    out.push_str(fixed);
}

fn raised(power: u64) -> String {
    format!("^({power})")
}

fn operator(function: Function) -> String {
    let name = function_name(function);
    if OPERATORS.contains(&name) { name.to_owned() } else { format!(r#"op("{name}")"#) }
}

/// `x2_dot` becomes `dot(x)_(2)`, `theta1` `theta_(1)`, `crank.x` `x_("crank")`.
pub(super) fn name(text: &str) -> String {
    let name = Name::of(text);
    let letter = word(name.letter);
    let letter = match name.n_dots {
        0 => letter,
        1 => format!("dot({letter})"),
        _ => format!("dot.double({letter})"),
    };
    if name.subscripts.is_empty() {
        return letter;
    }
    let subscripts: Vec<String> = name.subscripts.into_iter().map(word).collect();
    format!("{letter}_({})", subscripts.join(", "))
}

fn word(word: Word<'_>) -> String {
    match word {
        Word::Greek(name, _) => name.to_owned(),
        Word::Letter(c) => c.to_string(),
        Word::Text(text) => format!("\"{text}\""),
        Word::Digits(digits) => digits.to_owned(),
    }
}
