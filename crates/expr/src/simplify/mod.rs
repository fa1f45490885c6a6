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
//! its conditions. Work is bounded by a [`Budget`]: parts that are not reached stay
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
mod report;
mod rules;
mod together;
mod trig;
mod trig_forms;

pub use budget::{Budget, Limit};
pub use cancel::Cancelled;
pub use report::{Report, Simplified};

use crate::pool::{Expr, Pool};
use budget::FORM_BUDGET;
use driver::Driver;
use poly::{Algebra, Reading};

impl Pool {
    /// The cheapest form found; the expression itself if none is cheaper or the work too much.
    pub fn simplify(&self, e: Expr) -> Expr {
        self.simplified(e, || self.simplify_all(&[e])[0])
    }

    /// Simplifies several expressions within the default [`Budget`], shared parts once. Together
    /// they never cost more than before: an expression stays as it is where its simpler form would
    /// share so much less with the others that the whole grows.
    pub fn simplify_all(&self, roots: &[Expr]) -> Vec<Expr> {
        Driver::new(self, &Budget::default(), roots.len()).run(&self.sweep(roots))
    }

    /// Simplifies several expressions within a budget, and reports the outcome. Parts that are not
    /// reached before the budget ends stay as they are: the result always has the same values.
    ///
    /// ```
    /// use bksim_expr::{Budget, Limit, Pool};
    ///
    /// let pool = Pool::new();
    /// let e = pool.parse("a*cos(p)*cos(q) - a*sin(p)*sin(q)").expect("valid");
    /// let done = pool.simplify_within(&[e], &Budget::default());
    /// assert_eq!(pool.to_text(done.roots[0]), "a*cos(p + q)");
    /// assert_eq!((done.report.before.total(), done.report.after.total()), (9, 3));
    /// assert_eq!(done.report.ended_by, None);
    ///
    /// let none = pool.simplify_within(&[e], &Budget { nodes: 0, ..Budget::default() });
    /// assert_eq!((none.roots[0], none.report.ended_by), (e, Some(Limit::Nodes)));
    /// ```
    pub fn simplify_within(&self, roots: &[Expr], budget: &Budget) -> Simplified {
        let sweep = self.sweep(roots);
        let mut driver = Driver::new(self, budget, roots.len());
        let simple = driver.run(&sweep);
        let report = Report {
            before: self.count_sweep(&sweep).operations(),
            after: self.operation_count(&simple).operations(),
            printed_before: self.printed_operations(roots),
            printed_after: self.printed_operations(&simple),
            work: driver.model.meter.spent(),
            ended_by: driver.model.meter.ended_by(),
            n_kept: driver.n_kept,
        };
        Simplified { roots: simple, report }
    }

    /// Multiplies out products and powers of sums; the expression itself if that is too much.
    pub fn expand(&self, e: Expr) -> Expr {
        let reading =
            Reading { is_fourier: false, keeps_plain_sums: false, splits_tangents: false };
        let poly = Algebra::new(self, FORM_BUDGET).read(e, reading);
        poly.map_or(e, |poly| poly::sum_expr(self, &poly))
    }
}
