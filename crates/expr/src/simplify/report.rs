//! The outcome of a simplification, in numbers.

use super::budget::Limit;
use crate::certificate::Certificate;
use crate::pool::{Expr, Pool};
use crate::print::Operations;

/// The outcome of [`Pool::simplify_within`].
#[derive(Clone, PartialEq, Debug)]
pub struct Simplified {
    /// One expression for each one given, with the same values.
    pub roots: Vec<Expr>,
    /// Operations and work.
    pub report: Report,
}

/// Operations before and after a simplification, by kind, and the work it took.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Report {
    /// Operations of all expressions given, shared parts counted once.
    pub before: Operations,
    /// Operations of all expressions returned, shared parts counted once.
    pub after: Operations,
    /// Operations of all expressions given, each written out in full.
    pub printed_before: Operations,
    /// Operations of all expressions returned, each written out in full.
    pub printed_after: Operations,
    /// Work, in the units of [`Budget::nodes`](crate::Budget::nodes).
    pub work: u64,
    /// The limit that ended the work, if one did.
    pub ended_by: Option<Limit>,
    /// Parts (expressions, divisors, arguments of functions) left as they were because of it.
    pub n_kept: usize,
}

impl Simplified {
    /// Compares each expression with the one it was made from, at random points in two precisions.
    ///
    /// ```
    /// use bksim_expr::{Budget, Pool};
    ///
    /// let pool = Pool::new();
    /// let e = pool.parse("(l*w*cos(q))^2 + (l*w*sin(q))^2").expect("valid");
    /// let simplified = pool.simplify_within(&[e], &Budget::default());
    /// assert!(simplified.certificates(&pool, &[e]).iter().all(|c| c.is_equal()));
    /// ```
    pub fn certificates(&self, pool: &Pool, originals: &[Expr]) -> Vec<Certificate> {
        let pairs = originals.iter().zip(&self.roots);
        pairs.map(|(&original, &simple)| pool.certificate(original, simple)).collect()
    }
}
