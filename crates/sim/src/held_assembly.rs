//! Noticing that a motion passes over into another assembly.
//!
//! ```text
//! K = [ G ]   rows of the constraints that hold, ∂g/∂q
//!     [ H ]   slopes of the measures that tell assemblies apart by being held
//! det K = 0   two assemblies meet: with H held the mechanism yields along u, K u = 0
//! wᵀ K = 0    w_H = 0 where G itself loses rank: motions cross there, and each goes straight on
//! ```
//!
//! The determinant changes its sign where the one becomes the other. Between two states the motion is the cubic through
//! both with their velocities.

use bksim_model::{BodyId, JointId};
use nalgebra::DMatrix;

use crate::compiled::CompiledSystem;
use crate::evaluator::Evaluator;
use crate::function::{Buffers, Function};
use crate::held_rows::{HeldRows, Moving};
use crate::linear::svd::Svd;

/// A state of a motion: the instant, or the length of a way, positions and their rates by it.
type At<'s> = (f64, &'s [f64], &'s [f64]);

/// A motion that is watched.
#[derive(Clone, Debug)]
pub struct AssemblyMonitor<'a> {
    of: &'a HeldRows,
    buffers: Buffers,
    last: Option<Last>,
}

/// The last state, and the sign of det K there.
#[derive(Clone, Debug)]
struct Last {
    s: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    is_positive: bool,
}

/// A pose in which one assembly becomes another one.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct AssemblyChange {
    /// The instant, s, or the length of the way.
    pub t: f64,
    /// The joint that passes through its dead centre.
    pub joint: JointId,
}

/// Largest part of a unit vector that counts as none.
const NO_PART: f64 = 1e-3;
/// Halvings of a step.
const HALVINGS: usize = 40;

impl<'a> AssemblyMonitor<'a> {
    /// A monitor of the assembly that the model of `compiled` holds, at these values of all parameters, modes among them;
    /// none where it holds none.
    pub fn of(compiled: &'a CompiledSystem, parameters: &[f64]) -> Option<Self> {
        let of = compiled.held_rows.as_ref()?;
        Some(Self { of, buffers: of.slopes.buffers(parameters), last: None })
    }
}

impl AssemblyMonitor<'_> {
    /// Takes a state of the motion, time being `t` unless it is the first number of the state; tells where since the
    /// last one the assembly became another. The rows that do not hold are `inactive`.
    pub fn observe(
        &mut self,
        evaluator: &mut Evaluator<'_>,
        inactive: &[usize],
        t: Option<f64>,
        (s, q, v): At<'_>,
    ) -> Option<AssemblyChange> {
        let now = self.is_positive(evaluator, inactive, (t.unwrap_or(s), q));
        let Some(is_positive) = now else {
            // Stops that are closed leave other rows.
            self.last = None;
            return None;
        };
        let next = Last { s, q: q.to_vec(), v: v.to_vec(), is_positive };
        let last = self.last.replace(next)?;
        if last.is_positive == is_positive {
            return None;
        }
        // Halve the way between both states.
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let (s, q) = between(&last, (s, q, v), middle);
            let there = self.is_positive(evaluator, inactive, (t.unwrap_or(s), &q));
            if there == Some(last.is_positive) { low = middle } else { high = middle }
        }
        let (s, q) = between(&last, (s, q, v), 0.5 * (low + high));
        let k = self.matrix(evaluator, inactive, (t.unwrap_or(s), &q))?;
        let joint = self.yielding(&k)?;
        Some(AssemblyChange { t: s, joint })
    }

    /// The side of a pose on which no assemblies meet: true where det K is positive.
    pub fn is_positive(
        &mut self,
        evaluator: &mut Evaluator<'_>,
        inactive: &[usize],
        at: (f64, &[f64]),
    ) -> Option<bool> {
        self.matrix(evaluator, inactive, at).and_then(|k| is_positive(&k))
    }

    /// K, the rows of G and those of H of about length one; `None` where it is not square.
    fn matrix(
        &mut self,
        evaluator: &mut Evaluator<'_>,
        inactive: &[usize],
        (t, q): (f64, &[f64]),
    ) -> Option<DMatrix<f64>> {
        let HeldRows { columns, n_held, entries, slopes, .. } = self.of;
        let jacobian = evaluator.constraints(t, q).jacobian_rows();
        let active: Vec<usize> =
            (0..jacobian.n_rows()).filter(|row| !inactive.contains(row)).collect();
        if active.len() + n_held != columns.len() {
            return None;
        }
        let jacobian = jacobian.select(&active).dense();
        let mut k = DMatrix::zeros(columns.len(), columns.len());
        for (column, &of) in columns.iter().enumerate() {
            k.view_mut((0, column), (active.len(), 1)).copy_from(&jacobian.column(of));
        }
        let values = slopes.evaluate(&mut self.buffers, &[&[t], q]);
        for (&(row, of), value) in entries.iter().zip(values) {
            let column = columns.iter().position(|&column| column == of);
            if let Some(column) = column.filter(|_| row < *n_held) {
                k[(active.len() + row, column)] = *value;
            }
        }
        // One size for all rows of G: one of them may vanish, which is no fault of scaling.
        let size = k.rows(0, active.len()).norm();
        k.rows_mut(0, active.len()).unscale_mut(if size > 0.0 { size } else { 1.0 });
        for mut row in k.rows_mut(active.len(), *n_held).row_iter_mut() {
            let length = row.norm();
            row.unscale_mut(length);
        }
        k.iter().all(|x| x.is_finite()).then_some(k)
    }

    /// The joint that yields in a pose where K is singular; `None` where the constraints themselves lose rank.
    fn yielding(&mut self, k: &DMatrix<f64>) -> Option<JointId> {
        let HeldRows { columns, n_held, entries, moving, bodies, .. } = self.of;
        let n = k.nrows();
        let Svd { u: w, singular_values, v_t: u } = Svd::new(k)?;
        let least = singular_values.imin();
        let w_held = w.column(least).rows(n - n_held, *n_held).norm();
        if *n_held > 0 && w_held < NO_PART {
            return None;
        }
        // How fast everything moves along u.
        let mut rates = vec![0.0; moving.len()];
        for (&(row, of), value) in entries.iter().zip(Function::last(&self.buffers)) {
            let column = columns.iter().position(|&column| column == of);
            if let (Some(column), Some(row)) = (column, row.checked_sub(*n_held)) {
                rates[row] += value * u[(least, column)];
            }
        }
        let largest = rates.iter().fold(0.0, |most: f64, rate| most.max(rate.abs()));
        let moves = |body: BodyId| {
            let own = |(of, rate): (&Moving, &f64)| {
                matches!(of, Moving::Body(known) if *known == body)
                    && rate.abs() > NO_PART * largest
            };
            moving.iter().zip(&rates).any(own)
        };
        // A joint between two bodies that move before one with a body at rest, one that turns before one that slides.
        let rank = |of: &Moving| {
            let (joint, turns) = match of {
                Moving::Turn(joint) => (*joint, true),
                Moving::Slide(joint) => (*joint, false),
                Moving::Body(_) => return None,
            };
            Some((bodies[joint.0].into_iter().all(moves), turns, joint))
        };
        let ranked =
            moving.iter().zip(&rates).filter_map(|(of, rate)| Some((rank(of)?, rate.abs())));
        let ranked = ranked.filter(|(_, rate)| *rate > NO_PART * largest);
        let best = ranked.max_by(|((a_inner, a_turns, _), a), ((b_inner, b_turns, _), b)| {
            (a_inner, a_turns).cmp(&(b_inner, b_turns)).then(a.total_cmp(b))
        })?;
        Some(best.0.2)
    }
}

/// True where the determinant is positive; none where it is not known.
fn is_positive(k: &DMatrix<f64>) -> Option<bool> {
    let lu = k.clone().lu();
    let n_negative = lu.u().diagonal().iter().filter(|pivot| **pivot < 0.0).count();
    let is_turned = lu.p().determinant::<f64>() < 0.0;
    let is_known = lu.u().diagonal().iter().all(|pivot| pivot.is_finite() && *pivot != 0.0);
    is_known.then_some((n_negative % 2 == 1) == is_turned)
}

/// A part of the way between two states.
fn between(from: &Last, (s, q, v): At<'_>, part: f64) -> (f64, Vec<f64>) {
    let h = s - from.s;
    let (c, c2, c3) = (part, part * part, part * part * part);
    let (at_from, at_to) = (2.0 * c3 - 3.0 * c2 + 1.0, 3.0 * c2 - 2.0 * c3);
    let (by_from, by_to) = (h * (c3 - 2.0 * c2 + c), h * (c3 - c2));
    let cubic = |i: usize| at_from * from.q[i] + by_from * from.v[i] + at_to * q[i] + by_to * v[i];
    (from.s + part * h, (0..q.len()).map(cubic).collect())
}
