//! Whole turns: of poses that differ by them alone, that which is nearest to the start is told.

use std::f64::consts::TAU;

use bksim_mbs::coordinate::CoordinateKind;

use crate::balance::Balance;

/// Part of a difference of two angles that is rounding.
const ROUNDING: f64 = 1e-9;
/// Turns to either side that are searched at most.
pub(crate) const MOST_TURNS: usize = 20;

/// A turn of a motion that closes: its addition to the unknowns, and where it began.
#[derive(Clone, Debug)]
pub(crate) struct Turn {
    /// Unknowns of the start.
    pub(crate) start: Vec<f64>,
    /// Whole turns of angles, and zeros.
    pub(crate) by: Vec<f64>,
}

impl Turn {
    /// Pose in the turn in which its angles are nearest to the start.
    pub(crate) fn nearest(&self, z: &[f64]) -> Vec<f64> {
        let turning: Vec<usize> = (0..z.len()).filter(|&i| self.by[i] != 0.0).collect();
        let farthest =
            |z: &[f64]| turning.iter().map(|&i| (z[i] - self.start[i]).abs()).fold(0.0, f64::max);
        let largest = |z: &[f64]| turning.iter().map(|&i| z[i].abs()).fold(0.0, f64::max);
        let mut best = z.to_vec();
        for number in [-1.0, 1.0] {
            loop {
                let next = self.later(&best, number);
                let gain = farthest(&best) - farthest(&next);
                // Of two that are as near, that with the smaller angles.
                let is_tie = gain.abs() <= ROUNDING;
                let is_smaller = largest(&next) < largest(&best) - ROUNDING;
                if !(gain > ROUNDING || is_tie && is_smaller) {
                    break;
                }
                best = next;
            }
        }
        best
    }

    /// Pose some turns later.
    pub(crate) fn later(&self, z: &[f64], number: f64) -> Vec<f64> {
        z.iter().zip(&self.by).map(|(z, by)| z + number * by).collect()
    }
}

impl Balance<'_> {
    /// Pose in the turn nearest to the start of those that stops allow; in the nearest of all where they allow none.
    pub(crate) fn allowed_turn(&mut self, turn: &Turn, q: &[f64]) -> Vec<f64> {
        let nearest = turn.nearest(q);
        let numbers = (0..=MOST_TURNS).flat_map(|k| [k as f64, -(k as f64)]);
        let mut turned = numbers.map(|number| turn.later(&nearest, number));
        turned.find(|q| self.stops.allow(q)).unwrap_or(nearest)
    }

    /// An equilibrium with each angle within half a turn of the start, as far as that leaves it an equilibrium: wheels that
    /// mesh and springs that count turns keep theirs.
    pub(crate) fn in_turn_of_start(&mut self, q: Vec<f64>) -> Vec<f64> {
        let start = self.start();
        let coordinates = self.loaded.system().coordinates();
        let nearer = |i: usize| match coordinates[i].kind {
            CoordinateKind::Angle => q[i] - TAU * ((q[i] - start[i]) / TAU).round(),
            _ => q[i],
        };
        let nearest: Vec<f64> = (0..q.len()).map(nearer).collect();
        let turned: Vec<usize> = (0..q.len()).filter(|&i| nearest[i] != q[i]).collect();
        if turned.is_empty() {
            return q;
        }
        if self.is_equilibrium(&nearest) {
            return nearest;
        }
        let mut found = q;
        for i in turned {
            let own = std::mem::replace(&mut found[i], nearest[i]);
            if !self.is_equilibrium(&found) {
                found[i] = own;
            }
        }
        found
    }
}
