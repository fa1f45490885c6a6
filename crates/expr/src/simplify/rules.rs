//! The trigonometric identities, one row each, with the condition under which a row is used.
//!
//! | table | left | right | used where |
//! | --- | --- | --- | --- |
//! | [`PRODUCTS`] | f a · g b | ½ (±h(a − b) ± h(a + b)) | a term of a Fourier form has two calls |
//! | [`SUMS`] | f x ± f y | ±2 g ½(x + y) · h ½(x − y) | the halves have no larger denominators |
//! | [`HALVINGS`] | cos 2a, sin 2a | squares and products of sin a, cos a | 2a is twice a simpler angle |
//!
//! All hold at every angle: none divides. The tests hold each row against its values.

use crate::op::Function::{self, Cos, Sin};

/// `first a · second b = ½ (of_difference · call(a − b) + of_sum · call(a + b))`
#[derive(Clone, Copy, Debug)]
pub(super) struct Product {
    pub(super) first: Function,
    pub(super) second: Function,
    pub(super) call: Function,
    pub(super) of_difference: i64,
    pub(super) of_sum: i64,
}

/// Products of two calls as sums.
#[rustfmt::skip]
pub(super) const PRODUCTS: [Product; 4] = [
    Product { first: Cos, second: Cos, call: Cos, of_difference:  1, of_sum:  1 },
    Product { first: Sin, second: Sin, call: Cos, of_difference:  1, of_sum: -1 },
    Product { first: Sin, second: Cos, call: Sin, of_difference:  1, of_sum:  1 },
    Product { first: Cos, second: Sin, call: Sin, of_difference: -1, of_sum:  1 },
];

/// `call x + sign · call y = factor · of_sum ½(x + y) · of_difference ½(x − y)`
#[derive(Clone, Copy, Debug)]
pub(super) struct Addition {
    pub(super) call: Function,
    pub(super) sign: i64,
    pub(super) factor: i64,
    pub(super) of_sum: Function,
    pub(super) of_difference: Function,
}

/// Sums of two calls as products. The number 1 is cos 0.
#[rustfmt::skip]
pub(super) const SUMS: [Addition; 4] = [
    Addition { call: Cos, sign:  1, factor:  2, of_sum: Cos, of_difference: Cos },
    Addition { call: Cos, sign: -1, factor: -2, of_sum: Sin, of_difference: Sin },
    Addition { call: Sin, sign:  1, factor:  2, of_sum: Sin, of_difference: Cos },
    Addition { call: Sin, sign: -1, factor:  2, of_sum: Cos, of_difference: Sin },
];

/// How the calls of a doubled angle are written in terms of the angle itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Halving {
    /// `cos 2a = factor · call² a + constant`
    pub(super) cosine: Option<(i64, Function, i64)>,
    /// sin 2a = 2 sin a cos a
    pub(super) sine: bool,
}

/// The ways to write a doubled angle that are tried.
#[rustfmt::skip]
pub(super) const HALVINGS: [Halving; 5] = [
    Halving { cosine: Some(( 2, Cos, -1)), sine: false },
    Halving { cosine: Some((-2, Sin,  1)), sine: false },
    Halving { cosine: Some(( 2, Cos, -1)), sine: true },
    Halving { cosine: Some((-2, Sin,  1)), sine: true },
    Halving { cosine: None,                sine: true },
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Angles of every quadrant, with zeros and poles among them.
    const ANGLES: [f64; 9] =
        [-4.0, -1.2, 0.0, 0.3, 1.0, std::f64::consts::FRAC_PI_2, 2.2, 3.7, 9.9];

    fn check(left: f64, right: f64, row: &dyn std::fmt::Debug) {
        assert!((left - right).abs() < 1e-14, "{row:?}: {left} is not {right}");
    }

    #[test]
    fn rows_hold_at_every_angle() {
        let of = |f: Function, a: f64| f.value(a, 0.0);
        for a in ANGLES {
            for b in ANGLES {
                for row in PRODUCTS {
                    let right = row.of_difference as f64 * of(row.call, a - b)
                        + row.of_sum as f64 * of(row.call, a + b);
                    check(of(row.first, a) * of(row.second, b), right / 2.0, &row);
                }
                for row in SUMS {
                    let (sum, difference) = (a / 2.0 + b / 2.0, a / 2.0 - b / 2.0);
                    let right =
                        row.factor as f64 * of(row.of_sum, sum) * of(row.of_difference, difference);
                    check(of(row.call, a) + row.sign as f64 * of(row.call, b), right, &row);
                }
            }
            for row in HALVINGS {
                if let Some((factor, call, constant)) = row.cosine {
                    let right = factor as f64 * of(call, a).powi(2) + constant as f64;
                    check(of(Cos, 2.0 * a), right, &row);
                }
                check(of(Sin, 2.0 * a), 2.0 * of(Sin, a) * of(Cos, a), &row);
            }
        }
    }
}
