//! Greatest common divisors of polynomials in several variables with integer coefficients.
//!
//! The heuristic algorithm: at an integer ξ beyond twice the coefficients, the divisor of the values
//! has the divisor of the polynomials as its digits to the base ξ; division proves it. B. W. Char,
//! K. O. Geddes, G. H. Gonnet, *GCDHEU: heuristic polynomial GCD algorithm based on integer GCD
//! computation*, J. Symb. Comput. 7 (1989). Work is bounded: what is too much has no divisor.

use num_bigint::BigInt;
use num_traits::{One, Signed, Zero};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Exponents of the variables; the order of terms is lexicographic.
type Exponents = Vec<u32>;

/// A polynomial by its terms; none is zero.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub(super) struct IntegerPoly(pub(super) BTreeMap<Exponents, BigInt>);

/// Values ξ that are tried.
const MAX_TRIED: usize = 6;
/// Longest integer that is met on the way, in bits.
const MAX_BITS: u64 = 40_000;
/// Steps of one exact division, each of which subtracts a multiple of the divisor.
const MAX_STEPS: usize = 4_000;

impl IntegerPoly {
    fn constant(n_variables: usize, value: BigInt) -> Self {
        let terms = (!value.is_zero()).then(|| (vec![0; n_variables], value));
        Self(terms.into_iter().collect())
    }

    /// True if there is no variable in it.
    pub(super) fn is_constant(&self) -> bool {
        self.0.keys().all(|exponents| exponents.iter().all(|&n| n == 0))
    }

    fn add(&mut self, exponents: Exponents, coefficient: BigInt) {
        match self.0.entry(exponents) {
            Entry::Vacant(entry) if !coefficient.is_zero() => {
                entry.insert(coefficient);
            }
            Entry::Vacant(_) => (),
            Entry::Occupied(mut entry) => {
                *entry.get_mut() += coefficient;
                if entry.get().is_zero() {
                    entry.remove();
                }
            }
        }
    }

    /// The greatest integer that divides all coefficients.
    fn content(&self) -> BigInt {
        self.0.values().fold(BigInt::zero(), |gcd, c| integer_gcd(&gcd, c))
    }

    /// Without its content, and with a positive leading coefficient.
    pub(super) fn primitive(&self) -> Self {
        let mut content = self.content();
        if content.is_zero() {
            return self.clone();
        }
        if self.0.values().next_back().is_some_and(Signed::is_negative) {
            content = -content;
        }
        Self(self.0.iter().map(|(e, c)| (e.clone(), c / &content)).collect())
    }

    fn height(&self) -> BigInt {
        self.0.values().map(Signed::abs).max().unwrap_or_default()
    }

    /// The value at `x` in the last variable, a polynomial in the others; `None` if that is too long.
    fn at(&self, x: &BigInt) -> Option<Self> {
        let mut result = Self::default();
        for (exponents, coefficient) in &self.0 {
            let (&n, rest) = exponents.split_last()?;
            if x.bits().checked_mul(u64::from(n))? > MAX_BITS {
                return None;
            }
            result.add(rest.to_vec(), coefficient * x.pow(n));
        }
        Some(result)
    }

    /// The polynomial whose digits to the base `x` are the coefficients, by a new last variable.
    fn from_digits(mut digits: Self, x: &BigInt) -> Self {
        let mut result = Self::default();
        let mut power = 0;
        while !digits.0.is_empty() {
            let mut rest = Self::default();
            for (exponents, value) in digits.0 {
                let digit = nearest_remainder(&value, x);
                rest.add(exponents.clone(), (value - &digit) / x);
                let mut exponents = exponents;
                exponents.push(power);
                result.add(exponents, digit);
            }
            digits = rest;
            power += 1;
        }
        result
    }

    /// The quotient, if the division leaves nothing.
    pub(super) fn exact_quotient(&self, divisor: &Self) -> Option<Self> {
        let (lead, lead_coefficient) = divisor.0.last_key_value()?;
        let (mut rest, mut quotient) = (self.clone(), Self::default());
        for _ in 0..MAX_STEPS {
            let Some((exponents, coefficient)) = rest.0.last_key_value() else {
                return Some(quotient);
            };
            let factor = coefficient / lead_coefficient;
            if &factor * lead_coefficient != *coefficient {
                return None;
            }
            let shift = exponents.iter().zip(lead).map(|(a, b)| a.checked_sub(*b));
            let shift: Exponents = shift.collect::<Option<_>>()?;
            for (other, c) in &divisor.0 {
                let exponents = other.iter().zip(&shift).map(|(a, b)| a + b).collect();
                rest.add(exponents, -(c * &factor));
            }
            quotient.add(shift, factor);
        }
        None
    }
}

/// By Euclid.
fn integer_gcd(a: &BigInt, b: &BigInt) -> BigInt {
    let (mut a, mut b) = (a.abs(), b.abs());
    while !b.is_zero() {
        (a, b) = (b.clone(), a % b);
    }
    a
}

/// The remainder of least magnitude.
fn nearest_remainder(value: &BigInt, modulus: &BigInt) -> BigInt {
    let rest = ((value % modulus) + modulus) % modulus;
    if &rest * 2 > *modulus { rest - modulus } else { rest }
}

/// The greatest common divisor of two polynomials in `n_variables` variables, of which none is zero;
/// `None` if it is not found within the work allowed.
pub(super) fn gcd(a: &IntegerPoly, b: &IntegerPoly, n_variables: usize) -> Option<IntegerPoly> {
    let content = integer_gcd(&a.content(), &b.content());
    if n_variables == 0 || a.is_constant() || b.is_constant() {
        return Some(IntegerPoly::constant(n_variables, content));
    }
    let (a, b) = (a.primitive(), b.primitive());
    let mut x = a.height().min(b.height()) * 2 + 29;
    for _ in 0..MAX_TRIED {
        if let (Some(at_a), Some(at_b)) = (a.at(&x), b.at(&x))
            && !at_a.0.is_empty()
            && !at_b.0.is_empty()
        {
            let digits = gcd(&at_a, &at_b, n_variables - 1)?;
            let found = IntegerPoly::from_digits(digits, &x).primitive();
            let divides = |poly: &IntegerPoly| poly.exact_quotient(&found).is_some();
            if divides(&a) && divides(&b) {
                let scaled = found.0.into_iter().map(|(e, c)| (e, c * &content));
                return Some(IntegerPoly(scaled.collect()));
            }
        }
        // Another value that has little in common with the one before, as in the paper.
        x = &x * 73_794 * (x.sqrt().sqrt() + BigInt::one()) / 27_011;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn product(a: &IntegerPoly, b: &IntegerPoly) -> IntegerPoly {
        let mut result = IntegerPoly::default();
        for (e, c) in &a.0 {
            for (f, d) in &b.0 {
                result.add(e.iter().zip(f).map(|(m, n)| m + n).collect(), c * d);
            }
        }
        result
    }

    fn poly(terms: &[(i64, [u32; 3])]) -> IntegerPoly {
        let mut result = IntegerPoly::default();
        for &(c, exponents) in terms {
            result.add(exponents.to_vec(), c.into());
        }
        result
    }

    #[test]
    fn common_factors_are_found() {
        let factors = [
            poly(&[(1, [1, 0, 0]), (-1, [0, 1, 0])]),
            poly(&[(3, [2, 0, 1]), (5, [0, 3, 0]), (-7, [0, 0, 0])]),
            poly(&[(1, [1, 1, 1]), (1, [0, 0, 0])]),
            poly(&[(100, [0, 0, 4]), (-99, [1, 0, 0])]),
        ];
        for g in &factors {
            for a in &factors {
                for b in factors.iter().filter(|b| *b != a) {
                    let (ga, gb) = (product(g, a), product(g, b));
                    let found = gcd(&ga, &gb, 3).expect("small enough");
                    assert_eq!(found, g.primitive(), "{a:?} {b:?}");
                    assert_eq!(ga.exact_quotient(g), Some(a.clone()));
                }
            }
        }
    }
}
