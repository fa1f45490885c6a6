//! Whole turns of equilibria: each is told in the turn that is nearest to the start, where the forces are the same in all.

use std::f64::consts::TAU;

use bksim_mbs::coordinate::CoordinateKind;

use crate::balance::Balance;

/// Part of a difference of two angles that is rounding.
const ROUNDING: f64 = 1e-9;

impl Balance<'_> {
    /// A position of a motion that has the same forces turn after turn, in that turn in which its angles are nearest to the
    /// start; `turn` is what a turn adds to the coordinates.
    pub(crate) fn in_turn_of_motion(&self, q: &[f64], turn: &[f64]) -> Vec<f64> {
        let start = self.start();
        let farthest = |a: &[f64], b: &[f64]| {
            let turning = (0..a.len()).filter(|&i| turn[i] != 0.0);
            turning.map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max)
        };
        let zero = vec![0.0; q.len()];
        let mut best = q.to_vec();
        for number in [-1.0, 1.0] {
            loop {
                let next: Vec<f64> = best.iter().zip(turn).map(|(q, t)| q + number * t).collect();
                let gain = farthest(&best, &start) - farthest(&next, &start);
                // Of two that are as near, that with the smaller angles.
                let is_tie = gain.abs() <= ROUNDING;
                let is_smaller = farthest(&next, &zero) < farthest(&best, &zero) - ROUNDING;
                if !(gain > ROUNDING || is_tie && is_smaller) {
                    break;
                }
                best = next;
            }
        }
        best
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
