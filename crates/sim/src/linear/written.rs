//! The projection of a state, and the refinement of its accelerations, written down as arithmetic of a tape.
//!
//! Operations are those of the multiplier system in the same order, so that the code gives the same bits.

use bksim_expr::{Composition, Function, Tape, Value};

use crate::linear::elimination::Elimination;
use crate::linear::shape::Shape;

/// A mechanism all of whose constraint rows take part.
pub(crate) struct WrittenSystem<'a> {
    shape: &'a Shape,
    /// G, g and ∂g/∂t of (t, q).
    constraints: &'a Tape,
    elimination: Elimination,
}

/// A position, and the constraints there.
pub(crate) struct WrittenPosition {
    pub(crate) q: Vec<Value>,
    jacobian: Vec<Value>,
    value: Vec<Value>,
    rate: Vec<Value>,
    /// The largest |g|, m or rad.
    pub(crate) gap: Value,
}

impl<'a> WrittenSystem<'a> {
    pub(crate) fn new(shape: &'a Shape, constraints: &'a Tape) -> Self {
        let rows: Vec<usize> = (0..shape.nc).collect();
        Self { shape, constraints, elimination: Elimination::new(shape, &rows) }
    }

    /// A position as it is.
    pub(crate) fn position(
        &self,
        recorder: &mut Composition,
        t: Value,
        q: &[Value],
    ) -> WrittenPosition {
        let rows = recorder.call(self.constraints, &[&[t], q].concat());
        let (jacobian, rest) = rows.split_at(self.shape.jacobian.len());
        let (value, rate) = rest.split_at(self.shape.nc);
        let [jacobian, value, rate] = [jacobian, value, rate].map(<[Value]>::to_vec);
        let gap = largest(recorder, &value);
        WrittenPosition { q: q.to_vec(), jacobian, value, rate, gap }
    }

    /// The position after a step of Newton's method with these factors, kept where it closes the gap further, and the gap
    /// that the step has led to.
    pub(crate) fn newton_step(
        &self,
        recorder: &mut Composition,
        t: Value,
        factors: &[Value],
        from: &WrittenPosition,
    ) -> (WrittenPosition, Value) {
        let step = self.elimination.record_step(recorder, factors, &from.value);
        let trial = difference(recorder, &from.q, &step);
        let trial = self.position(recorder, t, &trial);
        let has_gained = recorder.apply(Function::Lt, &[trial.gap, from.gap]);
        let mut choose = |after: &[Value], before: &[Value]| {
            let choice =
                |(&after, &before)| recorder.apply(Function::If, &[has_gained, after, before]);
            after.iter().zip(before).map(choice).collect::<Vec<_>>()
        };
        let kept = WrittenPosition {
            q: choose(&trial.q, &from.q),
            jacobian: choose(&trial.jacobian, &from.jacobian),
            value: choose(&trial.value, &from.value),
            rate: choose(&trial.rate, &from.rate),
            gap: choose(&[trial.gap], &[from.gap])[0],
        };
        (kept, trial.gap)
    }

    /// G v + ∂g/∂t.
    pub(crate) fn rate(
        &self,
        recorder: &mut Composition,
        at: &WrittenPosition,
        v: &[Value],
    ) -> Vec<Value> {
        let mut rate = at.rate.clone();
        for (&(row, i), &value) in self.shape.jacobian.iter().zip(&at.jacobian) {
            let product = recorder.multiply(value, v[i]);
            rate[row] = recorder.add(rate[row], product);
        }
        rate
    }

    /// Velocities without the part that has this rate, by these factors.
    pub(crate) fn velocities(
        &self,
        recorder: &mut Composition,
        factors: &[Value],
        rate: &[Value],
        v: &[Value],
    ) -> Vec<Value> {
        let step = self.elimination.record_step(recorder, factors, rate);
        difference(recorder, v, &step)
    }

    /// Accelerations and multipliers after one step of iterative refinement; `terms` are M, G, f and γ.
    pub(crate) fn refined(
        &self,
        recorder: &mut Composition,
        terms: &[Value],
        factors: &[Value],
        solution: &[Value],
    ) -> Vec<Value> {
        let Shape { nq, nc, ref mass, ref jacobian, .. } = *self.shape;
        let (a, lambda) = solution.split_at(nq);
        let (of_mass, rest) = terms.split_at(mass.len());
        let (of_jacobian, rest) = rest.split_at(jacobian.len());
        let (force, gamma) = rest.split_at(nq);

        // What is left of the equations.
        let mut left: Vec<Value> = force.to_vec();
        left.extend(gamma[..nc].iter().map(|&gamma| recorder.negate(gamma)));
        let mut subtract = |place: usize, factor: Value, of: Value| {
            let product = recorder.multiply(factor, of);
            left[place] = recorder.subtract(left[place], product);
        };
        for (&(i, j), &m) in mass.iter().zip(of_mass) {
            subtract(i, m, a[j]);
            if i != j {
                subtract(j, m, a[i]);
            }
        }
        for (&(row, i), &g) in jacobian.iter().zip(of_jacobian) {
            subtract(i, g, lambda[row]);
            subtract(nq + row, g, a[i]);
        }

        // The change that takes it away.
        let left: Vec<Option<Value>> = left.into_iter().map(Some).collect();
        let change = self.elimination.record_solution(recorder, factors, &left);
        let sums = solution.iter().zip(change);
        sums.map(|(&value, change)| recorder.add(value, change)).collect()
    }
}

/// The largest magnitude; NaN where there is one.
pub(crate) fn largest(recorder: &mut Composition, values: &[Value]) -> Value {
    let none = recorder.constant(0.0);
    values.iter().fold(none, |largest, &value| {
        let size = recorder.apply(Function::Abs, &[value]);
        recorder.apply(Function::Max, &[largest, size])
    })
}

fn difference(recorder: &mut Composition, from: &[Value], step: &[Value]) -> Vec<Value> {
    from.iter().zip(step).map(|(&x, &step)| recorder.subtract(x, step)).collect()
}
