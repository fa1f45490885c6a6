//! LaTeX, as it would be typeset in a paper.

use super::mark::{
    FunctionName, Height, Mark, MarkPart, SymbolNames, digits, function_name, relation,
};
use super::name::{Name, Word};
use crate::op::Function;

/// Functions with a LaTeX command; the others are set by `\operatorname`.
const COMMANDS: [&str; 13] = [
    "sin", "cos", "tan", "arcsin", "arccos", "arctan", "sinh", "cosh", "tanh", "exp", "ln", "min",
    "max",
];

/// Appends a mark as LaTeX.
pub(super) fn write(mark: &Mark, names: &SymbolNames<'_>, out: &mut String) {
    let fixed = match *mark {
        // Marks with a number or a name in them.
        Mark::Number(ref n) => {
            let (mantissa, exponent) = digits(n);
            out.push_str(&mantissa);
            if let Some(exponent) = exponent {
                out.extend([r" \cdot 10^{", &exponent, "}"]);
            }
            return;
        }
        Mark::Symbol(symbol) => return out.push_str(&name(&names.of(symbol))),
        Mark::RaisedSymbol(symbol, n) => {
            return out.extend([name(&names.of(symbol)), raised(n)]);
        }
        Mark::Raised(n) => return out.push_str(&raised(n)),
        Mark::Function(function, power) => {
            out.push_str(&command(function));
            if power != 1 {
                out.push_str(&raised(power));
            }
            return;
        }
        Mark::Named(function) => {
            let FunctionName { name: text, primes, by } = names.of_function(function);
            let by = by.iter().map(|variable| name(variable)).collect::<Vec<_>>().join(" ");
            if !by.is_empty() {
                out.extend([r"\partial_{", &by, "}"]);
            }
            return out.extend([name(&text), primes]);
        }
        Mark::Relation(function) => match relation(function) {
            Some('≤') => r" \le ",
            Some('≥') => r" \ge ",
            Some('>') => " > ",
            _ => " < ",
        },
        // Signs.
        Mark::Pi => r"\pi",
        Mark::Plus => " + ",
        Mark::Minus => " - ",
        Mark::Sign => "-",
        Mark::Times => r" \, ",
        Mark::Over => "/",
        // Fractions, powers, roots, bars and parentheses around others.
        Mark::Fraction(MarkPart::Start) => r"\frac{",
        Mark::Fraction(MarkPart::Middle) => "}{",
        Mark::Power(MarkPart::Start) => "",
        Mark::Power(MarkPart::Middle) => "^{",
        Mark::Root(MarkPart::Start) => r"\sqrt{",
        Mark::Fraction(_) | Mark::Power(_) | Mark::Root(_) => "}",
        Mark::Absolute(MarkPart::Start) => r"\left| ",
        Mark::Absolute(_) => r" \right|",
        Mark::Parenthesis(part, height) | Mark::Arguments(part, height) => match (part, height) {
            (MarkPart::Start, Height::Line) => "(",
            (MarkPart::Start, Height::Tall) => r"\left( ",
            (MarkPart::Start, Height::Split) => r"\bigl( ",
            (MarkPart::Middle, _) => ", ",
            (MarkPart::End, Height::Line) => ")",
            (MarkPart::End, Height::Tall) => r" \right)",
            (MarkPart::End, Height::Split) => r" \bigr)",
        },
        // Functions and conditions.
        Mark::Apply => " ",
        Mark::Cases(MarkPart::Start) => r"\begin{cases} ",
        Mark::Cases(MarkPart::Middle) => r" & \text{if } ",
        Mark::Cases(MarkPart::End) => r" & \text{otherwise} \end{cases}",
        Mark::Otherwise => r" \\ ",
        Mark::NotZero => r" \ne 0",
        Mark::Truth(MarkPart::Start) => "[",
        Mark::Truth(_) => "]",
    };
    out.push_str(fixed);
}

fn raised(power: u64) -> String {
    format!("^{{{power}}}")
}

fn command(function: Function) -> String {
    let name = function_name(function);
    if COMMANDS.contains(&name) { format!(r"\{name}") } else { format!(r"\operatorname{{{name}}}") }
}

/// `x2_dot` becomes `\dot{x}_{2}`, `theta1` `\theta_{1}`, `crank.x` `x_{\mathrm{crank}}`.
pub(super) fn name(text: &str) -> String {
    let name = Name::of(text);
    let letter = word(name.letter);
    let letter = match name.n_dots {
        0 => letter,
        1 => format!(r"\dot{{{letter}}}"),
        _ => format!(r"\ddot{{{letter}}}"),
    };
    if name.subscripts.is_empty() {
        return letter;
    }
    let subscripts: Vec<String> = name.subscripts.into_iter().map(word).collect();
    format!("{letter}_{{{}}}", subscripts.join(","))
}

fn word(word: Word<'_>) -> String {
    match word {
        Word::Greek(name, _) => format!(r"\{name}"),
        Word::Letter(c) if c.is_ascii() => c.to_string(),
        Word::Letter(c) => format!(r"\text{{{c}}}"),
        Word::Text(text) if text.is_ascii() => {
            format!(r"\mathrm{{{}}}", text.replace('_', r"\_"))
        }
        Word::Text(text) => format!(r"\text{{{}}}", text.replace('_', r"\_")),
        Word::Digits(digits) => digits.to_owned(),
    }
}
