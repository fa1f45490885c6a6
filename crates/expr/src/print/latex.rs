//! LaTeX, as it would be typeset in a paper.

use super::{Piece, Reader, Strength, Term, write};
use crate::number::Number;
use crate::op::{Function, Op};
use crate::pool::{Expr, Pool};

/// Functions with a LaTeX command; the others are set by `\operatorname`.
const COMMANDS: [Function; 14] = [
    Function::Sin,
    Function::Cos,
    Function::Tan,
    Function::Asin,
    Function::Acos,
    Function::Atan,
    Function::Sinh,
    Function::Cosh,
    Function::Tanh,
    Function::Exp,
    Function::Ln,
    Function::Min,
    Function::Max,
    Function::Sqrt,
];

/// Names of Greek letters that LaTeX sets as such.
const GREEK: [&str; 30] = [
    "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa",
    "lambda", "mu", "nu", "xi", "pi", "rho", "sigma", "tau", "phi", "chi", "psi", "omega", "Gamma",
    "Delta", "Theta", "Lambda", "Sigma", "Phi", "Psi", "Omega",
];

impl Pool {
    /// LaTeX source for mathematics mode.
    pub fn to_latex(&self, e: Expr) -> String {
        let reader = Reader::new(self, &[e]);
        write(vec![Piece::Expr(e, Strength::Sum)], |e, strength| expand(&reader, e, strength))
    }

    /// The terms joined by `+` and `-` in the given order; `0` when there are none.
    pub fn terms_to_latex(&self, terms: &[Expr]) -> String {
        if terms.is_empty() {
            return "0".to_owned();
        }
        let reader = Reader::new(self, terms);
        write(joined(&reader, &reader.in_line(terms)), |e, strength| expand(&reader, e, strength))
    }
}

fn expand(reader: &Reader<'_>, e: Expr, strength: Strength) -> Vec<Piece> {
    let pool = reader.pool;
    let node = pool.node(e);
    let sum = |e| Piece::Expr(e, Strength::Sum);
    let (own, pieces) = match node.op {
        Op::Number => {
            let n = pool.as_number(e).unwrap_or(Number::ZERO);
            let text = format!("{}{}", if n.is_negative() { "-" } else { "" }, number(n));
            (if n.is_negative() { Strength::Sum } else { Strength::Atom }, vec![Piece::Text(text)])
        }
        Op::Pi => (Strength::Atom, vec![r"\pi".into()]),
        Op::Symbol => {
            let name = pool.symbol_id(e).map(|symbol| pool.symbol_name(symbol));
            (Strength::Atom, vec![Piece::Text(identifier(&name.unwrap_or_default()))])
        }
        Op::Add => (Strength::Sum, joined(reader, &reader.ordered_terms(e))),
        Op::Mul => product(reader, e),
        Op::Pow => match pool.split_power(e) {
            (_, n) if n < 0 => product(reader, e),
            _ => {
                let base = Piece::Expr(node.left, Strength::Atom);
                (Strength::Power, vec![base, "^{".into(), sum(node.right), "}".into()])
            }
        },
        Op::Call(Function::Sqrt) => {
            (Strength::Atom, vec![r"\sqrt{".into(), sum(node.left), "}".into()])
        }
        Op::Call(Function::Abs) => {
            (Strength::Atom, vec![r"\left|".into(), sum(node.left), r"\right|".into()])
        }
        Op::Call(function) => (Strength::Atom, call(pool, function, e)),
        Op::Pair => (Strength::Atom, vec![sum(node.left), ", ".into(), sum(node.right)]),
    };
    if own >= strength {
        return pieces;
    }
    let mut wrapped = vec![r"\left( ".into()];
    wrapped.extend(pieces);
    wrapped.push(r" \right)".into());
    wrapped
}

fn call(pool: &Pool, function: Function, e: Expr) -> Vec<Piece> {
    let node = pool.node(e);
    let command = match function {
        Function::Asin => r"\arcsin".to_owned(),
        Function::Acos => r"\arccos".to_owned(),
        Function::Atan => r"\arctan".to_owned(),
        f if COMMANDS.contains(&f) => format!(r"\{}", f.name()),
        f => format!(r"\operatorname{{{}}}", f.name()),
    };
    let mut pieces = vec![Piece::Text(format!(r"{command}\!\left( "))];
    let branches = pool.node(node.right);
    let arguments = match function {
        Function::If => vec![node.left, branches.left, branches.right],
        f => vec![node.left, node.right][..f.arity()].to_vec(),
    };
    for (i, argument) in arguments.into_iter().enumerate() {
        pieces.push(if i == 0 { "" } else { ", " }.into());
        pieces.push(Piece::Expr(argument, Strength::Sum));
    }
    pieces.push(r" \right)".into());
    pieces
}

/// Terms joined by their signs.
fn joined(reader: &Reader<'_>, terms: &[Expr]) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for (i, &term) in terms.iter().enumerate() {
        let term = reader.term(term);
        let sign = match (i, term.is_negative) {
            (0, false) => "",
            (0, true) => "-",
            (_, false) => " + ",
            (_, true) => " - ",
        };
        pieces.push(sign.into());
        pieces.extend(quotient(&term));
    }
    pieces
}

fn product(reader: &Reader<'_>, e: Expr) -> (Strength, Vec<Piece>) {
    let term = reader.term(e);
    let mut pieces = quotient(&term);
    if term.is_negative {
        pieces.insert(0, "-".into());
    }
    (if term.is_negative { Strength::Sum } else { Strength::Product }, pieces)
}

/// A fraction if there is a denominator, factors side by side otherwise.
fn quotient(term: &Term) -> Vec<Piece> {
    if term.denominator.is_empty() {
        return factors(Some(term.coefficient), &term.numerator, Strength::Product);
    }
    let mut pieces = vec![r"\frac{".into()];
    pieces.extend(factors(Some(term.coefficient), &term.numerator, Strength::Sum));
    pieces.push("}{".into());
    pieces.extend(factors(None, &term.denominator, Strength::Sum));
    pieces.push("}".into());
    pieces
}

/// Factors side by side; one that stands alone needs parentheses only below strength `alone`.
fn factors(coefficient: Option<Number>, factors: &[Expr], alone: Strength) -> Vec<Piece> {
    let mut pieces = Vec::new();
    if let Some(c) = coefficient.filter(|c| factors.is_empty() || !c.is_one()) {
        pieces.push(Piece::Text(number(c)));
    }
    let is_alone = pieces.is_empty() && factors.len() == 1;
    let strength = if is_alone { alone } else { Strength::Power };
    for &factor in factors {
        if !pieces.is_empty() {
            pieces.push(r" \, ".into());
        }
        pieces.push(Piece::Expr(factor, strength));
    }
    pieces
}

/// The magnitude of a number.
fn number(n: Number) -> String {
    let magnitude = n.magnitude();
    if let Some(r) = magnitude.as_rational() {
        return match *r.denom() {
            1 => r.numer().to_string(),
            denominator => format!(r"\frac{{{}}}{{{denominator}}}", r.numer()),
        };
    }
    let text = magnitude.to_string();
    match text.split_once('e') {
        Some((mantissa, exponent)) => format!(r"{mantissa} \cdot 10^{{{exponent}}}"),
        None => text,
    }
}

/// `x2_dot` becomes `\dot{x}_{2}`, `theta1` `\theta_{1}`, `crank.x` `x_{\mathrm{crank}}`.
fn identifier(name: &str) -> String {
    let (name, accent) = match (name.strip_suffix("_ddot"), name.strip_suffix("_dot")) {
        (Some(stem), _) => (stem, r"\ddot"),
        (_, Some(stem)) => (stem, r"\dot"),
        _ => (name, ""),
    };
    let (path, last) = name.rsplit_once('.').map_or(("", name), |(path, last)| (path, last));
    let stem_end = last.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    let (stem, digits) = last.split_at(if stem_end == 0 { last.len() } else { stem_end });
    let (stem, word) = match stem.trim_end_matches('_').split_once('_') {
        Some((stem, word)) if !stem.is_empty() => (stem, word),
        _ => (stem.trim_end_matches('_'), ""),
    };
    let letter = match stem {
        stem if GREEK.contains(&stem) => format!(r"\{stem}"),
        stem => escaped(stem),
    };
    let letter = if accent.is_empty() { letter } else { format!("{accent}{{{letter}}}") };
    let roman = |word: &str| format!(r"\mathrm{{{}}}", escaped(word));
    let mut subscript: Vec<String> = [word, path]
        .into_iter()
        .filter(|word| !word.is_empty())
        .map(|word| if GREEK.contains(&word) { format!(r"\{word}") } else { roman(word) })
        .collect();
    if !digits.is_empty() {
        subscript.insert(usize::from(!word.is_empty()), digits.to_owned());
    }
    if subscript.is_empty() { letter } else { format!("{letter}_{{{}}}", subscript.join(",")) }
}

fn escaped(word: &str) -> String {
    word.replace('_', r"\_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_become_letters_with_accents_and_subscripts() {
        for (name, expected) in [
            ("theta1", r"\theta_{1}"),
            ("x2_dot", r"\dot{x}_{2}"),
            ("x2_ddot", r"\ddot{x}_{2}"),
            ("ld1", "ld_{1}"),
            ("m", "m"),
            ("crank.x", r"x_{\mathrm{crank}}"),
            ("k_spring", r"k_{\mathrm{spring}}"),
            ("q_12", "q_{12}"),
        ] {
            assert_eq!(identifier(name), expected, "{name}");
        }
    }

    #[test]
    fn quotients_are_fractions_and_calls_have_tall_parentheses() {
        let pool = Pool::new();
        let latex = |text: &str| pool.to_latex(pool.parse(text).expect("valid text"));
        assert_eq!(latex("m*x2_dot^2/2"), r"\frac{1}{2} \, m \, \dot{x}_{2}^{2}");
        assert_eq!(latex("a/(b+c)"), r"\frac{a}{b + c}");
        assert_eq!(latex("sin(theta1)"), r"\sin\!\left( \theta_{1} \right)");
        assert_eq!(latex("(a+b)^2*c"), r"c \, \left( a + b \right)^{2}");
    }
}
