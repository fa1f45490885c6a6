//! The mechanism as a force law sees it, and the expressions that several laws share.

use bksim_expr::{Expr, Pool, SymbolId};

use super::Wrench;
use crate::folding::short;
use crate::kinematics::Kinematics;
use crate::spatial;
use bksim_model::{Anchor, Model, Vector};

/// The mechanism that a load acts on.
pub(super) struct Context<'a> {
    pub(super) model: &'a Model,
    pub(super) pool: &'a Pool,
    pub(super) kinematics: &'a Kinematics,
    /// The expression that each signal symbol stands for.
    pub(super) signals: &'a [(SymbolId, Expr)],
}

impl Context<'_> {
    /// The vector from the first to the second of two points.
    pub(super) fn vector(&self, ends: [Anchor; 2]) -> Vector {
        let [p_a, p_b] = ends.map(|end| self.kinematics.anchor(self.model, end));
        spatial::sub(self.pool, &p_b, &p_a)
    }

    /// Distance of two points and the unit vector from the first to the second. Between points far apart in a
    /// mechanism the square of the distance stays a sum of squares, whose sines and cosines everything else has, too.
    pub(super) fn line(&self, ends: [Anchor; 2]) -> (Expr, Vector) {
        let pool = self.pool;
        let d = self.vector(ends);
        let distance = pool.sqrt(short(pool, spatial::dot(pool, &d, &d)));
        (distance, spatial::scale(pool, pool.div(pool.one(), distance), &d))
    }

    /// The force `value` on the second point along `direction`, and its opposite on the first.
    pub(super) fn push_apart(
        &self,
        ends: [Anchor; 2],
        value: Expr,
        direction: &Vector,
    ) -> Vec<Wrench> {
        self.pair(ends, &spatial::scale(self.pool, value, direction))
    }

    /// The force `pull` on the first point, and its opposite on the second.
    pub(super) fn pull_together(&self, ends: [Anchor; 2], pull: &Vector) -> Vec<Wrench> {
        self.pair(ends, &spatial::neg(self.pool, pull))
    }

    /// `force` on the second point, and its opposite on the first.
    fn pair(&self, [a, b]: [Anchor; 2], force: &Vector) -> Vec<Wrench> {
        let pool = self.pool;
        let end = |anchor: Anchor, force| Wrench {
            body: anchor.body,
            force,
            at: self.kinematics.anchor(self.model, anchor),
            moment: spatial::zero(pool),
        };
        vec![end(a, spatial::neg(pool, force)), end(b, *force)]
    }

    /// ½ k e².
    pub(super) fn half_square(&self, k: Expr, e: Expr) -> Expr {
        let pool = self.pool;
        pool.product([pool.rational(1, 2), k, pool.powi(e, 2)])
    }

    /// The expression with its signals replaced by the measures they stand for.
    pub(super) fn resolved(&self, e: Expr) -> Expr {
        self.pool.substitute(e, self.signals)
    }

    /// Depends on parameters only: neither on time nor on a signal.
    pub(super) fn is_constant(&self, e: Expr) -> bool {
        let pool = self.pool;
        !pool.depends_on(e, self.model.time)
            && !self.model.signals.iter().any(|signal| pool.depends_on(e, signal.symbol))
    }
}
