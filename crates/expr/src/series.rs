//! Taylor polynomials about a point.

use crate::kink::Side;
use crate::pool::{Expr, ONE, Pool, SymbolId, ZERO, fact};

impl Pool {
    /// The Taylor polynomial of `e` in `x` about `x = about`, up to and with `(x − about)^order`.
    ///
    /// ```text
    /// Σₖ e⁽ᵏ⁾(about) / k! · (x − about)ᵏ,   k = 0 … order
    /// ```
    ///
    /// The point may be any expression, and other symbols stay. Coefficients are derivatives at
    /// the point: where `e` has none there, as `sqrt(x)` or `abs(x)` at 0, they are infinite or NaN;
    /// see [`Pool::is_singular`]. At a kink or jump the derivatives of both sides are compared, so
    /// that `x*abs(x)` has a series of order 1 about 0, and none of order 2.
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let e = pool.parse("g/l*sin(q)").expect("valid");
    /// let q = pool.find_symbol("q").expect("was parsed");
    /// assert_eq!(pool.to_text(pool.series(e, q, pool.zero(), 1)), "g*q/l");
    ///
    /// let e = pool.parse("exp(x)").expect("valid");
    /// let x = pool.find_symbol("x").expect("was parsed");
    /// let expected = pool.parse("1 + x + x^2/2 + x^3/6").expect("valid");
    /// assert_eq!(pool.series(e, x, pool.zero(), 3), expected);
    /// ```
    pub fn series(&self, e: Expr, x: SymbolId, about: Expr, order: u32) -> Expr {
        let offset = self.sub(self.symbol_expr(x), about);
        let coefficients = if self.has_kink(e, x, about) {
            self.common_coefficients(e, x, about, order)
        } else {
            self.coefficients(e, x, about, order)
        };
        let terms = coefficients.into_iter().zip(0i64..);
        self.sum(terms.map(|(coefficient, k)| self.mul(coefficient, self.powi(offset, k))))
    }

    /// The coefficients of a series, up to the last one that is not identically zero.
    fn coefficients(&self, e: Expr, x: SymbolId, about: Expr, order: u32) -> Vec<Expr> {
        let mut coefficients = Vec::new();
        let (mut derivative, mut weight) = (e, ONE);
        for k in 0..=i64::from(order) {
            if k > 0 {
                derivative = self.diff(derivative, x);
                weight = self.mul(weight, self.rational(1, k));
            }
            if derivative == ZERO {
                break;
            }
            coefficients.push(self.mul(weight, self.substitute(derivative, &[(x, about)])));
        }
        coefficients
    }

    /// The coefficients at a kink or jump: those that both sides share, and NaN for all others.
    fn common_coefficients(&self, e: Expr, x: SymbolId, about: Expr, order: u32) -> Vec<Expr> {
        let none = self.rational(0, 0);
        let side =
            |side| Some(self.coefficients(self.on_side(e, x, about, side)?, x, about, order));
        let (Some(left), Some(right)) = (side(Side::Left), side(Side::Right)) else {
            return vec![none];
        };
        let at = |side: &[Expr], k: usize| side.get(k).copied().unwrap_or(ZERO);
        let is_same = |a: Expr, b: Expr| a == b || self.is_zero(self.simplify(self.sub(a, b)));
        let value = self.substitute(e, &[(x, about)]);
        let common = (0..left.len().max(right.len())).map(|k| {
            let (a, b) = (at(&left, k), at(&right, k));
            // The value itself may be another one than those next to it.
            if is_same(a, b) && (k > 0 || is_same(a, value)) { a } else { none }
        });
        common.collect()
    }

    /// Whether a part of `e` without symbols has no finite value, such as `1/0` or `ln(0)`.
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let e = pool.parse("sqrt(x)").expect("valid");
    /// let x = pool.find_symbol("x").expect("was parsed");
    /// assert!(pool.is_singular(pool.series(e, x, pool.zero(), 1)));
    /// assert!(!pool.is_singular(pool.series(e, x, pool.one(), 1)));
    /// let kink = pool.parse("abs(x)").expect("valid");
    /// assert!(pool.is_singular(pool.series(kink, x, pool.zero(), 1)));
    /// ```
    pub fn is_singular(&self, e: Expr) -> bool {
        self.has_fact(e, fact::POISONED)
    }
}
