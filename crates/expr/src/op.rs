//! The operator table: the name, arity and value of every function. Derivatives, which build
//! expressions, are rows of `diff::rules`.
//!
//! Only this module calls the elementary functions of `f64`; `sincos`, `elementary` and `arctangent`
//! compute those that lanes take together. All evaluators and constant folding take their values
//! from here, so they agree bit for bit.

#![expect(clippy::disallowed_methods, reason = "the only module that may call them")]

use crate::arctangent::{atan2, atan2_lanes};
use crate::elementary::{exp, exp_lanes, ln, ln_lanes, tanh, tanh_lanes};
use crate::sincos::sin_cos;

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
    Floor,
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

/// The operation of a node on its operands.
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
    /// A function with a name; the payload is its index.
    Named,
    Call(Function),
}

/// One row of the table of functions.
struct FunctionRow {
    function: Function,
    name: &'static str,
    arity: usize,
    value: fn(f64, f64) -> f64,
}

const fn row(
    function: Function,
    name: &'static str,
    arity: usize,
    value: fn(f64, f64) -> f64,
) -> FunctionRow {
    FunctionRow { function, name, arity, value }
}

use Function as F;

/// The table, in the order of the variants of [`Function`].
#[rustfmt::skip]
const TABLE: [FunctionRow; 23] = [
    row(F::Sin,   "sin",   1, |a, _| sin_cos(a).0),
    row(F::Cos,   "cos",   1, |a, _| sin_cos(a).1),
    row(F::Tan,   "tan",   1, |a, _| a.tan()),
    row(F::Asin,  "asin",  1, |a, _| a.asin()),
    row(F::Acos,  "acos",  1, |a, _| a.acos()),
    row(F::Atan,  "atan",  1, |a, _| atan2(a, 1.0)),
    row(F::Sinh,  "sinh",  1, |a, _| a.sinh()),
    row(F::Cosh,  "cosh",  1, |a, _| a.cosh()),
    row(F::Tanh,  "tanh",  1, |a, _| tanh(a)),
    row(F::Exp,   "exp",   1, |a, _| exp(a)),
    row(F::Ln,    "ln",    1, |a, _| ln(a)),
    row(F::Sqrt,  "sqrt",  1, |a, _| a.sqrt()),
    row(F::Abs,   "abs",   1, |a, _| a.abs()),
    row(F::Sign,  "sign",  1, |a, _| sign(a)),
    row(F::Floor, "floor", 1, |a, _| a.floor()),
    row(F::Atan2, "atan2", 2, atan2),
    row(F::Min,   "min",   2, |a, b| if a <= b || a.is_nan() { a } else { b }),
    row(F::Max,   "max",   2, |a, b| if a >= b || a.is_nan() { a } else { b }),
    row(F::Lt,    "lt",    2, |a, b| f64::from(a < b)),
    row(F::Le,    "le",    2, |a, b| f64::from(a <= b)),
    row(F::Gt,    "gt",    2, |a, b| f64::from(a > b)),
    row(F::Ge,    "ge",    2, |a, b| f64::from(a >= b)),
    // Three operands: the value is computed by `select`.
    row(F::If,    "if",    3, |_, _| f64::NAN),
];

/// −1, 0 or 1 with the sign of `a`; zeros and NaN are returned unchanged.
fn sign(a: f64) -> f64 {
    if a == 0.0 || a.is_nan() { a } else { a.signum() }
}

impl Function {
    fn row(self) -> &'static FunctionRow {
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
    #[cfg(target_arch = "x86_64")]
    pub(crate) fn from_index(index: usize) -> Option<Self> {
        TABLE.get(index).map(|row| row.function)
    }

    /// All function names, in the order of the table.
    pub fn names() -> impl Iterator<Item = &'static str> {
        TABLE.iter().map(|row| row.name)
    }

    /// Value at `a` (and `b` for two arguments).
    pub(crate) fn value(self, a: f64, b: f64) -> f64 {
        (self.row().value)(a, b)
    }

    /// Values at `a` (and `b`) in `N` lanes, bit for bit those of [`Self::value`].
    #[expect(clippy::inline_always, reason = "the caller's instruction set must reach the lanes")]
    #[inline(always)]
    pub(crate) fn lanes<const N: usize>(self, a: [f64; N], b: [f64; N]) -> [f64; N] {
        match self {
            F::Exp => exp_lanes(a),
            F::Ln => ln_lanes(a),
            F::Tanh => tanh_lanes(a),
            F::Atan => atan2_lanes(a, [1.0; N]),
            F::Atan2 => atan2_lanes(a, b),
            _ => std::array::from_fn(|lane| self.value(a[lane], b[lane])),
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
