//! Observers of a run as it goes on, and the motion between samples as polynomials.
//!
//! A [`Segment`] holds q and v over one step of the integrator, not projected. Whatever polynomial
//! the method has over a step, it has a degree d, so its values at the d + 1 Chebyshev points of the
//! first kind are all of it:
//!
//! ```text
//! τ_k = cos((2k + 1) π / (2d + 2)),   t_k = (t0 + t1)/2 + τ_k (t1 − t0)/2,   k = 0 … d
//! u(τ) = Σ w_k u_k / (τ − τ_k)  /  Σ w_k / (τ − τ_k),   w_k = (−1)^k sin((2k + 1) π / (2d + 2))
//! ```
//!
//! The barycentric formula is stable there: J.-P. Berrut and L. N. Trefethen, *Barycentric Lagrange
//! Interpolation*, SIAM Review 46 (2004), (4.2) and (5.3).

use std::borrow::Cow;
use std::f64::consts::PI;
use std::sync::OnceLock;

use bksim_dae::Control;

use super::checkpoint::RunCheckpoint;
use super::pace::Slowness;
use super::sample::{Sample, StateSensitivity};
use crate::hybrid::Passage;
use crate::redundancy::UniquenessChange;

/// Receiver of the samples of a run as it goes on. Closures that take a sample are observers.
pub trait Observer {
    /// Takes a sample and says whether to go on; `by` holds one derivative per quantity in a run with
    /// sensitivities and nothing in others.
    fn sample(&mut self, sample: &Sample, by: &[StateSensitivity]) -> Control;

    /// True if [`Observer::segment`] is to be called: explicit steps make their dense output only
    /// where it is asked for, at a quarter of their cost.
    fn wants_segments(&self) -> bool {
        false
    }

    /// Takes the motion over a step, before the samples in it.
    fn segment(&mut self, _segment: &Segment) {}

    /// Learns of an event that has been passed, after the motion before it and its samples.
    fn passage(&mut self, _passage: &Passage) {}

    /// Learns which reactions are unique: at the start of a run, and wherever that changes.
    fn uniqueness(&mut self, _change: &UniquenessChange) {}

    /// Learns, once and as soon as it shows, that the run takes far more steps than expected, if it goes
    /// on.
    fn slow(&mut self, _slowness: &Slowness) {}

    /// True if a run is stopped that would take a million million steps.
    fn stops_hopeless_runs(&self) -> bool {
        true
    }

    /// True if [`Observer::checkpoint`] is to be called now; asked between two steps, when all samples of
    /// the first have been taken.
    fn wants_checkpoint(&mut self) -> bool {
        false
    }

    /// Takes a state from which the run could go on.
    fn checkpoint(&mut self, _checkpoint: &RunCheckpoint) {}
}

impl<F: FnMut(&Sample) -> Control> Observer for F {
    fn sample(&mut self, sample: &Sample, _: &[StateSensitivity]) -> Control {
        self(sample)
    }
}

/// A closure that takes samples with their sensitivities.
#[derive(Debug)]
pub struct WithSensitivities<F>(pub F);

impl<F: FnMut(&Sample, &[StateSensitivity]) -> Control> Observer for WithSensitivities<F> {
    fn sample(&mut self, sample: &Sample, by: &[StateSensitivity]) -> Control {
        self.0(sample, by)
    }
}

/// The motion over one step, or over the part of it before an event.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Segment {
    /// Where it begins, s.
    pub t0: f64,
    /// Where it ends, s; before `t0` in a run back in time.
    pub t1: f64,
    /// Values of q and v at the Chebyshev points, those of one point together: 2 nq (d + 1) numbers.
    pub values: Vec<f64>,
    /// Modes that hold here, as parameters after those of the model.
    pub modes: Vec<f64>,
    /// Constraint rows that follow from the others here.
    pub dependent: Vec<usize>,
}

impl Segment {
    /// Takes the motion of a step from `t0` to `t1`, a polynomial of this degree in `n` numbers that
    /// `at` writes.
    pub(super) fn take(
        &mut self,
        [t0, t1]: [f64; 2],
        degree: usize,
        n: usize,
        at: &mut dyn FnMut(f64, &mut [f64]),
    ) {
        (self.t0, self.t1) = (t0, t1);
        self.values.resize(n * (degree + 1), 0.0);
        let points = points(degree);
        for (values, [node, _]) in self.values.chunks_exact_mut(n.max(1)).zip(&*points) {
            at(0.5 * (t0 + t1) + 0.5 * node * (t1 - t0), values);
        }
    }

    /// True if it has a value at `t`.
    pub fn contains(&self, t: f64) -> bool {
        (t - self.t0) * (self.t1 - t) >= 0.0
    }

    /// Writes q and v at `t`, 2 nq numbers; extrapolated outside.
    ///
    /// # Panics
    /// If `state` has not as many numbers as there are at each point.
    pub fn at(&self, t: f64, state: &mut [f64]) {
        let n_points = self.values.len() / state.len().max(1);
        assert_eq!(self.values.len(), n_points * state.len(), "a state has 2 nq numbers");
        if n_points == 0 {
            return;
        }
        let degree = n_points - 1;
        let half = 0.5 * (self.t1 - self.t0);
        let tau = if half == 0.0 { 0.0 } else { (t - 0.5 * (self.t0 + self.t1)) / half };
        let mut whole = 0.0;
        state.fill(0.0);
        let points = points(degree);
        for (values, [node, weight]) in self.values.chunks_exact(state.len()).zip(&*points) {
            let distance = tau - node;
            if distance == 0.0 {
                state.copy_from_slice(values);
                return;
            }
            let weight = weight / distance;
            whole += weight;
            for (value, of_point) in state.iter_mut().zip(values) {
                *value += weight * of_point;
            }
        }
        for value in state {
            *value /= whole;
        }
    }
}

#[expect(clippy::cast_precision_loss, reason = "degrees are below ten")]
fn angle(k: usize, degree: usize) -> f64 {
    (2 * k + 1) as f64 * PI / (2 * degree + 2) as f64
}

/// The nodes and barycentric weights of a degree, of those that steps have kept.
fn points(degree: usize) -> Cow<'static, [[f64; 2]]> {
    /// No method has steps of a higher degree.
    const N_KEPT: usize = 32;
    static KEPT: [OnceLock<Vec<[f64; 2]>>; N_KEPT] = [const { OnceLock::new() }; N_KEPT];
    match KEPT.get(degree) {
        Some(kept) => kept.get_or_init(|| points_of(degree)).into(),
        None => points_of(degree).into(),
    }
}

fn points_of(degree: usize) -> Vec<[f64; 2]> {
    let point = |k: usize| {
        let sign = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        [angle(k, degree).cos(), sign * angle(k, degree).sin()]
    };
    (0..=degree).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_of_each_degree_is_itself() {
        for degree in 0..=7_i32 {
            let u = |t: f64| (0..=degree).map(|k| (t - 0.3).powi(k)).sum::<f64>();
            let mut at = |t: f64, y: &mut [f64]| (y[0], y[1]) = (u(t), -2.0 * u(t));
            let mut segment = Segment::default();
            let n_points = degree.unsigned_abs() as usize + 1;
            segment.take([2.0, 0.5], n_points - 1, 2, &mut at);
            assert_eq!(segment.values.len(), 2 * n_points);
            for t in [2.0, 1.7, 1.25, 0.9, 0.5] {
                let mut state = [0.0; 2];
                segment.at(t, &mut state);
                let size = u(2.0);
                assert!((state[0] - u(t)).abs() < 1e-14 * size, "{degree} at {t}: {state:?}");
                assert!((state[1] + 2.0 * u(t)).abs() < 2e-14 * size, "{degree} at {t}");
                assert!(segment.contains(t));
            }
            assert!(!segment.contains(2.1) && !segment.contains(0.4));
        }
    }
}
