//! The proof that no place of pins in their holes makes a result larger than the one that was found.
//!
//! ```text
//! w* = r n     |w| ≤ r     Δ = w* − w       n·Δ ≥ |Δ|²/(2 r)
//! h(w*) − h(w) = ∫ ∇h·Δ ≥ Σᵢ gᵢ |Δᵢ|²/(2 rᵢ) − δᵢ |Δᵢ|
//! ```
//!
//! g is the least slope along n and δ the largest across it, over all places that may still be better. These are within
//! a distance of w* at which the last line vanishes; bounds of the slopes over that neighbourhood are closer, and after some
//! rounds what may be left is rounding.

use super::Job;
use crate::interval::Interval;
use crate::poses::{Pose, Solver};

/// Rounds at most, of the search and of the proof.
const ROUNDS: usize = 40;
/// Part of a result, or of what play does to it, up to which its end is known.
const KNOWN: f64 = 1e-13;
/// Slopes below this are rounding.
const NO_SLOPE: f64 = 1e-13;

impl Job<'_> {
    /// The largest `sign` times a result over all places of pins in their holes, at a corner of the parts, if that is proved.
    pub(super) fn aside(
        &self,
        solver: &mut Solver<'_>,
        pose: &Pose,
        (k, sign): (usize, f64),
        corner: &[f64],
    ) -> Option<f64> {
        let n = self.parts.len();
        let mut point = corner.to_vec();
        if self.plays.is_empty() {
            return self.value(solver, pose, &point, k).ok();
        }
        // Each pin is aside along its own slope.
        for _ in 0..ROUNDS {
            let p = (self.parameters)(&point)?;
            let here = solver.follow(pose, &p, &pose.u).ok()?;
            let slopes = solver.outputs(&here, &[])?.by_p;
            let before = point.clone();
            for (i, play) in self.plays.iter().enumerate() {
                let [x, y] = [0, 1].map(|axis| sign * slopes[(k, play.place + axis)]);
                let size = x.hypot(y);
                if size < NO_SLOPE {
                    continue;
                }
                point[n + 2 * i] = play.reach * x / size;
                point[n + 2 * i + 1] = play.reach * y / size;
            }
            if before == point {
                break;
            }
        }
        let value = self.value(solver, pose, &point, k).ok()?;
        self.is_largest(pose, (k, sign), &point, value).then_some(value)
    }

    /// True if no other places of the pins make a result larger, to rounding.
    fn is_largest(&self, pose: &Pose, (k, sign): (usize, f64), point: &[f64], value: f64) -> bool {
        let Some(steps) = &self.steps else { return false };
        let n = self.parts.len();
        let (of_parts, of_plays) = point.split_at(n);
        let mut rooms: Vec<f64> = self.plays.iter().map(|play| 2.0 * play.reach).collect();
        for _ in 0..ROUNDS {
            let near = |(i, &at): (usize, &f64)| {
                let (room, reach) = (rooms[i / 2], self.plays[i / 2].reach);
                Interval::new((at - room).max(-reach), (at + room).min(reach))
            };
            let parts = of_parts.iter().map(|&part| Interval::point(part));
            let places: Vec<Interval> =
                parts.chain(of_plays.iter().enumerate().map(near)).collect();
            let Some(slopes) = self.slopes_in(steps, pose, k, &places) else { return false };

            // By play: the least slope along its place, the largest across, and what that leaves open; none of a play without
            // effect.
            let bounds = |(i, play): (usize, &super::Play)| {
                let normal = [0, 1].map(|axis| sign * of_plays[2 * i + axis] / play.reach);
                let [x, y] = [slopes[n + 2 * i], slopes[n + 2 * i + 1]];
                let along = x.scaled(normal[0]).add(y.scaled(normal[1])).lo;
                let across = x.scaled(-normal[1]).add(y.scaled(normal[0])).size();
                // The place is on the edge of its hole to rounding.
                let across = across + 4.0 * f64::EPSILON * along.abs();
                let gain = across * across * play.reach / (2.0 * along);
                (x.size().max(y.size()) > NO_SLOPE).then_some((along, across, play.reach, gain))
            };
            let bounds: Vec<_> = self.plays.iter().enumerate().map(bounds).collect();
            if bounds.iter().flatten().any(|(along, ..)| along.is_nan() || *along <= 0.0) {
                return false;
            }
            let open: f64 = bounds.iter().flatten().map(|(.., gain)| gain).sum();
            let moved: f64 = bounds.iter().flatten().map(|(along, _, r, _)| along * r).sum();
            if open <= KNOWN * value.abs().max(moved) {
                return true;
            }
            let room = |of: &Option<(f64, f64, f64, f64)>| {
                of.map_or(f64::INFINITY, |(along, across, r, gain)| {
                    let others = (open - gain).max(0.0);
                    r / along * (across + (across * across + 2.0 * along / r * others).sqrt())
                })
            };
            let next: Vec<f64> = bounds.iter().map(room).collect();
            if next.iter().zip(&rooms).all(|(next, room)| next >= room) {
                return false;
            }
            for (room, next) in rooms.iter_mut().zip(next) {
                *room = room.min(next);
            }
        }
        false
    }
}
