//! From expressions to marks: signs, fractions, powers and parentheses, for every notation.
//!
//! The walk keeps a stack of its own, so that no depth of an expression can overflow another one.

use super::Notation;
use super::mark::{Height, Mark, MarkPart, relation};
use super::order::{Reader, WrittenTerm, as_fraction};
use crate::build::MERGE_LIMIT;
use crate::named_row::FunctionId;
use crate::number::Number;
use crate::op::{Function, Op};
use crate::pool::{Expr, SymbolId};

/// Binding strength of the surroundings of an expression; anything looser needs parentheses.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Strength {
    Sum,
    Product,
    Power,
    Atom,
}

/// A piece still to be written.
pub(super) enum Piece {
    Mark(Mark),
    Expr(Expr, Strength),
    /// The condition of a case.
    Condition(Expr),
}

/// Functions written without parentheses before a symbol, and with their power at the name.
const BARE: [Function; 6] =
    [Function::Sin, Function::Cos, Function::Tan, Function::Sinh, Function::Cosh, Function::Tanh];

/// One expression that nothing surrounds.
pub(super) fn whole(e: Expr) -> Vec<Piece> {
    vec![Piece::Expr(e, Strength::Sum)]
}

/// Emits the marks of `pieces` in order.
pub(super) fn walk(
    reader: &Reader<'_>,
    notation: Notation,
    pieces: Vec<Piece>,
    emit: &mut dyn FnMut(Mark),
) {
    let walk = Walk { reader, notation, is_linear: notation.is_linear() };
    let mut pending = pieces;
    pending.reverse();
    while let Some(piece) = pending.pop() {
        match piece {
            Piece::Mark(mark) => emit(mark),
            Piece::Expr(e, strength) => pending.extend(walk.expand(e, strength).into_iter().rev()),
            Piece::Condition(e) => pending.extend(walk.condition(e).into_iter().rev()),
        }
    }
}

/// Whether the first term of a sum has something before it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Sum {
    Begins,
    GoesOn,
}

/// Terms joined by their signs.
pub(super) fn sum(reader: &Reader<'_>, is_linear: bool, sum: Sum, terms: &[Expr]) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for (i, &term) in terms.iter().enumerate() {
        let term = reader.term(term);
        let is_first = i == 0 && sum == Sum::Begins;
        let sign = match (is_first, term.is_negative) {
            (true, false) => None,
            (true, true) => Some(Mark::Sign),
            (false, false) => Some(Mark::Plus),
            (false, true) => Some(Mark::Minus),
        };
        pieces.extend(sign.map(Piece::Mark));
        pieces.extend(quotient(reader, is_linear, &term));
    }
    pieces
}

struct Walk<'a> {
    reader: &'a Reader<'a>,
    notation: Notation,
    is_linear: bool,
}

impl Walk<'_> {
    /// One expression in pieces, with parentheses if it binds looser than `strength`.
    fn expand(&self, e: Expr, strength: Strength) -> Vec<Piece> {
        let pool = self.reader.pool;
        let node = pool.node(e);
        let (own, pieces) = match node.op {
            Op::Number => self.number(&pool.number_of(e)),
            Op::Pi => (Strength::Atom, vec![Piece::Mark(Mark::Pi)]),
            Op::Symbol => {
                let symbol = SymbolId(node.data);
                (Strength::Atom, vec![Piece::Mark(Mark::Symbol(symbol))])
            }
            Op::Add => {
                let terms = self.reader.ordered_terms(e);
                (Strength::Sum, sum(self.reader, self.is_linear, Sum::Begins, &terms))
            }
            Op::Mul => self.product(e),
            Op::Pow => match pool.split_power(e) {
                (_, n) if n < 0 => self.product(e),
                _ => self.power(node.left, node.right),
            },
            Op::Pair => (Strength::Atom, list(&[node.left, node.right])),
            Op::Call(function) => (Strength::Atom, self.call(function, e, 1)),
            Op::Named => (Strength::Atom, self.named(FunctionId(node.data), e)),
        };
        if own >= strength {
            return pieces;
        }
        let height = self.height(e);
        let mut wrapped = vec![Piece::Mark(Mark::Parenthesis(MarkPart::Start, height))];
        wrapped.extend(pieces);
        wrapped.push(Piece::Mark(Mark::Parenthesis(MarkPart::End, height)));
        wrapped
    }

    fn height(&self, e: Expr) -> Height {
        if self.reader.is_tall(e) && !self.is_linear { Height::Tall } else { Height::Line }
    }

    fn number(&self, n: &Number) -> (Strength, Vec<Piece>) {
        let mut pieces = magnitude(n.magnitude(), self.is_linear);
        let is_fraction = pieces.len() > 1 || n.to_string().contains('/');
        if n.is_negative() {
            pieces.insert(0, Piece::Mark(Mark::Sign));
            return (Strength::Sum, pieces);
        }
        (if is_fraction { Strength::Product } else { Strength::Atom }, pieces)
    }

    fn product(&self, e: Expr) -> (Strength, Vec<Piece>) {
        let term = self.reader.term(e);
        let mut pieces = quotient(self.reader, self.is_linear, &term);
        if term.is_negative {
            pieces.insert(0, Piece::Mark(Mark::Sign));
        }
        (if term.is_negative { Strength::Sum } else { Strength::Product }, pieces)
    }

    fn power(&self, base: Expr, exponent: Expr) -> (Strength, Vec<Piece>) {
        let pool = self.reader.pool;
        let natural = pool.as_number(exponent).and_then(|n| n.as_integer());
        let natural = natural.and_then(|n| u64::try_from(n).ok());
        if let (Op::Call(function), Some(n), false) = (pool.node(base).op, natural, self.is_linear)
            && BARE.contains(&function)
        {
            return (Strength::Power, self.call(function, base, n));
        }
        if let (Some(symbol), Some(n)) = (pool.symbol_id(base), natural) {
            return (Strength::Power, vec![Piece::Mark(Mark::RaisedSymbol(symbol, n))]);
        }
        let mut pieces =
            vec![Piece::Mark(Mark::Power(MarkPart::Start)), Piece::Expr(base, Strength::Atom)];
        if let Some(n) = natural {
            pieces.push(Piece::Mark(Mark::Raised(n)));
        } else {
            let strength = if self.is_linear { Strength::Atom } else { Strength::Sum };
            pieces.push(Piece::Mark(Mark::Power(MarkPart::Middle)));
            pieces.push(Piece::Expr(exponent, strength));
            pieces.push(Piece::Mark(Mark::Power(MarkPart::End)));
        }
        (Strength::Power, pieces)
    }

    /// A call whose value is raised to the power `n`.
    fn call(&self, function: Function, e: Expr, n: u64) -> Vec<Piece> {
        let pool = self.reader.pool;
        let node = pool.node(e);
        let enclosed = |start, inside, end| {
            vec![Piece::Mark(start), Piece::Expr(inside, Strength::Sum), Piece::Mark(end)]
        };
        let is_text = self.notation == Notation::Text;
        match function {
            Function::Sqrt if !is_text => {
                return enclosed(Mark::Root(MarkPart::Start), node.left, Mark::Root(MarkPart::End));
            }
            Function::Abs if !is_text => {
                return enclosed(
                    Mark::Absolute(MarkPart::Start),
                    node.left,
                    Mark::Absolute(MarkPart::End),
                );
            }
            Function::If if !self.is_linear => return self.cases(e),
            _ if !self.is_linear && relation(function).is_some() => {
                let mut pieces = vec![Piece::Mark(Mark::Truth(MarkPart::Start))];
                pieces.extend(self.condition(e));
                pieces.push(Piece::Mark(Mark::Truth(MarkPart::End)));
                return pieces;
            }
            _ => (),
        }
        let mut pieces = vec![Piece::Mark(Mark::Function(function, n))];
        let is_symbol = matches!(pool.node(node.left).op, Op::Symbol);
        if !self.is_linear && BARE.contains(&function) && is_symbol {
            pieces.push(Piece::Mark(Mark::Apply));
            pieces.push(Piece::Expr(node.left, Strength::Atom));
            return pieces;
        }
        let branches = pool.node(node.right);
        let arguments = match function {
            Function::If => vec![node.left, branches.left, branches.right],
            f => vec![node.left, node.right][..f.arity()].to_vec(),
        };
        pieces.extend(self.arguments(&arguments));
        pieces
    }

    /// A call of a function with a name.
    fn named(&self, function: FunctionId, e: Expr) -> Vec<Piece> {
        let mut pieces = vec![Piece::Mark(Mark::Named(function))];
        pieces.extend(self.arguments(&self.reader.pool.operands_of(e)));
        pieces
    }

    /// Arguments in parentheses.
    fn arguments(&self, arguments: &[Expr]) -> Vec<Piece> {
        let is_tall = !self.is_linear && arguments.iter().any(|&a| self.reader.is_tall(a));
        let height = if is_tall { Height::Tall } else { Height::Line };
        let mut pieces = vec![Piece::Mark(Mark::Arguments(MarkPart::Start, height))];
        pieces.extend(list(arguments));
        pieces.push(Piece::Mark(Mark::Arguments(MarkPart::End, height)));
        pieces
    }

    fn cases(&self, e: Expr) -> Vec<Piece> {
        let pool = self.reader.pool;
        let node = pool.node(e);
        let branches = pool.node(node.right);
        vec![
            Piece::Mark(Mark::Cases(MarkPart::Start)),
            Piece::Expr(branches.left, Strength::Sum),
            Piece::Mark(Mark::Cases(MarkPart::Middle)),
            Piece::Condition(node.left),
            Piece::Mark(Mark::Otherwise),
            Piece::Expr(branches.right, Strength::Sum),
            Piece::Mark(Mark::Cases(MarkPart::End)),
        ]
    }

    fn condition(&self, e: Expr) -> Vec<Piece> {
        let node = self.reader.pool.node(e);
        match node.op {
            Op::Call(function) if relation(function).is_some() => vec![
                Piece::Expr(node.left, Strength::Sum),
                Piece::Mark(Mark::Relation(function)),
                Piece::Expr(node.right, Strength::Sum),
            ],
            _ => vec![Piece::Expr(e, Strength::Sum), Piece::Mark(Mark::NotZero)],
        }
    }
}

/// Arguments with commas between them.
fn list(items: &[Expr]) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for (i, &item) in items.iter().enumerate() {
        if i > 0 {
            pieces.push(Piece::Mark(Mark::Arguments(MarkPart::Middle, Height::Line)));
        }
        pieces.push(Piece::Expr(item, Strength::Sum));
    }
    pieces
}

/// A positive number.
fn magnitude(n: Number, is_linear: bool) -> Vec<Piece> {
    match as_fraction(&n).filter(|_| !is_linear) {
        Some((numerator, denominator)) => fraction(
            vec![Piece::Mark(Mark::Number(Number::integer(numerator)))],
            vec![Piece::Mark(Mark::Number(Number::integer(denominator)))],
        ),
        None => vec![Piece::Mark(Mark::Number(n))],
    }
}

fn fraction(numerator: Vec<Piece>, denominator: Vec<Piece>) -> Vec<Piece> {
    let mut pieces = vec![Piece::Mark(Mark::Fraction(MarkPart::Start))];
    pieces.extend(numerator);
    pieces.push(Piece::Mark(Mark::Fraction(MarkPart::Middle)));
    pieces.extend(denominator);
    pieces.push(Piece::Mark(Mark::Fraction(MarkPart::End)));
    pieces
}

/// Numerator over denominator, without the sign.
fn quotient(reader: &Reader<'_>, is_linear: bool, term: &WrittenTerm) -> Vec<Piece> {
    if is_linear {
        return quotient_in_line(reader, term);
    }
    if term.denominator.is_empty() {
        return factors(magnitude(term.coefficient.clone(), false), term, &term.numerator);
    }
    // The numbers join the fraction after them.
    let (above, below) = match as_fraction(&term.coefficient) {
        Some((n, d)) => (Number::integer(n), Some(Number::integer(d))),
        None => (term.coefficient.clone(), None),
    };
    let number = |n: Option<Number>| {
        n.filter(|n| !n.is_one()).map(|n| Piece::Mark(Mark::Number(n))).into_iter().collect()
    };
    let alone = |coefficient: Vec<Piece>, list: &[Expr]| match (coefficient.is_empty(), list) {
        (true, [one]) => vec![Piece::Expr(*one, Strength::Sum)],
        (true, []) => vec![Piece::Mark(Mark::Number(Number::ONE))],
        _ => times(coefficient, list),
    };
    fraction(alone(number(Some(above)), &term.numerator), alone(number(below), &term.denominator))
}

/// Factors in a row; a coefficient of one is left out unless it is alone.
fn factors(coefficient: Vec<Piece>, term: &WrittenTerm, list: &[Expr]) -> Vec<Piece> {
    let is_silent = term.coefficient.is_one() && !list.is_empty();
    match (is_silent, list) {
        (true, [one]) => vec![Piece::Expr(*one, Strength::Product)],
        (true, list) => times(Vec::new(), list),
        (false, list) => times(coefficient, list),
    }
}

fn times(mut pieces: Vec<Piece>, list: &[Expr]) -> Vec<Piece> {
    for &factor in list {
        if !pieces.is_empty() {
            pieces.push(Piece::Mark(Mark::Times));
        }
        pieces.push(Piece::Expr(factor, Strength::Power));
    }
    pieces
}

/// `c*a*b/(d*f)`.
fn quotient_in_line(reader: &Reader<'_>, term: &WrittenTerm) -> Vec<Piece> {
    let mut pieces = Vec::new();
    if term.numerator.is_empty() || !term.coefficient.is_one() {
        pieces.push(Piece::Mark(Mark::Number(term.coefficient.clone())));
    }
    let mut pieces = times(pieces, &term.numerator);
    let divisors = &term.denominator;
    // a/(b*0) would read back as a/0, and a long group as the power of one product.
    let is_group = (2..=MERGE_LIMIT as usize).contains(&divisors.len());
    let is_one_group = is_group && !divisors.iter().any(|&d| reader.pool.is_zero(d));
    if !is_one_group {
        for &divisor in divisors {
            pieces.push(Piece::Mark(Mark::Over));
            pieces.push(Piece::Expr(divisor, Strength::Power));
        }
        return pieces;
    }
    pieces.push(Piece::Mark(Mark::Over));
    pieces.push(Piece::Mark(Mark::Parenthesis(MarkPart::Start, Height::Line)));
    pieces.extend(times(Vec::new(), divisors));
    pieces.push(Piece::Mark(Mark::Parenthesis(MarkPart::End, Height::Line)));
    pieces
}
