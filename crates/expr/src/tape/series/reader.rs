//! [`Reader`]: the operations of a tape as rules of series.

use super::{Row, Rule};
use crate::op::{Function, small_integer};
use crate::tape::Action;
use std::collections::HashMap;

/// Reads the operations of a tape as rules.
#[derive(Default)]
pub(super) struct Reader {
    pub(super) rows: Vec<Row>,
    /// Sine and cosine, or those of a hyperbola, by their angle.
    pairs: HashMap<(bool, usize), [usize; 2]>,
}

impl Reader {
    pub(super) fn push(&mut self, rule: Rule) -> usize {
        let fixed = |row: usize| self.rows[row].is_fixed;
        let is_fixed = match rule {
            Rule::Constant(_) | Rule::Parameter(_) | Rule::Fixed(..) => true,
            Rule::Input(_) | Rule::Integral { .. } => false,
            Rule::Negate(a) | Rule::Sqrt(a) => fixed(a),
            Rule::Add(a, b) | Rule::Subtract(a, b) | Rule::Multiply(a, b) | Rule::Divide(a, b) => {
                fixed(a) && fixed(b)
            }
        };
        self.rows.push(Row { rule, is_fixed, coefficients: Vec::new() });
        self.rows.len() - 1
    }

    /// The row of an operation; `exponent` is the second operand where that is a number.
    pub(super) fn read(
        &mut self,
        action: Action,
        operands @ [a, b, _]: [usize; 3],
        exponent: Option<f64>,
    ) -> Option<usize> {
        if operands.iter().all(|&row| self.rows[row].is_fixed) {
            return Some(self.push(Rule::Fixed(action, operands)));
        }
        Some(match action {
            Action::Add => self.push(Rule::Add(a, b)),
            Action::Subtract => self.push(Rule::Subtract(a, b)),
            Action::Multiply => {
                // A quotient is half the work of a product with a reciprocal.
                let rule = match [b, a].map(|row| self.reciprocal_of(row)) {
                    [Some(below), _] => Rule::Divide(a, below),
                    [_, Some(below)] => Rule::Divide(b, below),
                    _ => self.product(a, b),
                };
                self.push(rule)
            }
            Action::Divide => self.push(Rule::Divide(a, b)),
            Action::Negate => self.push(Rule::Negate(a)),
            Action::Power => self.power((a, b), exponent),
            Action::Call(function) => self.call(function, a, b)?,
            // One at a time, as operations come.
            Action::Turn => return None,
        })
    }

    /// The rule of a product: that of two multiples of one row is a multiple of its square, half the work.
    fn product(&mut self, a: usize, b: usize) -> Rule {
        let [(a_factors, a_base), (b_factors, b_base)] = [a, b].map(|row| self.multiple(row));
        let factors = [a_factors, b_factors].concat();
        let is_fixed = self.rows[a_base].is_fixed;
        if a_base != b_base || factors.is_empty() || is_fixed {
            return Rule::Multiply(a, b);
        }
        let square = self.push(Rule::Multiply(a_base, b_base));
        let action = Action::Multiply;
        let factor = factors.into_iter().reduce(|a, b| self.push(Rule::Fixed(action, [a, b, a])));
        factor.map_or(Rule::Multiply(a, b), |factor| Rule::Multiply(factor, square))
    }

    /// The rows without time that a row is a product of, with the row that is left.
    fn multiple(&self, mut row: usize) -> (Vec<usize>, usize) {
        let mut factors = Vec::new();
        while let Rule::Multiply(a, b) = self.rows[row].rule {
            let [is_first, is_second] = [a, b].map(|row| self.rows[row].is_fixed);
            if is_first == is_second {
                break;
            }
            let (factor, rest) = if is_first { (a, b) } else { (b, a) };
            factors.push(factor);
            row = rest;
        }
        (factors, row)
    }

    /// The row that this row is one over.
    fn reciprocal_of(&self, row: usize) -> Option<usize> {
        let Rule::Divide(above, below) = self.rows[row].rule else { return None };
        matches!(self.rows[above].rule, Rule::Constant(1.0)).then_some(below)
    }

    /// A function of `of` with that slope, or of two operands.
    fn integral(&mut self, function: Function, of: usize, slope: usize) -> usize {
        let first = Some((Action::Call(function), [of; 2]));
        self.push(Rule::Integral { first, slope, of })
    }

    fn power(&mut self, (base, exponent): (usize, usize), number: Option<f64>) -> usize {
        let small = number.filter(|_| self.rows[exponent].is_fixed).and_then(small_integer);
        if let Some(n) = small.filter(|&n| n != 0) {
            let power = self.integer_power(base, n.unsigned_abs());
            if n > 0 {
                return power;
            }
            let one = self.push(Rule::Constant(1.0));
            return self.push(Rule::Divide(one, power));
        }
        // c = exp(b ln a).
        let logarithm = self.ln(base);
        let of = self.push(Rule::Multiply(exponent, logarithm));
        let slope = self.rows.len();
        let first = Some((Action::Power, [base, exponent]));
        self.push(Rule::Integral { first, slope, of })
    }

    /// By repeated squaring, as the evaluators do.
    fn integer_power(&mut self, base: usize, mut n: u64) -> usize {
        let (mut result, mut square) = (None, base);
        loop {
            if n & 1 == 1 {
                let next = |result| self.push(Rule::Multiply(result, square));
                result = Some(result.map_or(square, next));
            }
            n >>= 1;
            match result {
                Some(result) if n == 0 => return result,
                _ => square = self.push(Rule::Multiply(square, square)),
            }
        }
    }

    fn ln(&mut self, a: usize) -> usize {
        let one = self.push(Rule::Constant(1.0));
        let slope = self.push(Rule::Divide(one, a));
        self.integral(Function::Ln, a, slope)
    }

    fn call(&mut self, function: Function, a: usize, b: usize) -> Option<usize> {
        use Function as F;
        // The row that comes next, and others after it.
        let own = self.rows.len();
        Some(match function {
            F::Sin => self.pair(a, false)[0],
            F::Cos => self.pair(a, false)[1],
            F::Sinh => self.pair(a, true)[0],
            F::Cosh => self.pair(a, true)[1],
            F::Exp => self.integral(F::Exp, a, own),
            F::Sqrt => self.push(Rule::Sqrt(a)),
            F::Ln => self.ln(a),
            F::Tan | F::Tanh => {
                // s = 1 ± c².
                self.integral(function, a, own + 3);
                let one = self.push(Rule::Constant(1.0));
                let square = self.push(Rule::Multiply(own, own));
                let is_round = function == F::Tan;
                self.push(if is_round {
                    Rule::Add(one, square)
                } else {
                    Rule::Subtract(one, square)
                });
                own
            }
            F::Atan | F::Asin | F::Acos => {
                // s = 1/(1 + a²), ± 1/√(1 − a²).
                let one = self.push(Rule::Constant(1.0));
                let square = self.push(Rule::Multiply(a, a));
                let below = if function == F::Atan {
                    self.push(Rule::Add(one, square))
                } else {
                    let rest = self.push(Rule::Subtract(one, square));
                    self.push(Rule::Sqrt(rest))
                };
                let sign = if function == F::Acos { -1.0 } else { 1.0 };
                let sign = self.push(Rule::Constant(sign));
                let slope = self.push(Rule::Divide(sign, below));
                self.integral(function, a, slope)
            }
            F::Atan2 => {
                // c′ = (b a′ − a b′)/(a² + b²).
                let squares = [a, b].map(|x| self.push(Rule::Multiply(x, x)));
                let below = self.push(Rule::Add(squares[0], squares[1]));
                let ahead = self.push(Rule::Divide(b, below));
                let across = self.push(Rule::Divide(a, below));
                let back = self.push(Rule::Negate(across));
                let first = Some((Action::Call(F::Atan2), [a, b]));
                let along = self.push(Rule::Integral { first, slope: ahead, of: a });
                let aside = self.push(Rule::Integral { first: None, slope: back, of: b });
                self.push(Rule::Add(along, aside))
            }
            F::Abs | F::Sign | F::Floor | F::Min | F::Max | F::Lt | F::Le | F::Gt | F::Ge => {
                return None;
            }
            F::If => return None,
        })
    }

    /// Rows of sine and cosine of an angle, each the slope of the other but for its sign.
    fn pair(&mut self, angle: usize, is_hyperbolic: bool) -> [usize; 2] {
        if let Some(&pair) = self.pairs.get(&(is_hyperbolic, angle)) {
            return pair;
        }
        let [sine, cosine] = [self.rows.len(), self.rows.len() + 1];
        let [sin, cos] = if is_hyperbolic {
            [Function::Sinh, Function::Cosh]
        } else {
            [Function::Sin, Function::Cos]
        };
        self.integral(sin, angle, cosine);
        self.integral(cos, angle, if is_hyperbolic { sine } else { cosine + 1 });
        if !is_hyperbolic {
            self.push(Rule::Negate(sine));
        }
        self.pairs.insert((is_hyperbolic, angle), [sine, cosine]);
        [sine, cosine]
    }
}
