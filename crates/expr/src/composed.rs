//! Functions that are made of those of the table, as syntax: nothing after a syntax tree knows of them.

use crate::number::Number;
use crate::op::Function;
use crate::syntax::{BinaryOperator, Syntax, SyntaxKind, SyntaxNode};
use std::ops::Range;

/// A function made of others.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Composed {
    /// Name of the function.
    pub name: &'static str,
    /// Arguments of the function, as a message shows them.
    pub arguments: &'static str,
    /// The least and the largest number of arguments.
    pub takes: [usize; 2],
}

const fn row(name: &'static str, arguments: &'static str, takes: [usize; 2]) -> Composed {
    Composed { name, arguments, takes }
}

/// No call has more arguments than bytes.
const ANY: usize = usize::MAX;

/// All of them. With two arguments, `min` and `max` are of the table.
pub const COMPOSED: [Composed; 8] = [
    row("min", "a, b", [3, ANY]),
    row("max", "a, b", [3, ANY]),
    row("step", "x", [1, 1]),
    row("hypot", "x, y", [2, ANY]),
    row("clamp", "x, least, largest", [3, 3]),
    row("mod", "a, b", [2, 2]),
    row("ceil", "x", [1, 1]),
    row("round", "x", [1, 1]),
];

/// The names of all functions that text may call: those of the table and those made of them.
pub fn function_names() -> impl Iterator<Item = &'static str> {
    let more = COMPOSED.iter().map(|row| row.name);
    Function::names().chain(more.filter(|name| Function::from_name(name).is_none()))
}

/// A syntax tree while it is written: nodes are added at its end, at one place of the text.
struct Writing<'n> {
    nodes: &'n mut Vec<SyntaxNode>,
    name_span: &'n Range<usize>,
    span: &'n Range<usize>,
}

impl Writing<'_> {
    fn push(&mut self, kind: SyntaxKind) -> usize {
        self.nodes.push(SyntaxNode { kind, span: self.span.clone() });
        self.nodes.len() - 1
    }

    fn number(&mut self, value: i64) -> usize {
        self.push(SyntaxKind::Number(Number::from(value)))
    }

    fn call(&mut self, name: &str, arguments: Vec<usize>) -> usize {
        let (name, name_span) = (name.to_owned(), self.name_span.clone());
        self.push(SyntaxKind::Call { name, name_span, arguments })
    }

    fn binary(&mut self, operator: BinaryOperator, left: usize, right: usize) -> usize {
        let operator_span = self.name_span.clone();
        self.push(SyntaxKind::Binary { operator, operator_span, left, right })
    }

    /// The function of these arguments, whose number is one that it takes.
    fn expand(&mut self, name: &str, arguments: &[usize]) {
        use BinaryOperator::{Add, Divide, Multiply, Power, Subtract};
        match (name, arguments) {
            ("step", &[x]) => {
                let zero = self.number(0);
                self.call("ge", vec![x, zero]);
            }
            ("clamp", &[x, least, largest]) => {
                let below = self.call("min", vec![x, largest]);
                self.call("max", vec![least, below]);
            }
            ("hypot", _) => {
                let mut sum = None;
                for &argument in arguments {
                    let two = self.number(2);
                    let square = self.binary(Power, argument, two);
                    sum = Some(sum.map_or(square, |sum| self.binary(Add, sum, square)));
                }
                let sum = sum.expect("a hypotenuse has two legs at least");
                self.call("sqrt", vec![sum]);
            }
            ("mod", &[a, b]) => {
                let ratio = self.binary(Divide, a, b);
                let count = self.call("floor", vec![ratio]);
                let whole = self.binary(Multiply, b, count);
                self.binary(Subtract, a, whole);
            }
            ("ceil", &[x]) => {
                let minus = self.push(SyntaxKind::Negate(x));
                let below = self.call("floor", vec![minus]);
                self.push(SyntaxKind::Negate(below));
            }
            ("round", &[x]) => {
                let (one, two) = (self.number(1), self.number(2));
                let half = self.binary(Divide, one, two);
                let sum = self.binary(Add, x, half);
                self.call("floor", vec![sum]);
            }
            _ => {
                // The least or largest of many, from left to right.
                let mut folded = arguments[0];
                for &next in &arguments[1..] {
                    folded = self.call(name, vec![folded, next]);
                }
            }
        }
    }
}

impl Syntax {
    /// The tree with calls of [`COMPOSED`] functions written out, except of those that the caller knows.
    /// Calls with a wrong number of arguments stay.
    #[must_use]
    pub fn written_out(self, is_known: &dyn Fn(&str) -> bool) -> Self {
        let rule = |kind: &SyntaxKind| match kind {
            SyntaxKind::Call { name, arguments, .. } => COMPOSED.iter().any(|row| {
                let [least, largest] = row.takes;
                row.name == name && (least..=largest).contains(&arguments.len()) && !is_known(name)
            }),
            _ => false,
        };
        if !self.nodes.iter().any(|node| rule(&node.kind)) {
            return self;
        }
        let mut nodes = Vec::with_capacity(self.nodes.len() + 8);
        // Where each node of the old tree is in the new one.
        let mut places: Vec<usize> = Vec::with_capacity(self.nodes.len());
        for SyntaxNode { mut kind, span } in self.nodes {
            kind.operands_mut().for_each(|operand| *operand = places[*operand]);
            match &kind {
                SyntaxKind::Call { name, name_span, arguments } if rule(&kind) => {
                    let mut writing = Writing { nodes: &mut nodes, name_span, span: &span };
                    writing.expand(name, arguments);
                }
                _ => nodes.push(SyntaxNode { kind, span }),
            }
            places.push(nodes.len() - 1);
        }
        Self { nodes }
    }
}
