//! Taylor polynomials about a point.

use crate::pool::{Expr, ONE, Pool, SymbolId, ZERO, fact};

impl Pool {
    /// The Taylor polynomial of `e` in `x` about `x = about`, up to and with `(x − about)^order`.
    ///
    /// ```text
    /// Σₖ e⁽ᵏ⁾(about) / k! · (x − about)ᵏ,   k = 0 … order
    /// ```
    ///
    /// The point may be any expression, and other symbols stay. Coefficients are derivatives at
    /// the point: where `e` has none there, as `sqrt(x)` at 0, they are infinite or NaN; see
    /// [`Pool::is_singular`].
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
        let mut terms = Vec::new();
        let (mut derivative, mut weight) = (e, ONE);
        for k in 0..=i64::from(order) {
            if k > 0 {
                derivative = self.diff(derivative, x);
                weight = self.mul(weight, self.rational(1, k));
            }
            if derivative == ZERO {
                break;
            }
            let coefficient = self.substitute(derivative, &[(x, about)]);
            terms.push(self.product([weight, coefficient, self.powi(offset, k)]));
        }
        self.sum(terms)
    }

    /// Whether a part of `e` without symbols has no finite value, such as `1/0` or `ln(0)`.
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let e = pool.parse("sqrt(x)").expect("valid");
    /// let x = pool.find_symbol("x").expect("was parsed");
    /// assert!(pool.is_singular(pool.series(e, x, pool.zero(), 1)));
    /// assert!(!pool.is_singular(pool.series(e, x, pool.one(), 1)));
    /// ```
    pub fn is_singular(&self, e: Expr) -> bool {
        self.has_fact(e, fact::POISONED)
    }

    /// The part of `e` of at most first order in the offsets of several symbols from a point:
    ///
    /// ```text
    /// e(p) + Σᵢ ∂e/∂xᵢ(p) · (xᵢ − pᵢ)
    /// ```
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let e = pool.parse("a^2*sin(b) + b").expect("valid");
    /// let [a, b] = ["a", "b"].map(|name| pool.find_symbol(name).expect("was parsed"));
    /// let linear = pool.linearise(e, &[(a, pool.int(3)), (b, pool.zero())]);
    /// assert_eq!(pool.to_text(linear), "10*b");
    /// ```
    pub fn linearise(&self, e: Expr, point: &[(SymbolId, Expr)]) -> Expr {
        let symbols: Vec<SymbolId> = point.iter().map(|&(x, _)| x).collect();
        let mut parts = self.gradient(e, &symbols);
        parts.push(e);
        let at_point = self.substitute_all(&parts, point);
        let (slopes, value) = (&at_point[..point.len()], at_point[point.len()]);
        let rises = point
            .iter()
            .zip(slopes)
            .map(|(&(x, at), &slope)| self.mul(slope, self.sub(self.symbol_expr(x), at)));
        self.sum(rises.chain([value]))
    }
}
