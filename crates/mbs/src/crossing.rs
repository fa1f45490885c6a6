//! Passing a singular pose: where the constraints lose rank for an instant and branches of motion
//! meet, as at the change point of a parallelogram.
//!
//! The motion itself is smooth there, only the implicit equations have no unique solution. So the
//! neighbourhood is crossed by small explicit steps on the accelerations,
//!
//! ```text
//! v̇ = a(t, q, v) of the multiplier system, minimum norm where it is singular
//! ```
//!
//! by the classical Runge–Kutta method, and the end is projected onto all constraints. The tangent
//! decides the branch: the motion goes on along v, and the nearest closed position behind the pose
//! lies on the branch whose tangent v was.

use nalgebra::DVector;

use crate::compile::Evaluator;
use crate::linear::{accelerations, dependent_rows, nearest_accelerations, project};

/// Positions and velocities at one instant, with the accelerations there.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct State {
    pub(crate) t: f64,
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) a: Vec<f64>,
}

/// Explicit steps tried before a crossing is given up.
const MAX_STEPS: usize = 4000;

/// A pose is regular again when the smallest singular value of the constraint rows has
/// grown to this part of its value at the start of the run.
const REGULAR: f64 = 0.1;

/// Size of an explicit step as part of the time in which the motion changes by its own size: its
/// error, about the fifth power of this, is below every tolerance in use.
const STEP_PART: f64 = 4e-3;

impl State {
    /// Cubic Hermite interpolation of q and v between two states, written as (q, v).
    pub(crate) fn between_into(&self, next: &Self, t: f64, out: &mut [f64]) {
        let h = next.t - self.t;
        let s = (t - self.t) / h;
        let hermite = |y0: f64, y1: f64, d0: f64, d1: f64| {
            let (left, right) = (1.0 - s, s);
            left * left * ((1.0 + 2.0 * s) * y0 + s * h * d0)
                + right * right * ((3.0 - 2.0 * s) * y1 - left * h * d1)
        };
        let nq = self.q.len();
        for i in 0..nq {
            out[i] = hermite(self.q[i], next.q[i], self.v[i], next.v[i]);
            out[nq + i] = hermite(self.v[i], next.v[i], self.a[i], next.a[i]);
        }
    }
}

/// Crosses from `from` towards `t_end`, not beyond it; all rows but the `dependent` ones are
/// independent in general, and `regular` is their smallest singular value where they are.
///
/// Returns every state passed, the last one regular; `None` when the pose stays singular.
pub(crate) fn cross(
    evaluator: &mut Evaluator,
    from: State,
    t_end: f64,
    dependent: &[usize],
    regular: f64,
) -> Option<Vec<State>> {
    let mut passed = vec![from];
    let mut before = f64::INFINITY;
    for _ in 0..MAX_STEPS {
        let state = passed.last()?;
        let left = t_end - state.t;
        let h = step_size(state).copysign(left);
        let is_last = left.abs() <= h.abs();
        let next = explicit_step(evaluator, state, if is_last { left } else { h }, dependent)?;
        let now = smallest_singular_value(evaluator, &next, dependent);
        passed.push(next);
        let receding = now > before && now >= REGULAR * regular;
        before = now;
        if is_last || receding {
            return Some(passed);
        }
    }
    None
}

/// What a crossing came to.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Landing {
    /// When the constraints were weakest, s.
    pub(crate) t_singular: f64,
    /// Rows that follow from the others behind the pose.
    pub(crate) dependent: Vec<usize>,
    pub(crate) lambda: Vec<f64>,
}

/// Puts the last state of a crossing onto all constraints; `None` when it cannot be the other side
/// of the same motion: another rank, or constraints that do not close nearby.
pub(crate) fn land(
    evaluator: &mut Evaluator,
    passed: &mut [State],
    dependent: &[usize],
) -> Option<Landing> {
    const CLOSED: f64 = 1e-9;
    let weakest =
        passed.iter().map(|state| (smallest_singular_value(evaluator, state, dependent), state.t));
    let (_, t_singular) = weakest.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let last = passed.last_mut()?;
    let drift = project(evaluator, last.t, &mut last.q, &mut last.v, &[]);
    let size = last.q.iter().fold(1.0, |size: f64, value| size.max(value.abs()));
    let at = evaluator.dynamics(last.t, &last.q, &last.v);
    let found = dependent_rows(&at.jacobian).dependent;
    if drift.position[1] > CLOSED * size || found.len() != dependent.len() {
        return None;
    }
    let solution = accelerations(at, &found)?;
    last.a = solution.vdot.as_slice().to_vec();
    Some(Landing { t_singular, dependent: found, lambda: solution.lambda.as_slice().to_vec() })
}

/// A state with its accelerations, the smallest ones where they are not unique.
pub(crate) fn with_accelerations(
    evaluator: &mut Evaluator,
    t: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    dependent: &[usize],
) -> State {
    let found = nearest_accelerations(evaluator.dynamics(t, &q, &v), dependent);
    State { t, q, v, a: found.vdot.as_slice().to_vec() }
}

/// The motion changes by its own size in a radian, or a metre.
fn step_size(state: &State) -> f64 {
    let rate = |i: usize| state.v[i].abs() + state.a[i].abs().sqrt();
    let fastest = (0..state.q.len()).map(rate).fold(1e-3, f64::max);
    STEP_PART / fastest
}

/// Smallest singular value of the independent rows. They are not scaled: a row that vanishes, as
/// those across a straightened chain do, is what makes such a pose singular.
pub(crate) fn smallest_singular_value(
    evaluator: &mut Evaluator,
    state: &State,
    dependent: &[usize],
) -> f64 {
    let jacobian = &evaluator.dynamics(state.t, &state.q, &state.v).jacobian;
    let kept: Vec<usize> = (0..jacobian.nrows()).filter(|row| !dependent.contains(row)).collect();
    let rows = jacobian.select_rows(&kept);
    if rows.is_empty() || rows.iter().any(|value| !value.is_finite()) {
        return 0.0;
    }
    rows.singular_values().min()
}

/// One step of the classical Runge–Kutta method.
fn explicit_step(
    evaluator: &mut Evaluator,
    from: &State,
    h: f64,
    dependent: &[usize],
) -> Option<State> {
    let q0 = DVector::from_column_slice(&from.q);
    let v0 = DVector::from_column_slice(&from.v);
    let a1 = DVector::from_column_slice(&from.a);
    let mut slope = |part: f64, v: &DVector<f64>, a: &DVector<f64>| {
        let q = &q0 + v * (part * h);
        let v = &v0 + a * (part * h);
        let at = evaluator.dynamics(from.t + part * h, q.as_slice(), v.as_slice());
        let a = nearest_accelerations(at, dependent).vdot;
        (v, a)
    };
    let (v2, a2) = slope(0.5, &v0, &a1);
    let (v3, a3) = slope(0.5, &v2, &a2);
    let (v4, a4) = slope(1.0, &v3, &a3);
    let q = &q0 + (&v0 + (&v2 + &v3) * 2.0 + &v4) * (h / 6.0);
    let v = &v0 + (&a1 + (&a2 + &a3) * 2.0 + &a4) * (h / 6.0);

    // No projection here: near the pose it would divide what rounding has left by almost nothing.
    let (q, v) = (q.as_slice().to_vec(), v.as_slice().to_vec());
    let next = with_accelerations(evaluator, from.t + h, q, v, dependent);
    let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
    (finite(&next.q) && finite(&next.v) && finite(&next.a)).then_some(next)
}
