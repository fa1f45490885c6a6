//! Dense output of a step from its two ends alone, by Picard's iteration.
//!
//! ```text
//! u(0) = y0, u(1) = y1, u′(0) = h f0, u′(1) = h f1,  u′(θ_i) = h f(t0 + θ_i h, u(θ_i))   i = 1 … NODES
//! ```
//!
//! The polynomial that meets the ends is corrected by what `f` is on it, until its change is below the
//! tolerance: each pass gains about one order and a factor of the step size. It is exact to the order of
//! its degree, [`N_TERMS`].

use nalgebra::SMatrix;

use super::lanes::LaneWork;
use crate::dense::{ContinuousExtension, basis};
use crate::scale::Scale;
use crate::stats::Stats;
use crate::system::{LANES, Lanes, NotFinite, Ode};

/// Nodes inside of the step, near those of Chebyshev, in lanes.
const NODES: [Lanes; 2] = [[0.0302, 0.117, 0.25, 0.4132], [0.5868, 0.75, 0.883, 0.9698]];
const N_NODES: usize = 2 * LANES;

/// Terms that the ends alone decide.
const OF_ENDS: usize = 3;

/// Terms of the polynomial.
pub(super) const N_TERMS: usize = OF_ENDS + N_NODES;

/// Passes after which the polynomial is taken as it is.
const MOST_PASSES: usize = 14;

/// Buffers of the iteration.
pub(super) struct Picard {
    at: LaneWork,
    /// `h f(θ_i)`, unknown by unknown.
    slopes: Vec<[Lanes; 2]>,
    /// The inverse of the slopes of the last terms at the nodes, by rows.
    inverse: [[f64; N_NODES]; N_NODES],
    /// The largest values of the last terms at the nodes.
    largest: [f64; N_NODES],
    /// Values and slopes of the terms at the nodes.
    terms: [[[Lanes; 2]; 2]; N_TERMS],
    /// Largest change of a term of each unknown in a pass.
    change: Vec<f64>,
}

impl Picard {
    /// For `n` unknowns.
    pub(super) fn new(n: usize) -> Self {
        let at = |k: usize, theta: f64| basis(N_TERMS, k, theta);
        let terms: [[[Lanes; 2]; 2]; N_TERMS] = std::array::from_fn(|k| {
            [
                NODES.map(|nodes| nodes.map(|theta| at(k, theta).0)),
                NODES.map(|nodes| nodes.map(|theta| at(k, theta).1)),
            ]
        });
        let nodes = NODES.as_flattened();
        let slopes = SMatrix::from_fn(|i, k| at(OF_ENDS + k, nodes[i]).1);
        let slopes: SMatrix<f64, N_NODES, N_NODES> = slopes;
        let inverse = slopes.try_inverse().expect("the nodes differ");
        let largest = |k: usize| {
            let values = terms[OF_ENDS + k][0].as_flattened();
            values.iter().fold(0.0, |a: f64, b| a.max(b.abs()))
        };
        Self {
            at: LaneWork::new(n),
            slopes: vec![[[0.0; LANES]; 2]; n],
            inverse: inverse.transpose().into(),
            largest: std::array::from_fn(largest),
            terms,
            change: vec![0.0; n],
        }
    }

    /// The polynomial of the step from `last.y0` with the slope `f0` to `(y1, f1)`.
    ///
    /// # Errors
    /// [`NotFinite`] where `f` has no value inside of the step.
    pub(super) fn extend<S: Ode>(
        &mut self,
        system: &mut S,
        last: &mut ContinuousExtension,
        (f0, y1, f1): (&[f64], &[f64], &[f64]),
        scale: &Scale,
        stats: &mut Stats,
    ) -> Result<(), NotFinite> {
        let n = y1.len();
        for i in 0..n {
            last.take_ends(i, (f0[i], y1[i], f1[i]));
            (OF_ENDS..N_TERMS).for_each(|k| last.terms[k * n + i] = 0.0);
        }
        for _ in 0..MOST_PASSES {
            self.evaluate(system, last, stats)?;
            self.correct(last);
            if scale.rms(&self.change) < 0.1 {
                break;
            }
        }
        Ok(())
    }

    /// `h f` on the polynomial at all nodes.
    fn evaluate<S: Ode>(
        &mut self,
        system: &mut S,
        last: &ContinuousExtension,
        stats: &mut Stats,
    ) -> Result<(), NotFinite> {
        let n = last.y0.len();
        for half in 0..NODES.len() {
            for (i, y) in self.at.y.iter_mut().enumerate() {
                *y = [last.y0[i]; LANES];
                for (k, [values, _]) in self.terms.iter().enumerate() {
                    let term = last.terms[k * n + i];
                    y.iter_mut().zip(values[half]).for_each(|(y, value)| *y += term * value);
                }
            }
            let times = NODES[half].map(|theta| last.t0 + theta * last.h);
            self.at.evaluate(system, times, stats)?;
            for (slopes, f) in self.slopes.iter_mut().zip(&self.at.f) {
                slopes[half] = f.map(|f| last.h * f);
            }
        }
        Ok(())
    }

    /// The polynomial with these slopes at the nodes.
    fn correct(&mut self, last: &mut ContinuousExtension) {
        let n = last.y0.len();
        for i in 0..n {
            let mut rest = self.slopes[i];
            for (k, [_, slopes]) in self.terms[..OF_ENDS].iter().enumerate() {
                let term = last.terms[k * n + i];
                let parts = rest.as_flattened_mut().iter_mut().zip(slopes.as_flattened());
                parts.for_each(|(rest, slope)| *rest -= term * slope);
            }
            self.change[i] = 0.0;
            for (k, (row, largest)) in self.inverse.iter().zip(self.largest).enumerate() {
                let term =
                    row.iter().zip(rest.as_flattened()).map(|(a, rest)| a * rest).sum::<f64>();
                let place = &mut last.terms[(OF_ENDS + k) * n + i];
                // Values of the term are far smaller than the term itself.
                self.change[i] = self.change[i].max(largest * (term - *place).abs());
                *place = term;
            }
        }
    }
}
