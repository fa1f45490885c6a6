//! Numbers of 106 bits: unevaluated sums of two `f64`, and the elementary functions on them.
//!
//! Sum and product keep the rounding error of each operation: T. J. Dekker, *A floating-point
//! technique for extending the available precision*, Numer. Math. 18 (1971). The functions start
//! from the value in `f64` and correct it by one Newton step, which doubles the digits, or sum a
//! Taylor series of a small argument.

use crate::op::{Function, power, select};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// `high + low` with `|low|` at most half a unit in the last place of `high`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extended {
    high: f64,
    low: f64,
}

/// π to 106 bits.
pub(super) const PI: Extended =
    Extended { high: std::f64::consts::PI, low: 1.224_646_799_147_353_2e-16 };
/// ln 2 to 106 bits.
const LN_2: Extended = Extended { high: std::f64::consts::LN_2, low: 2.319_046_813_846_299_6e-17 };
const ONE: Extended = Extended { high: 1.0, low: 0.0 };
const NAN: Extended = Extended { high: f64::NAN, low: 0.0 };

/// Largest angle that is reduced with enough digits left.
const MAX_ANGLE: f64 = 1e9;
/// Terms of a Taylor series at an argument below 1: 1/27! is below 2⁻⁹³, and each further pair of
/// terms gains more than nine bits.
const N_TERMS: i32 = 32;

/// `a + b` exactly.
fn two_sum(a: f64, b: f64) -> Extended {
    let high = a + b;
    let of_b = high - a;
    let low = (a - (high - of_b)) + (b - of_b);
    Extended { high, low: if high.is_finite() { low } else { 0.0 } }
}

/// `a · b` exactly.
fn two_product(a: f64, b: f64) -> Extended {
    let high = a * b;
    Extended { high, low: if high.is_finite() { a.mul_add(b, -high) } else { 0.0 } }
}

impl From<f64> for Extended {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl From<i128> for Extended {
    fn from(value: i128) -> Self {
        let high = value as f64;
        // The largest value rounds up to 2¹²⁷, which is no i128; the difference is 1 then.
        #[expect(clippy::cast_possible_truncation, reason = "an integer of at most 127 bits")]
        let rest = value.saturating_sub(high as i128);
        two_sum(high, rest as f64)
    }
}

impl Neg for Extended {
    type Output = Self;
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Add for Extended {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (sum, rest) = (two_sum(self.high, other.high), two_sum(self.low, other.low));
        let first = two_sum(sum.high, sum.low + rest.high);
        two_sum(first.high, first.low + rest.low)
    }
}

impl Sub for Extended {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Extended {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let product = two_product(self.high, other.high);
        two_sum(product.high, product.low + (self.high * other.low + self.low * other.high))
    }
}

impl Div for Extended {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        if !first.is_finite() || other.high.is_infinite() {
            return Self::from(first);
        }
        // Three digits of a long division, each an f64.
        let rest = self - other * Self::from(first);
        let second = rest.high / other.high;
        let rest = rest - other * Self::from(second);
        two_sum(first, second) + Self::from(rest.high / other.high)
    }
}

impl Extended {
    /// The nearest `f64`.
    pub(super) fn high(self) -> f64 {
        self.high
    }

    /// True if the value is an `f64`.
    pub(super) fn is_double(self) -> bool {
        self.low == 0.0
    }

    fn scaled(self, factor: f64) -> Self {
        Self { high: self.high * factor, low: self.low * factor }
    }

    /// The value of a function; `other` is the second argument where there are two.
    pub(super) fn call(self, function: Function, other: Self) -> Self {
        let less = |a: Self, b: Self| (a - b).high < 0.0;
        let flag = |holds: bool| Self::from(f64::from(u8::from(holds)));
        match function {
            Function::Sin => self.sin_cos().0,
            Function::Cos => self.sin_cos().1,
            Function::Tan => {
                let (sin, cos) = self.sin_cos();
                sin / cos
            }
            Function::Asin => self.atan2(self.other_leg()),
            Function::Acos => self.other_leg().atan2(self),
            Function::Atan => self.atan2(ONE),
            Function::Sinh => self.sinh(),
            Function::Cosh => (self.exp() + (-self).exp()).scaled(0.5),
            Function::Tanh if self.high.abs() > 40.0 => Self::from(self.high.signum()),
            Function::Tanh => self.sinh() / (self.exp() + (-self).exp()).scaled(0.5),
            Function::Exp => self.exp(),
            Function::Ln => self.ln(),
            Function::Sqrt => self.sqrt(),
            Function::Abs if self.high < 0.0 => -self,
            Function::Sign => Self::from(Function::Sign.value(self.high, 0.0)),
            Function::Floor => self.floor(),
            Function::Atan2 => self.atan2(other),
            Function::Min if less(other, self) => other,
            Function::Max if less(self, other) => other,
            Function::Abs | Function::Min | Function::Max => self,
            Function::Lt => flag(less(self, other)),
            Function::Le => flag(!less(other, self)),
            Function::Gt => flag(less(other, self)),
            Function::Ge => flag(!less(self, other)),
            // Three operands: never called.
            Function::If => Self::from(select(self.high, other.high, other.high)),
        }
    }

    /// The largest integer that is not larger.
    fn floor(self) -> Self {
        let high = Function::Floor.value(self.high, 0.0);
        // Where the first number is an integer, the second decides.
        if high == self.high {
            two_sum(high, Function::Floor.value(self.low, 0.0))
        } else {
            Self::from(high)
        }
    }

    /// sqrt(1 − x²)
    fn other_leg(self) -> Self {
        ((ONE - self) * (ONE + self)).sqrt()
    }

    /// `self^n` by repeated squaring.
    pub(super) fn powi(self, n: i64) -> Self {
        let (mut result, mut square, mut left) = (ONE, self, n.unsigned_abs());
        while left > 0 {
            if left & 1 == 1 {
                result = result * square;
            }
            square = square * square;
            left >>= 1;
        }
        if n < 0 { ONE / result } else { result }
    }

    /// `self^exponent`, by logarithms where they exist.
    pub(super) fn power(self, exponent: Self) -> Self {
        if self.high > 0.0 {
            (exponent * self.ln()).exp()
        } else {
            Self::from(power(self.high, exponent.high))
        }
    }

    fn sqrt(self) -> Self {
        let root = Function::Sqrt.value(self.high, 0.0);
        if root == 0.0 || !root.is_finite() {
            return Self::from(root);
        }
        let rest = self - two_product(root, root);
        two_sum(root, rest.high / (2.0 * root))
    }

    /// Σ xⁿ/n! over the odd (`first` = 1) or even (`first` = 0) n with alternating or equal signs.
    fn taylor(self, first: i32, sign: f64) -> Self {
        let square = (self * self).scaled(sign);
        let mut term = if first == 1 { self } else { ONE };
        let mut sum = term;
        for n in (first + 1..N_TERMS).step_by(2) {
            term = term * square / Self::from(f64::from(n) * f64::from(n + 1));
            sum = sum + term;
        }
        sum
    }

    /// Sine and cosine by quarter turns: x = k π/2 + r with |r| ≤ π/4.
    fn sin_cos(self) -> (Self, Self) {
        if self.high.is_nan() || self.high.abs() > MAX_ANGLE {
            return (NAN, NAN);
        }
        let quarter = PI.scaled(0.5);
        let turns = (self.high / quarter.high).round();
        let rest = self - quarter * Self::from(turns);
        let (sin, cos) = (rest.taylor(1, -1.0), rest.taylor(0, -1.0));
        match turns.rem_euclid(4.0) {
            0.0 => (sin, cos),
            1.0 => (cos, -sin),
            2.0 => (-sin, -cos),
            _ => (-cos, sin),
        }
    }

    /// x = k ln 2 + r with |r| ≤ ½ ln 2: e^x = 2ᵏ (sinh r + cosh r).
    fn exp(self) -> Self {
        let double = Function::Exp.value(self.high, 0.0);
        if !double.is_normal() {
            return Self::from(double);
        }
        let k = (self.high / LN_2.high).round();
        let rest = self - LN_2 * Self::from(k);
        let value = rest.taylor(1, 1.0) + rest.taylor(0, 1.0);
        // Two factors, since 2ᵏ itself may overflow.
        let half = (k / 2.0).trunc();
        value.scaled(power(2.0, half)).scaled(power(2.0, k - half))
    }

    fn sinh(self) -> Self {
        if self.high.abs() < 0.5 {
            self.taylor(1, 1.0)
        } else {
            (self.exp() - (-self).exp()).scaled(0.5)
        }
    }

    /// y = y₀ + x e^(−y₀) − 1
    fn ln(self) -> Self {
        let start = Self::from(Function::Ln.value(self.high, 0.0));
        if !start.high.is_finite() {
            return start;
        }
        start + (self * (-start).exp() - ONE)
    }

    /// The angle of (x, y), turned back by its value in `f64` to leave a small one.
    fn atan2(self, x: Self) -> Self {
        let start = Self::from(Function::Atan2.value(self.high, x.high));
        let (sin, cos) = start.sin_cos();
        let (along, across) = (x * cos + self * sin, self * cos - x * sin);
        if !along.high.is_finite() || along.high == 0.0 {
            return start;
        }
        start + across / along
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The values agree to 29 digits.
    fn check(what: &str, a: Extended, b: Extended) {
        let difference = (a - b).high.abs();
        assert!(difference <= 1e-29 * b.high.abs().max(1.0), "{what}: {a:?} is not {b:?}");
    }

    #[test]
    fn functions_undo_their_inverses() {
        let half = Extended::from(0.5);
        for step in 1..40 {
            let x = Extended::from(0.07 * f64::from(step)) / Extended::from(3.0);
            let call = |f: Function, e: Extended| e.call(f, e);
            check("exp ln", call(Function::Exp, call(Function::Ln, x)), x);
            check("tan atan", call(Function::Tan, call(Function::Atan, x)), x);
            check("sin asin", call(Function::Sin, call(Function::Asin, x * half)), x * half);
            check("cos acos", call(Function::Cos, call(Function::Acos, x * half)), x * half);
            check("sqrt", call(Function::Sqrt, x) * call(Function::Sqrt, x), x);
            check("power", x.power(ONE / Extended::from(3.0)).powi(3), x);
            let (sinh, cosh) = (call(Function::Sinh, x), call(Function::Cosh, x));
            check("sinh", cosh * cosh - sinh * sinh, ONE);
            check("tanh", call(Function::Tanh, x) * cosh, sinh);
        }
    }

    #[test]
    fn known_values_have_thirty_digits() {
        let third = ONE / Extended::from(3.0);
        check("sin π/6", (PI / Extended::from(6.0)).sin_cos().0, Extended::from(0.5));
        check("cos π/3", (PI * third).sin_cos().1, Extended::from(0.5));
        check("atan 1", ONE.atan2(ONE), PI.scaled(0.25));
        check("ln 2", Extended::from(2.0).ln(), LN_2);
        // e to 32 digits: 2.71828182845904523536028747135266
        let e = Extended { high: std::f64::consts::E, low: 1.445_646_891_729_250_2e-16 };
        check("e", ONE.exp(), e);
        check("10^30", Extended::from(10i128.pow(30)), Extended::from(10.0).powi(30));
    }
}
