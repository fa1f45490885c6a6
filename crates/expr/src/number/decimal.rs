//! Fractions over 2^a·5^b, as decimals, their sums and their products are.
//!
//! Their lowest terms need no greatest common divisor of long numbers: twos of a number are its trailing zeros, and
//! 2⁶⁴ = 1 mod 5, so that fives show in the sum of its 64-bit digits.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Zero};
use std::sync::OnceLock;

/// Longest power of five in the table, in bits: that of a decimal of 440 digits.
const MAX_BITS: usize = 1 << 10;

/// Numerator and denominator of a · b in lowest terms; `None` where a denominator is no such product or too long.
pub(super) fn product(a: &BigRational, b: &BigRational) -> Option<(BigInt, BigInt)> {
    let (p, q) = (Scale::of(a.denom())?, Scale::of(b.denom())?);
    let scale = Scale { twos: p.twos + q.twos, fives: p.fives + q.fives };
    scale.lowest_terms(a.numer() * b.numer())
}

/// Numerator and denominator of a + b in lowest terms; `None` where a denominator is no such product or too long.
pub(super) fn sum(a: &BigRational, b: &BigRational) -> Option<(BigInt, BigInt)> {
    let (p, q) = (Scale::of(a.denom())?, Scale::of(b.denom())?);
    let common = Scale { twos: p.twos.max(q.twos), fives: p.fives.max(q.fives) };
    common.lowest_terms(common.over(p, a.numer()) + common.over(q, b.numer()))
}

/// 2^twos · 5^fives.
#[derive(Clone, Copy)]
struct Scale {
    twos: u64,
    fives: usize,
}

impl Scale {
    /// The exponents of a positive number.
    fn of(n: &BigInt) -> Option<Self> {
        let Powers { of_five, exponents } = Powers::get();
        let twos = n.trailing_zeros()?;
        let n_bits = usize::try_from(n.bits() - twos).ok()?;
        let fives = (*exponents.get(n_bits)?)?;
        let is_power = if twos == 0 { *n == of_five[fives] } else { n >> twos == of_five[fives] };
        is_power.then_some(Self { twos, fives })
    }

    /// The lowest terms of n over this.
    fn lowest_terms(self, n: BigInt) -> Option<(BigInt, BigInt)> {
        if n.is_zero() {
            return Some((n, BigInt::one()));
        }
        let twos = n.trailing_zeros().unwrap_or(0).min(self.twos);
        let mut n = if twos == 0 { n } else { n >> twos };
        let mut fives = self.fives;
        let is_multiple =
            |n: &BigInt| n.iter_u64_digits().map(|digit| digit % 5).sum::<u64>().is_multiple_of(5);
        while fives > 0 && is_multiple(&n) {
            n /= 5u32;
            fives -= 1;
        }
        let power = Powers::get().of_five.get(fives)?;
        let twos = self.twos - twos;
        Some((n, if twos == 0 { power.clone() } else { power << twos }))
    }

    /// The numerator over this of n over `part`, which divides it.
    fn over(self, part: Self, n: &BigInt) -> BigInt {
        let fives = &Powers::get().of_five[self.fives - part.fives];
        (n * fives) << (self.twos - part.twos)
    }
}

/// Powers of five, and the exponent of the one that has so many bits: no two have equally many.
struct Powers {
    of_five: Vec<BigInt>,
    exponents: Vec<Option<usize>>,
}

impl Powers {
    fn get() -> &'static Self {
        static POWERS: OnceLock<Powers> = OnceLock::new();
        POWERS.get_or_init(|| {
            let mut powers = Self { of_five: Vec::new(), exponents: vec![None; MAX_BITS + 1] };
            let mut power = BigInt::one();
            while let Some(exponent) =
                usize::try_from(power.bits()).ok().and_then(|n| powers.exponents.get_mut(n))
            {
                *exponent = Some(powers.of_five.len());
                powers.of_five.push(power.clone());
                power *= 5u32;
            }
            powers
        })
    }
}
