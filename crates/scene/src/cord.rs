//! [`Cord`]: a rope or belt, whose way over pulleys follows from where these are.
//!
//! ```text
//! β = β₀ + σ (∠(e₊₀, e₊) − ∠(e₋₀, e₋))      turn about a pulley, σ = ±1 its sense; without a start from e₋ to e₊
//! ```
//!
//! Turns are counted from the start, as the equations count them: a string may be wound around a post.

use std::f64::consts::TAU;

use bksim_sim::belt::span_between;
use bksim_sim::pose::Pose;
use serde::Serialize;

use crate::Attached;
use crate::geometry::arc;

/// A rope, or a belt that is closed in itself, in the plane.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Cord {
    /// Name of the rope or belt.
    pub name: String,
    /// Ends of a rope and what it goes over, or the wheels of a belt, in its own order.
    pub places: Vec<CordPlace>,
    /// True of a belt.
    pub is_closed: bool,
}

/// An end of a rope, or something that it goes over.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct CordPlace {
    /// The point, or the centre of a pulley.
    pub at: Attached,
    /// Radius, m: below zero where the rope turns right, zero of a point.
    pub radius: f64,
    /// True if the rope leaves it instead of bending the other way.
    pub leaves: bool,
    /// The rope next to it at the start, if that is known.
    pub first: Option<FirstTurn>,
}

/// A rope next to a pulley at the start.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct FirstTurn {
    /// Direction in which it comes.
    pub before: [f64; 2],
    /// Direction in which it goes on.
    pub after: [f64; 2],
    /// Turn about the pulley, rad.
    pub turn: f64,
}

/// A centre, m, with its radius.
type Wheel = ([f64; 2], f64);

impl Cord {
    /// The line of the rope with its bodies at these poses, m; `None` where two neighbours leave no way between them.
    pub fn line(&self, poses: &[Pose]) -> Option<Vec<[f64; 3]>> {
        let laid = self.laid(poses)?;
        let mut line = Vec::new();
        for Laid { idx, wheel: (centre, radius), before, after } in laid {
            let place = &self.places[idx];
            let turn = before.zip(after).map(|(before, after)| place.turn(before, after));
            // The rope is at right angles to the radius, on the right of a wheel that it turns left about.
            let [x, y] = before.or(after)?;
            let angle = f64::atan2(-radius * x, radius * y);
            let on_wheel = match turn.filter(|_| radius != 0.0) {
                Some(turn) => arc(centre, radius.abs(), angle, angle + radius.signum() * turn),
                None if radius == 0.0 => vec![centre],
                None => arc(centre, radius.abs(), angle, angle)[..1].to_vec(),
            };
            line.extend(on_wheel.iter().map(|&[x, y]| [x, y, 0.0]));
        }
        if self.is_closed {
            line.extend(line.first().copied());
        }
        Some(line)
    }

    /// Takes the poses of the start, from which turns are counted.
    pub fn begin(&mut self, poses: &[Pose]) {
        let Some(wheels) = self.wheels(poses) else { return };
        let Some(laid) = self.laid(poses) else { return };
        let around = |place: &CordPlace, before, after| {
            let turn = place.turn(before, after);
            // One that begins beside a place may come to it from either side.
            (!place.leaves || turn >= 0.0).then_some(FirstTurn { before, after, turn })
        };
        for (k, place) in self.places.iter_mut().enumerate() {
            // What may be left has neighbours that are not.
            let [before, after] = match laid.iter().find(|laid| laid.idx == k && !place.leaves) {
                Some(laid) => [laid.before, laid.after],
                None if k == 0 || k + 1 == wheels.len() => continue,
                None => [direction(wheels[k - 1], wheels[k]), direction(wheels[k], wheels[k + 1])],
            };
            place.first = before.zip(after).and_then(|(a, b)| around(place, a, b));
        }
    }

    fn wheels(&self, poses: &[Pose]) -> Option<Vec<Wheel>> {
        let wheel = |place: &CordPlace| {
            let [x, y, _] = poses.get(place.at.body)?.place(place.at.position);
            Some(([x, y], place.radius))
        };
        self.places.iter().map(wheel).collect()
    }

    /// The places that the rope is in touch with, and its directions there.
    fn laid(&self, poses: &[Pose]) -> Option<Vec<Laid>> {
        let wheels = self.wheels(poses)?;
        let n = wheels.len();
        let mut kept = Vec::with_capacity(n);
        for (k, place) in self.places.iter().enumerate() {
            let is_kept = !place.leaves || k == 0 || k + 1 == n || {
                let before = direction(wheels[k - 1], wheels[k])?;
                place.turn(before, direction(wheels[k], wheels[k + 1])?) >= 0.0
            };
            kept.extend(is_kept.then_some(k));
        }
        let m = kept.len();
        let n_spans = if self.is_closed { m } else { m.saturating_sub(1) };
        let span = |i: usize| direction(wheels[kept[i]], wheels[kept[(i + 1) % m]]);
        let spans = (0..n_spans).map(span).collect::<Option<Vec<_>>>()?;
        let laid = |(i, &idx): (usize, &usize)| {
            let before = if self.is_closed { (i + m - 1) % m } else { i.wrapping_sub(1) };
            let [before, after] = [before, i].map(|span| spans.get(span).copied());
            Laid { idx, wheel: wheels[idx], before, after }
        };
        Some(kept.iter().enumerate().map(laid).collect())
    }
}

/// A place that the rope is in touch with, and the directions in which it comes there and goes on.
struct Laid {
    idx: usize,
    wheel: Wheel,
    before: Option<[f64; 2]>,
    after: Option<[f64; 2]>,
}

impl CordPlace {
    /// Turn of the rope about the place between two directions, rad.
    fn turn(&self, before: [f64; 2], after: [f64; 2]) -> f64 {
        let sense = self.radius.signum();
        match self.first {
            Some(first) => {
                let since = angle_from(first.after, after) - angle_from(first.before, before);
                first.turn + sense * since
            }
            None if self.leaves => sense * angle_from(before, after),
            None => (sense * angle_from(before, after)).rem_euclid(TAU),
        }
    }
}

/// Direction of the free span from one wheel to the next.
fn direction(from: Wheel, to: Wheel) -> Option<[f64; 2]> {
    Some(span_between(from, to)?.direction)
}

/// The angle from one direction to another, within ±180°, rad.
fn angle_from([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> f64 {
    (ax * by - ay * bx).atan2(ax * bx + ay * by)
}
