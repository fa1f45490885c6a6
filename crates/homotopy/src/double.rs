//! [`Double`]: complex numbers of twice the digits, as sums of two.
//!
//! ```text
//! a + b = s + e,  a b = p + e        exactly, s and p rounded
//! ```
//!
//! Source: T. J. Dekker, *A floating-point technique for extending the available precision*, Numer. Math. 18 (1971) 224.

use std::ops::{Add, Mul};

use crate::C;

/// A real number as a sum of a number and what its rounding left out.
#[derive(Clone, Copy, Default)]
struct Sum(f64, f64);

impl Add for Sum {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let s = self.0 + other.0;
        let back = s - self.0;
        let e = (self.0 - (s - back)) + (other.0 - back) + self.1 + other.1;
        let high = s + e;
        Self(high, e - (high - s))
    }
}

impl Mul for Sum {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let p = self.0 * other.0;
        let e = self.0.mul_add(other.0, -p) + (self.0 * other.1 + self.1 * other.0);
        let high = p + e;
        Self(high, e - (high - p))
    }
}

/// A complex number of about 31 digits.
#[derive(Clone, Copy, Default)]
pub(crate) struct Double {
    re: Sum,
    im: Sum,
}

impl From<C> for Double {
    fn from(c: C) -> Self {
        Self { re: Sum(c.re, 0.0), im: Sum(c.im, 0.0) }
    }
}

impl Double {
    /// The nearest number of half the digits.
    pub(crate) fn rounded(self) -> C {
        C::new(self.re.0, self.im.0)
    }
}

impl Add for Double {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }
}

impl Mul for Double {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let minus = |Sum(a, b): Sum| Sum(-a, -b);
        Self {
            re: self.re * other.re + minus(self.im * other.im),
            im: self.re * other.im + self.im * other.re,
        }
    }
}
