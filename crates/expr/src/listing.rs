//! Expressions as lists of steps, and back: to be stored, or sent to another process.
//!
//! ```text
//! symbol x          a line per step, numbered from 0 in their order
//! number 1/2
//! mul 1 0           operands by the numbers of their steps
//! sin 2
//! = 3               the expressions, last
//! ```
//!
//! Printed as a formula, a part that occurs twice is written twice, and one of many levels without end. Here
//! every part is written once, so that the list is as long as the graph. It says the same in every pool.

use crate::number::Number;
use crate::op::{Function, Op};
use crate::pool::{Expr, Pool, SymbolId};
use std::fmt::Write as _;

/// Why a text is no list of steps: its first bad line, counted from 1.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("line {0} of the list of steps cannot be read")]
pub struct ListingError(pub usize);

impl Pool {
    /// The steps that make `roots`, each once; functions with a name are written out.
    ///
    /// ```
    /// use bksim_expr::Pool;
    ///
    /// let (pool, other) = (Pool::new(), Pool::new());
    /// let e = pool.parse("sin(x/2)^2 + sin(x/2)")?;
    /// let copy = other.read_listing(&pool.listing(&[e]))?[0];
    /// assert_eq!(other.to_text(copy), pool.to_text(e));
    /// assert_eq!(pool.read_listing(&other.listing(&[copy]))?, [e]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn listing(&self, roots: &[Expr]) -> String {
        let sweep = self.sweep(&self.expand_named(roots));
        let mut text = String::new();
        for step in &sweep.steps {
            match step.op {
                Op::Number => {
                    text.push_str("number ");
                    text.push_str(&self.number_of(step.expr).listed());
                }
                Op::Symbol => {
                    text.push_str("symbol ");
                    text.push_str(&self.symbol_name(SymbolId(step.data)));
                }
                Op::Pi => text.push_str("pi"),
                Op::Add => text.push_str("add"),
                Op::Mul => text.push_str("mul"),
                Op::Pow => text.push_str("pow"),
                Op::Pair => text.push_str("pair"),
                Op::Named => unreachable!("functions with names are expanded above"),
                Op::Call(function) => text.push_str(function.name()),
            }
            for operand in sweep.operands(step) {
                // Writing to a text cannot fail.
                let _ = write!(text, " {operand}");
            }
            text.push('\n');
        }
        text.push('=');
        for root in &sweep.roots {
            let _ = write!(text, " {root}");
        }
        text.push('\n');
        text
    }

    /// The expressions of a [listing](Pool::listing), of this pool or another one.
    ///
    /// # Errors
    /// [`ListingError`] names the first line that no listing has.
    pub fn read_listing(&self, text: &str) -> Result<Vec<Expr>, ListingError> {
        let mut steps: Vec<Expr> = Vec::new();
        let mut n_lines = 0;
        for line in text.lines() {
            n_lines += 1;
            if let Some(roots) = line.strip_prefix('=') {
                let roots = operands(roots, &steps).filter(|roots| self.are_values(roots));
                return roots.ok_or(ListingError(n_lines));
            }
            steps.push(self.step(line, &steps).ok_or(ListingError(n_lines))?);
        }
        Err(ListingError(n_lines + 1))
    }

    /// True unless one of them is the two branches of an `if` by themselves.
    fn are_values(&self, all: &[Expr]) -> bool {
        all.iter().all(|&e| self.node(e).op != Op::Pair)
    }

    /// The step of a line, with the `steps` before it.
    fn step(&self, line: &str, steps: &[Expr]) -> Option<Expr> {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        match word {
            "number" => return Number::of_listed(rest).map(|number| self.number(number)),
            "symbol" => return (!rest.is_empty()).then(|| self.symbol(rest)),
            "pi" => return Some(self.pi()),
            _ => (),
        }
        let operands = operands(rest, steps)?;
        match (word, operands.as_slice()) {
            ("if", &[condition, pair]) if self.node(pair).op == Op::Pair => {
                let branches = self.node(pair);
                Some(self.select(condition, branches.left, branches.right))
            }
            _ if !self.are_values(&operands) => None,
            ("add", [_, _, ..]) => Some(self.sum(operands)),
            ("mul", [_, _, ..]) => Some(self.product(operands)),
            ("pow", &[base, exponent]) => Some(self.pow(base, exponent)),
            ("pair", &[a, b]) => Some(self.intern(Op::Pair, a, b, 0)),
            _ => {
                let function = Function::from_name(word).filter(|known| *known != Function::If)?;
                self.call(function, &operands)
            }
        }
    }
}

/// The steps with these numbers.
fn operands(numbers: &str, steps: &[Expr]) -> Option<Vec<Expr>> {
    let step = |number: &str| steps.get(number.parse::<usize>().ok()?).copied();
    numbers.split_whitespace().map(step).collect()
}
