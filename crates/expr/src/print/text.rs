//! Infix text that this crate and others can parse.

use super::{Piece, Reader, Strength, Term, write};
use crate::number::Number;
use crate::op::{Function, Op};
use crate::pool::{Expr, Pool};

impl Pool {
    /// Infix text: `+ - * / ^`, function names and plain identifiers.
    ///
    /// Shared parts are written out each time; [`Pool::operation_count`] tells how long that is.
    pub fn to_text(&self, e: Expr) -> String {
        let reader = Reader::new(self, &[e]);
        write(vec![Piece::Expr(e, Strength::Sum)], |e, strength| expand(&reader, e, strength))
    }

    /// The terms joined by `+` and `-` in the given order; `0` when there are none.
    pub fn terms_to_text(&self, terms: &[Expr]) -> String {
        if terms.is_empty() {
            return "0".to_owned();
        }
        let reader = Reader::new(self, terms);
        write(joined(&reader, &reader.in_line(terms)), |e, strength| expand(&reader, e, strength))
    }
}

/// One expression in pieces, with parentheses if it binds looser than `strength`.
fn expand(reader: &Reader<'_>, e: Expr, strength: Strength) -> Vec<Piece> {
    let pool = reader.pool;
    let node = pool.node(e);
    let (own, pieces) = match node.op {
        Op::Number => number(pool.as_number(e).unwrap_or(Number::ZERO)),
        Op::Pi => (Strength::Atom, vec!["pi".into()]),
        Op::Symbol => {
            let name = pool.symbol_id(e).map(|symbol| pool.symbol_name(symbol));
            (Strength::Atom, vec![Piece::Text(name.unwrap_or_default())])
        }
        Op::Add => (Strength::Sum, joined(reader, &reader.ordered_terms(e))),
        Op::Mul => product(reader, e),
        Op::Pow => match pool.split_power(e) {
            (_, n) if n < 0 => product(reader, e),
            _ => {
                let base = Piece::Expr(node.left, Strength::Atom);
                let exponent = Piece::Expr(node.right, Strength::Atom);
                (Strength::Power, vec![base, "^".into(), exponent])
            }
        },
        Op::Pair => (Strength::Atom, arguments(&[node.left, node.right])),
        Op::Call(Function::If) => {
            let branches = pool.node(node.right);
            let mut pieces = vec!["if(".into()];
            pieces.extend(arguments(&[node.left, branches.left, branches.right]));
            pieces.push(")".into());
            (Strength::Atom, pieces)
        }
        Op::Call(function) => {
            let mut pieces = vec![Piece::Text(format!("{}(", function.name()))];
            pieces.extend(arguments(&[node.left, node.right][..function.arity()]));
            pieces.push(")".into());
            (Strength::Atom, pieces)
        }
    };
    if own >= strength {
        return pieces;
    }
    let mut wrapped = vec!["(".into()];
    wrapped.extend(pieces);
    wrapped.push(")".into());
    wrapped
}

fn number(n: Number) -> (Strength, Vec<Piece>) {
    let text = n.to_string();
    let own = match text.as_str() {
        _ if n.is_negative() => Strength::Sum,
        text if text.contains('/') => Strength::Product,
        _ => Strength::Atom,
    };
    (own, vec![Piece::Text(text)])
}

fn arguments(arguments: &[Expr]) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for (i, &argument) in arguments.iter().enumerate() {
        if i > 0 {
            pieces.push(", ".into());
        }
        pieces.push(Piece::Expr(argument, Strength::Sum));
    }
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
        pieces.extend(quotient(reader.pool, &term));
    }
    pieces
}

fn product(reader: &Reader<'_>, e: Expr) -> (Strength, Vec<Piece>) {
    let term = reader.term(e);
    let mut pieces = quotient(reader.pool, &term);
    if term.is_negative {
        pieces.insert(0, "-".into());
    }
    (if term.is_negative { Strength::Sum } else { Strength::Product }, pieces)
}

/// `c*a*b/(d*f)` without the sign.
fn quotient(pool: &Pool, term: &Term) -> Vec<Piece> {
    let mut pieces = Vec::new();
    if term.numerator.is_empty() || !term.coefficient.is_one() {
        pieces.push(Piece::Text(term.coefficient.to_string()));
    }
    for &factor in &term.numerator {
        if !pieces.is_empty() {
            pieces.push("*".into());
        }
        pieces.push(Piece::Expr(factor, Strength::Power));
    }
    let divisors = &term.denominator;
    // a/(b*0) would read back as a/0.
    let is_one_group = divisors.len() > 1 && !divisors.iter().any(|&d| pool.is_zero(d));
    for (i, &divisor) in divisors.iter().enumerate() {
        let sign = match (is_one_group, i) {
            (false, _) => "/",
            (true, 0) => "/(",
            (true, _) => "*",
        };
        pieces.extend([sign.into(), Piece::Expr(divisor, Strength::Power)]);
    }
    if is_one_group {
        pieces.push(")".into());
    }
    pieces
}
