//! Simplification: several normal forms of an expression are written out, the cheapest wins.
//!
//! ```text
//! expression ── plain polynomial ───────────────┐
//!            └─ Fourier form ─┬─────────────────┤
//!                             ├─ halved angles ─┼─ common factors out ─ cost ─ cheapest
//!                             └─ products ──────┘
//! ```
//!
//! Exponentials and hyperbolic functions add forms of their own, and so do tangents over common
//! cosines. Functions of inverse functions fold where the form has the same domain.
//!
//! The value never changes where the expression has one; removable singularities of quotients of
//! sines and cosines are filled. What has other values somewhere is left to [`cancel`], which states
//! its conditions. Work is bounded: parts that are not reached stay
//! as they are. The result depends on the expression alone, not on the order it was built in.

mod best;
mod budget;
mod cancel;
mod collect;
mod cost;
mod driver;
mod exponential;
mod extent;
mod factor;
mod flatten;
mod fraction;
mod gcd;
mod inverse;
mod poly;
mod rules;
mod together;
mod trig;
mod trig_forms;

pub use cancel::Cancelled;

use crate::pool::{Expr, Pool};
use budget::{BUDGET, FORM_BUDGET};
use driver::Driver;
use poly::{Algebra, Reading};

impl Pool {
    /// The cheapest form found; the expression itself if none is cheaper or the work too much.
    pub fn simplify(&self, e: Expr) -> Expr {
        self.simplified(e, || self.simplify_all(&[e])[0])
    }

    /// Simplifies several expressions, shared parts once. Together
    /// they never cost more than before: an expression stays as it is where its simpler form would
    /// share so much less with the others that the whole grows.
    pub fn simplify_all(&self, roots: &[Expr]) -> Vec<Expr> {
        self.simplify_within(roots, BUDGET)
    }

    /// Simplifies several expressions by at most so much work for each: nodes visited and terms multiplied. Parts that are
    /// not reached before stay as they are: the result always has the same values.
    ///
    /// ```
    /// let pool = bksim_expr::Pool::new();
    /// let e = pool.parse("a*cos(p)*cos(q) - a*sin(p)*sin(q)").expect("valid");
    /// assert_eq!(pool.to_text(pool.simplify_within(&[e], 10_000)[0]), "a*cos(p + q)");
    /// assert_eq!(pool.simplify_within(&[e], 0), [e]);
    /// ```
    pub fn simplify_within(&self, roots: &[Expr], budget: u64) -> Vec<Expr> {
        Driver::new(self, budget, roots.len()).run(&self.sweep(roots))
    }

    /// Multiplies out products and powers of sums; the expression itself if that is too much.
    pub fn expand(&self, e: Expr) -> Expr {
        let reading =
            Reading { is_fourier: false, keeps_plain_sums: false, splits_tangents: false };
        let poly = Algebra::new(self, FORM_BUDGET).read(e, reading);
        poly.map_or(e, |poly| poly::sum_expr(self, &poly))
    }
}
