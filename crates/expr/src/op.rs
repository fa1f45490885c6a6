//! The operator table: every operation's name, arity, value and derivative.
//!
//! This is the one place that calls the elementary functions of `f64`, but for sine and cosine,
//! which `eval::sincos` computes; all evaluators and constant folding read their values from here,
//! so they agree bit for bit.

#![expect(clippy::disallowed_methods, reason = "the one place that may call them")]

use crate::eval::sin_cos;
use crate::pool::{Expr, Pool};

/// A named function of one, two or three arguments.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
#[expect(missing_docs, reason = "each variant is the function of its name")]
pub enum Function {
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Exp,
    Ln,
    Sqrt,
    Abs,
    Sign,
    Atan2,
    Min,
    Max,
    Lt,
    Le,
    Gt,
    Ge,
    /// `if(c, a, b)` is `a` where `c` is not zero and `b` elsewhere.
    If,
}

/// What a node does with its operands.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) enum Op {
    Number,
    Symbol,
    Pi,
    /// Sums; a chain leans left and its terms are in canonical order.
    Add,
    /// Products; a chain leans left, a numeric coefficient is the left operand of the top node.
    Mul,
    Pow,
    /// The two branches of an `if`; never seen outside of it.
    Pair,
    Call(Function),
}

/// One row of the table of functions.
struct Row {
    function: Function,
    name: &'static str,
    arity: usize,
    value: fn(f64, f64) -> f64,
    derivative: Derivative,
}

/// How a function is differentiated.
enum Derivative {
    /// `f'(a)`, given the argument and the value `f(a)`.
    One(fn(&Pool, Expr, Expr) -> Expr),
    /// `(∂f/∂a, ∂f/∂b)`.
    Two(fn(&Pool, Expr, Expr) -> (Expr, Expr)),
    /// Piecewise constant: zero wherever the derivative exists.
    Zero,
    /// Branch by branch; carried out by `diff`.
    Branches,
}

const fn row(
    function: Function,
    name: &'static str,
    arity: usize,
    value: fn(f64, f64) -> f64,
    derivative: Derivative,
) -> Row {
    Row { function, name, arity, value, derivative }
}

use Derivative::{Branches, One, Two, Zero};
use Function as F;

/// The table, in the order of the variants of [`Function`].
#[rustfmt::skip]
const TABLE: [Row; 22] = [
    row(F::Sin,   "sin",   1, |a, _| sin_cos(a).0, One(|p, a, _| p.cos(a))),
    row(F::Cos,   "cos",   1, |a, _| sin_cos(a).1, One(|p, a, _| p.neg(p.sin(a)))),
    row(F::Tan,   "tan",   1, |a, _| a.tan(),  One(|p, _, f| p.add(p.one(), p.powi(f, 2)))),
    row(F::Asin,  "asin",  1, |a, _| a.asin(), One(|p, a, _| p.powi(p.sqrt(one_minus_square(p, a)), -1))),
    row(F::Acos,  "acos",  1, |a, _| a.acos(), One(|p, a, _| p.neg(p.powi(p.sqrt(one_minus_square(p, a)), -1)))),
    row(F::Atan,  "atan",  1, |a, _| a.atan(), One(|p, a, _| p.powi(p.add(p.one(), p.powi(a, 2)), -1))),
    row(F::Sinh,  "sinh",  1, |a, _| a.sinh(), One(|p, a, _| p.cosh(a))),
    row(F::Cosh,  "cosh",  1, |a, _| a.cosh(), One(|p, a, _| p.sinh(a))),
    row(F::Tanh,  "tanh",  1, |a, _| a.tanh(), One(|p, _, f| one_minus_square(p, f))),
    row(F::Exp,   "exp",   1, |a, _| a.exp(),  One(|_, _, f| f)),
    row(F::Ln,    "ln",    1, |a, _| a.ln(),   One(|p, a, _| p.powi(a, -1))),
    row(F::Sqrt,  "sqrt",  1, |a, _| a.sqrt(), One(|p, _, f| p.mul(p.rational(1, 2), p.powi(f, -1)))),
    row(F::Abs,   "abs",   1, |a, _| a.abs(),  One(|p, a, _| p.sign(a))),
    row(F::Sign,  "sign",  1, |a, _| sign(a),  Zero),
    row(F::Atan2, "atan2", 2, f64::atan2,      Two(atan2_derivative)),
    row(F::Min,   "min",   2, |a, b| if a <= b || a.is_nan() { a } else { b },
        Two(|p, a, b| selected(p, p.call_two(F::Le, a, b)))),
    row(F::Max,   "max",   2, |a, b| if a >= b || a.is_nan() { a } else { b },
        Two(|p, a, b| selected(p, p.call_two(F::Ge, a, b)))),
    row(F::Lt,    "lt",    2, |a, b| f64::from(a < b),  Zero),
    row(F::Le,    "le",    2, |a, b| f64::from(a <= b), Zero),
    row(F::Gt,    "gt",    2, |a, b| f64::from(a > b),  Zero),
    row(F::Ge,    "ge",    2, |a, b| f64::from(a >= b), Zero),
    // Three operands: the value is computed by `select`.
    row(F::If,    "if",    3, |_, _| f64::NAN, Branches),
];

/// −1, 0 or 1 with the sign of `a`; zeros and NaN are returned unchanged.
fn sign(a: f64) -> f64 {
    if a == 0.0 || a.is_nan() { a } else { a.signum() }
}

/// `1 − a²`.
fn one_minus_square(pool: &Pool, a: Expr) -> Expr {
    pool.sub(pool.one(), pool.powi(a, 2))
}

/// d atan2(y, x) = (x dy − y dx) / (x² + y²).
fn atan2_derivative(pool: &Pool, y: Expr, x: Expr) -> (Expr, Expr) {
    let scale = pool.powi(pool.add(pool.powi(x, 2), pool.powi(y, 2)), -1);
    (pool.mul(x, scale), pool.neg(pool.mul(y, scale)))
}

/// Weights of the two operands of which `condition` takes the first where it holds.
fn selected(pool: &Pool, condition: Expr) -> (Expr, Expr) {
    (
        pool.select(condition, pool.one(), pool.zero()),
        pool.select(condition, pool.zero(), pool.one()),
    )
}

impl Function {
    fn row(self) -> &'static Row {
        &TABLE[self as usize]
    }

    /// The name in text, as in `sin(x)`.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Number of arguments.
    pub fn arity(self) -> usize {
        self.row().arity
    }

    /// The function called `name`.
    pub fn from_name(name: &str) -> Option<Self> {
        TABLE.iter().find(|row| row.name == name).map(|row| row.function)
    }

    /// The function at a position of the table, which is its discriminant.
    #[cfg(feature = "jit")]
    pub(crate) fn from_index(index: usize) -> Option<Self> {
        TABLE.get(index).map(|row| row.function)
    }

    /// All function names, in the order of the table.
    pub fn names() -> impl Iterator<Item = &'static str> {
        TABLE.iter().map(|row| row.name)
    }

    /// Whether the derivative is zero wherever it exists.
    pub(crate) fn is_piecewise_constant(self) -> bool {
        matches!(self.row().derivative, Zero)
    }

    /// Value at `a` (and `b` for two arguments), as `f64` computes it.
    pub(crate) fn value(self, a: f64, b: f64) -> f64 {
        (self.row().value)(a, b)
    }

    /// Partial derivatives with respect to the first and second argument; `None` for `if`.
    pub(crate) fn derivative(
        self,
        pool: &Pool,
        value: Expr,
        a: Expr,
        b: Expr,
    ) -> Option<(Expr, Expr)> {
        match self.row().derivative {
            One(rule) => Some((rule(pool, a, value), pool.zero())),
            Two(rule) => Some(rule(pool, a, b)),
            Zero => Some((pool.zero(), pool.zero())),
            Branches => None,
        }
    }
}

/// `if(condition, then, otherwise)` on values; a NaN condition gives NaN.
pub(crate) fn select(condition: f64, then: f64, otherwise: f64) -> f64 {
    if condition.is_nan() {
        condition
    } else if condition == 0.0 {
        otherwise
    } else {
        then
    }
}

/// Largest integer exponent computed by multiplication.
pub(crate) const MAX_MULTIPLIED_POWER: u64 = 64;

/// `base^exponent`; small integer powers by multiplication, as the tape does.
pub(crate) fn power(base: f64, exponent: f64) -> f64 {
    match small_integer(exponent) {
        Some(n) if n < 0 => 1.0 / integer_power(base, n.unsigned_abs()),
        Some(n) => integer_power(base, n.unsigned_abs()),
        None => base.powf(exponent),
    }
}

/// The exponent as an integer if powers of it are computed by multiplication.
pub(crate) fn small_integer(exponent: f64) -> Option<i64> {
    let is_small = exponent.fract() == 0.0 && exponent.abs() <= MAX_MULTIPLIED_POWER as f64;
    #[expect(clippy::cast_possible_truncation, reason = "an integer of at most 64")]
    is_small.then_some(exponent as i64)
}

/// `base^n` by repeated squaring.
fn integer_power(base: f64, mut n: u64) -> f64 {
    let mut result = 1.0;
    let mut square = base;
    while n > 0 {
        if n & 1 == 1 {
            result *= square;
        }
        square *= square;
        n >>= 1;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_rows_stand_in_the_order_of_the_variants() {
        for (index, row) in TABLE.iter().enumerate() {
            assert_eq!(row.function as usize, index, "{}", row.name);
            assert_eq!(Function::from_name(row.name), Some(row.function));
        }
    }

    #[test]
    fn powers_agree_with_powf() {
        for base in [-2.5, -0.0, 0.0, 0.3, 7.0, f64::INFINITY] {
            for n in -9..=9 {
                let (ours, reference) = (power(base, f64::from(n)), base.powi(n));
                let close = (ours - reference).abs() <= 1e-14 * reference.abs();
                assert!(close || ours == reference, "{base}^{n}: {ours} is not {reference}");
            }
        }
    }
}
