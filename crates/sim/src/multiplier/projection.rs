//! Moving a state onto the constraints with the factors of the multiplier system.

use super::{MultiplierSystem, largest};
use crate::evaluator::{ConstraintsAt, Evaluator};
use crate::linear::shape::Shape;

/// Weaker than this, a projection would divide what integration has left open by almost nothing.
pub(super) const PROJECTED_ABOVE: f64 = 1e-4;

/// The gap that is as good as closed, as a part of [`size_of`] the position. That which a step leaves is so small that
/// one Newton step with the factors of the last stage closes it to rounding, but for long steps.
pub(crate) const CLOSED: f64 = 1e-11;

/// The largest magnitude of a coordinate, one at least.
pub(crate) fn size_of(q: &[f64]) -> f64 {
    q.iter().fold(1.0, |size, q| size.max(q.abs()))
}

/// Largest residuals before and after a projection.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(crate) struct Drift {
    /// |g|, m or rad.
    pub(crate) position: [f64; 2],
    /// |G v + ∂g/∂t|, m/s or rad/s.
    pub(crate) velocity: [f64; 2],
}

impl MultiplierSystem {
    /// True where states are projected: not next to a singular pose.
    pub(crate) fn is_projected(&self) -> bool {
        self.rank_margin() >= PROJECTED_ABOVE
    }

    /// Moves q, then v, onto the constraints by the least amount in the norm of M, with factors of
    /// this state or one nearby; at most `corrections` Newton steps for q, fewer when they stop
    /// gaining, and none near a singular pose.
    pub(crate) fn project(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        (q, v): (&mut [f64], &mut [f64]),
        corrections: usize,
    ) -> Drift {
        if !self.is_projected() {
            return self.drift_at(evaluator, t, (q, v));
        }
        self.close(evaluator, t, (q, v), corrections)
    }

    /// The residuals at a state, whose rows are kept.
    fn drift_at(&mut self, evaluator: &mut Evaluator, t: f64, (q, v): (&[f64], &[f64])) -> Drift {
        self.rows.take(&evaluator.constraints(t, q));
        let position = largest(&self.rows.value);
        let velocity = self.rows.rate_of(evaluator.shape(), v, &mut self.residual);
        Drift { position: [position; 2], velocity: [velocity; 2] }
    }

    /// Projection ([`MultiplierSystem::project`]) near a singular pose too.
    pub(super) fn close(
        &mut self,
        evaluator: &mut Evaluator,
        t: f64,
        (q, v): (&mut [f64], &mut [f64]),
        corrections: usize,
    ) -> Drift {
        let mut drift = self.drift_at(evaluator, t, (q, v));
        for _ in 0..corrections {
            if drift.position[1] == 0.0 {
                break;
            }
            self.solve_for_step(Residual::Position);
            for (trial, (q, step)) in self.trial.iter_mut().zip(q.iter().zip(&self.x)) {
                *trial = q - step;
            }
            let at = evaluator.constraints(t, &self.trial);
            let left = largest(at.value);
            // Newton's steps gain until rounding; the first that does not is thrown away.
            if left.is_nan() || left >= drift.position[1] {
                break;
            }
            q.copy_from_slice(&self.trial);
            self.rows.take(&at);
            drift.position[1] = left;
        }
        self.rows.rate_of(evaluator.shape(), v, &mut self.residual);
        self.solve_for_step(Residual::Velocity);
        v.iter_mut().zip(&self.x).for_each(|(v, step)| *v -= step);
        drift.velocity[1] = self.rows.rate_of(evaluator.shape(), v, &mut self.residual);
        drift
    }

    /// The step that takes a residual of the constraints away, into the first nq of `x`.
    fn solve_for_step(&mut self, residual: Residual) {
        let residual = match residual {
            Residual::Position => &self.rows.value,
            Residual::Velocity => &self.residual,
        };
        let (upper, lower) = self.x.split_at_mut(self.nq);
        upper.fill(0.0);
        lower.iter_mut().zip(&self.active).for_each(|(x, &row)| *x = residual[row]);
        self.solve();
    }
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Residual {
    /// g.
    Position,
    /// G v + ∂g/∂t.
    Velocity,
}

/// G, g and ∂g/∂t at the position that a projection has reached.
#[derive(Clone, Debug, Default)]
pub(super) struct Rows {
    jacobian: Vec<f64>,
    value: Vec<f64>,
    rate: Vec<f64>,
}

impl Rows {
    fn take(&mut self, at: &ConstraintsAt) {
        let parts = [&mut self.jacobian, &mut self.value, &mut self.rate];
        for (own, part) in parts.into_iter().zip([at.jacobian, at.value, at.rate]) {
            own.clear();
            own.extend_from_slice(part);
        }
    }

    /// Writes G v + ∂g/∂t and returns its largest magnitude.
    fn rate_of(&self, shape: &Shape, v: &[f64], out: &mut [f64]) -> f64 {
        let Self { jacobian, value, rate } = self;
        ConstraintsAt { shape, jacobian, value, rate }.rate_into(v, out);
        largest(out)
    }
}
