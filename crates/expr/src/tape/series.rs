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

mod reader;

use self::reader::Reader;
use super::composition::{Composition, Value};
use super::{Action, Instruction, Tape};
use crate::op::Function;

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

    /// About the number of operations up to each of so many orders.
    pub fn operation_counts(&self, n_orders: usize) -> Vec<usize> {
        let is_fixed = |row: usize| self.rows[row].is_fixed;
        let of_row = |row: &Row, k: usize| match row.rule {
            Rule::Constant(_) | Rule::Parameter(_) | Rule::Input(_) | Rule::Fixed(..) => 0,
            Rule::Multiply(a, b) if is_fixed(a) || is_fixed(b) => 1,
            Rule::Divide(_, b) if is_fixed(b) => 1,
            Rule::Add(..) | Rule::Subtract(..) | Rule::Negate(_) => 1,
            Rule::Multiply(a, b) if a == b => k + 2,
            Rule::Multiply(..) => 2 * k + 1,
            Rule::Divide(..) => 2 * k + 2,
            Rule::Sqrt(_) => k + 3,
            Rule::Integral { .. } => 2 * k + 3,
        };
        let of_order = |k: usize| self.rows.iter().map(|row| of_row(row, k)).sum::<usize>();
        let mut so_far = 0;
        (0..n_orders)
            .map(|k| {
                so_far += of_order(k);
                so_far
            })
            .collect()
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
        // Those known first come first: of the lowest orders, which are in the middle.
        let mut order: Vec<usize> = range.collect();
        order.sort_by_key(|&i| i.max(k - i));
        order.into_iter().fold(None, |sum, i| {
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
