//! [`TapeSeries`]: the Taylor coefficients of all that a tape computes, one order after the other.
//!
//! ```text
//! a(t) = Σ aₖ tᵏ
//! c = a b     cₖ = Σᵢ aᵢ bₖ₋ᵢ                              i = 0 … k
//! c = a/b     cₖ = (aₖ − Σᵢ bᵢ cₖ₋ᵢ)/b₀                     i = 1 … k
//! c = √a      cₖ = (aₖ − Σᵢ cᵢ cₖ₋ᵢ)/(2 c₀)                 i = 1 … k − 1
//! c′ = s a′   cₖ = (1/k) Σᵢ i aᵢ sₖ₋ᵢ                       i = 1 … k
//! ```
//!
//! The last is the rule of every other function, whose slope `s` follows from the function itself: `s = c` of the
//! exponential. A. Griewank and A. Walther, *Evaluating Derivatives*, 2nd ed. 2008, §13.2.

use super::composition::{Composition, Value};
use super::{Action, Instruction, Tape};
use crate::op::{Function, small_integer};
use std::collections::HashMap;

/// The coefficient of a power of time; `None` where it is zero whatever the inputs are.
pub type Coefficient = Option<Value>;

/// The Taylor series of all that a tape computes, in the making.
///
/// ```
/// use bksim_expr::{Composition, Pool, Tape, TapeSeries};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let pool = Pool::new();
/// let e = pool.parse("k*x")?;
/// let id = |name| pool.find_symbol(name).expect("was parsed");
/// let f = Tape::compile(&pool, &[e], &[id("x")], &[id("k")])?;
///
/// // The coefficients of x' = k x from the input x: x_k+1 = f_k/(k + 1).
/// let mut composition = Composition::new(1, 1);
/// let mut series = TapeSeries::of(&f).ok_or("a product has a series")?;
/// let mut x = vec![composition.input(0)];
/// for k in 0..3 {
///     let slope = series.extend(&mut composition, &[Some(x[k])])[0].ok_or("it grows")?;
///     let part = composition.constant(1.0 / (k + 1) as f64);
///     x.push(composition.multiply(part, slope));
/// }
/// let tape = composition.finish(&x[1..]);
///
/// let mut workspace = tape.workspace(&[2.0]);
/// let mut out = [0.0; 3];
/// tape.evaluate(&mut workspace, &[3.0], &mut out);
/// assert_eq!(out, [6.0, 6.0, 4.0]);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct TapeSeries {
    rows: Vec<Row>,
    /// Rows of the outputs.
    outputs: Vec<usize>,
    n_inputs: usize,
    n_parameters: usize,
}

/// The series of one number.
#[derive(Clone, Debug)]
struct Row {
    rule: Rule,
    /// True where it does not depend on time.
    is_fixed: bool,
    coefficients: Vec<Coefficient>,
}

/// The way to the next coefficient; operands are rows.
#[derive(Clone, Copy, Debug)]
enum Rule {
    Constant(f64),
    Parameter(usize),
    Input(usize),
    /// Any operation on numbers that do not depend on time.
    Fixed(Action, [usize; 3]),
    Add(usize, usize),
    Subtract(usize, usize),
    Negate(usize),
    Multiply(usize, usize),
    Divide(usize, usize),
    Sqrt(usize),
    /// `c′ = s a′`. The first coefficient is that of an operation, or zero.
    Integral {
        first: Option<(Action, [usize; 2])>,
        slope: usize,
        of: usize,
    },
}

impl TapeSeries {
    /// Without coefficients so far; `None` where a function of the inputs has kinks or jumps, at which a series ends.
    pub fn of(tape: &Tape) -> Option<Self> {
        let mut reader = Reader::default();
        let fixed = tape.constants.iter().map(|&value| Rule::Constant(value));
        let fixed = fixed.chain((0..tape.n_parameters).map(Rule::Parameter));
        let mut registers: Vec<usize> = fixed.map(|rule| reader.push(rule)).collect();
        registers.extend((0..tape.n_inputs).map(|i| reader.push(Rule::Input(i))));
        for (number, Instruction { action, a, b, c }) in tape.operations() {
            debug_assert_eq!(number, registers.len(), "registers are written in their order");
            let operands = [a, b, c].map(|register| registers[register as usize]);
            let exponent = tape.constants.get(b as usize).copied();
            registers.push(reader.read(action, operands, exponent)?);
        }
        Some(Self {
            outputs: tape.outputs.iter().map(|&output| registers[output as usize]).collect(),
            rows: reader.rows,
            n_inputs: tape.n_inputs,
            n_parameters: tape.n_parameters,
        })
    }

    /// The next coefficient of every output, from that of every input.
    ///
    /// # Panics
    /// When the tape has another number of inputs, or of parameters than the composition.
    pub fn extend(
        &mut self,
        composition: &mut Composition,
        inputs: &[Coefficient],
    ) -> Vec<Coefficient> {
        assert_eq!(inputs.len(), self.n_inputs, "number of inputs");
        assert_eq!(self.n_parameters, composition.n_parameters(), "number of parameters");
        for row in 0..self.rows.len() {
            let next = self.next(composition, row, inputs);
            self.rows[row].coefficients.push(next);
        }
        let last = |&row: &usize| self.rows[row].coefficients.last().copied().flatten();
        self.outputs.iter().map(last).collect()
    }

    fn coefficient(&self, row: usize, k: usize) -> Coefficient {
        self.rows[row].coefficients[k]
    }

    /// The next coefficient of a row.
    fn next(&self, to: &mut Composition, row: usize, inputs: &[Coefficient]) -> Coefficient {
        let Row { rule, coefficients, .. } = &self.rows[row];
        let k = coefficients.len();
        let at = |row: usize| self.coefficient(row, k);
        match *rule {
            Rule::Input(i) => inputs[i],
            Rule::Add(a, b) => plus(to, at(a), at(b)),
            Rule::Subtract(a, b) => minus(to, at(a), at(b)),
            Rule::Negate(a) => minus(to, None, at(a)),
            Rule::Multiply(a, b) if a == b => self.square(to, a, k),
            Rule::Multiply(a, b) => {
                let inner = self.products(to, (a, b), k, 1..k);
                let last = times(to, self.coefficient(a, 0), at(b));
                let sum = plus(to, inner, last);
                if k == 0 {
                    return sum;
                }
                let last = times(to, at(a), self.coefficient(b, 0));
                plus(to, sum, last)
            }
            _ if k == 0 => self.first(to, *rule),
            Rule::Constant(_) | Rule::Parameter(_) | Rule::Fixed(..) => None,
            Rule::Divide(a, b) => {
                let inner = self.products(to, (b, row), k, 1..k);
                let known = minus(to, at(a), inner);
                let last = times(to, at(b), self.coefficient(row, 0));
                let rest = minus(to, known, last);
                self.over(to, rest, 1.0, b)
            }
            Rule::Sqrt(a) => {
                let inner = self.inner_squares(to, row, k);
                let rest = minus(to, at(a), inner);
                self.over(to, rest, 0.5, row)
            }
            Rule::Integral { slope, of, .. } => {
                let mut sum = None;
                for i in 1..k {
                    let weighted = scaled(to, i as f64, self.coefficient(of, i));
                    let product = times(to, weighted, self.coefficient(slope, k - i));
                    sum = plus(to, sum, product);
                }
                let mean = scaled(to, 1.0 / k as f64, sum);
                let last = times(to, at(of), self.coefficient(slope, 0));
                plus(to, mean, last)
            }
        }
    }

    /// The first coefficient of a row whose rule is for the others.
    fn first(&self, to: &mut Composition, rule: Rule) -> Coefficient {
        let value = |row: usize| self.coefficient(row, 0);
        let mut emit = |action: Action, [a, b, c]: [usize; 3]| {
            let mut operand = |row: usize| value(row).unwrap_or_else(|| to.constant(0.0));
            let operands = [a, b, c].map(&mut operand);
            Some(to.emit_three(action, operands))
        };
        match rule {
            Rule::Constant(value) => Some(to.constant(value)),
            Rule::Parameter(i) => Some(Value::parameter(i)),
            Rule::Fixed(action, operands) => emit(action, operands),
            Rule::Divide(a, b) => emit(Action::Divide, [a, b, a]),
            Rule::Sqrt(a) => emit(Action::Call(Function::Sqrt), [a; 3]),
            Rule::Integral { first, .. } => {
                let (action, [a, b]) = first?;
                emit(action, [a, b, a])
            }
            _ => None,
        }
    }

    /// `Σ aᵢ bₖ₋ᵢ`. Those of the highest order, known last, are left to the caller, so that the others need not wait.
    fn products(
        &self,
        to: &mut Composition,
        (a, b): (usize, usize),
        k: usize,
        range: std::ops::Range<usize>,
    ) -> Coefficient {
        range.fold(None, |sum, i| {
            let product = times(to, self.coefficient(a, i), self.coefficient(b, k - i));
            plus(to, sum, product)
        })
    }

    fn square(&self, to: &mut Composition, a: usize, k: usize) -> Coefficient {
        let inner = self.inner_squares(to, a, k);
        let last = times(to, self.coefficient(a, 0), self.coefficient(a, k));
        let last = if k == 0 { last } else { plus(to, last, last) };
        plus(to, inner, last)
    }

    /// `Σ aᵢ aₖ₋ᵢ` without the ends, each product once.
    fn inner_squares(&self, to: &mut Composition, a: usize, k: usize) -> Coefficient {
        let half = self.products(to, (a, a), k, 1..k.div_ceil(2));
        let both = plus(to, half, half);
        if k == 0 || k % 2 == 1 {
            return both;
        }
        let middle = self.coefficient(a, k / 2);
        let middle = times(to, middle, middle);
        plus(to, both, middle)
    }

    /// `a · part / b₀`, with one reciprocal for all orders.
    fn over(&self, to: &mut Composition, a: Coefficient, part: f64, b: usize) -> Coefficient {
        let (part, first) = (to.constant(part), self.coefficient(b, 0));
        let first = first.unwrap_or_else(|| to.constant(0.0));
        let reciprocal = to.divide(part, first);
        a.map(|a| to.multiply(a, reciprocal))
    }
}

fn plus(to: &mut Composition, a: Coefficient, b: Coefficient) -> Coefficient {
    match (a, b) {
        (Some(a), Some(b)) => Some(to.add(a, b)),
        _ => a.or(b),
    }
}

fn minus(to: &mut Composition, a: Coefficient, b: Coefficient) -> Coefficient {
    match (a, b) {
        (Some(a), Some(b)) => Some(to.subtract(a, b)),
        (None, Some(b)) => Some(to.emit_three(Action::Negate, [b; 3])),
        _ => a,
    }
}

fn times(to: &mut Composition, a: Coefficient, b: Coefficient) -> Coefficient {
    Some(to.multiply(a?, b?))
}

fn scaled(to: &mut Composition, part: f64, a: Coefficient) -> Coefficient {
    if part == 1.0 {
        return a;
    }
    let part = to.constant(part);
    a.map(|a| to.multiply(part, a))
}

/// Reads the operations of a tape as rules.
#[derive(Default)]
struct Reader {
    rows: Vec<Row>,
    /// Sine and cosine, or those of a hyperbola, by their angle.
    pairs: HashMap<(bool, usize), [usize; 2]>,
}

impl Reader {
    fn push(&mut self, rule: Rule) -> usize {
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
    fn read(
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
                    _ => Rule::Multiply(a, b),
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
