//! Crossings within a step, on its dense output.
//!
//! The functions are sampled at nine points. A change of sign brackets a crossing. Where a function
//! keeps its sign but turns back towards zero between samples, its extremum is looked for, so that
//! two crossings close together are not missed.

use super::{Crossing, Event, Events};
use crate::{SolveError, Start, Step};

/// Where a step is sampled, closer at its ends: an extremum needs a sample on either side.
const NODES: [f64; N_PARTS + 1] = [0.0, 0.02, 0.15, 0.325, 0.5, 0.675, 0.85, 0.98, 1.0];
/// Parts of a step between samples.
const N_PARTS: usize = 8;
/// The first sample after a restart.
const FRESH_NODE: f64 = 0.001;
/// Refinements of an extremum.
const MAX_EXTREMUM: usize = 24;
/// Refinements of a bracket; bisection alone needs 52.
const MAX_BRACKET: usize = 120;

/// Looks for the crossings of some [`Events`] in one step after the other; for callers with a loop of
/// their own in place of [`crate::solve_events`].
#[derive(Clone, Debug)]
pub struct EventSearch {
    /// Samples, one row of functions after the other; the first row outlives the step.
    samples: Vec<f64>,
    n: usize,
    scratch: Vec<f64>,
    y: Vec<f64>,
    ydot: Vec<f64>,
    found: Vec<Event>,
    /// The next step is the first after a restart.
    is_fresh: bool,
}

/// Whether two events count as simultaneous: the uncertainty of their location.
pub(super) fn is_same_instant(a: f64, b: f64) -> bool {
    (a - b).abs() <= 16.0 * f64::EPSILON * a.abs().max(b.abs())
}

/// Two times with the values of one function, of opposite sign or around an extremum.
#[derive(Clone, Copy)]
struct Bracket {
    a: (f64, f64),
    b: (f64, f64),
}

impl EventSearch {
    /// A search that begins at a state.
    pub fn new<E: Events>(events: &mut E, start: &Start) -> Self {
        let n = events.count();
        let mut search = Self {
            samples: vec![0.0; (N_PARTS + 1) * n],
            n,
            scratch: vec![0.0; n],
            y: vec![0.0; start.y.len()],
            ydot: vec![0.0; start.y.len()],
            found: Vec::with_capacity(2 * n),
            is_fresh: true,
        };
        events.values(start.t, &start.y, &mut search.samples[..n]);
        search
    }

    /// Continues from another state. Functions that have just fired are at zero whatever rounding
    /// makes of them, and must move away before they can cross again.
    pub fn restart<E: Events>(&mut self, events: &mut E, state: &Start) {
        events.values(state.t, &state.y, &mut self.samples[..self.n]);
        for event in &self.found {
            if is_same_instant(event.t, state.t) {
                self.samples[event.i] = 0.0;
            }
        }
        self.is_fresh = true;
    }

    /// The functions at the state reached, and whether it is that of a restart.
    pub fn remembered(&self) -> (Vec<f64>, bool) {
        (self.samples[..self.n].to_vec(), self.is_fresh)
    }

    /// Goes on with what [`EventSearch::remembered`] gave.
    ///
    /// # Errors
    /// [`SolveError::Checkpoint`] when there are more functions, or fewer.
    pub fn resume(&mut self, values: &[f64], is_fresh: bool) -> Result<(), SolveError> {
        if values.len() != self.n {
            return Err(SolveError::Checkpoint { reason: "saved with other events" });
        }
        self.samples[..self.n].copy_from_slice(values);
        self.is_fresh = is_fresh;
        Ok(())
    }

    /// The state on the step's dense output.
    pub(super) fn state_at(&mut self, step: &Step<'_>, t: f64) -> Start {
        step.at(t, &mut self.y);
        step.derivative_at(t, &mut self.ydot);
        Start { t, y: self.y.clone(), ydot: self.ydot.clone() }
    }

    /// All crossings of a step that count, in its order of time. Each step begins where the one
    /// before it ended.
    pub fn crossings<E: Events>(&mut self, events: &mut E, step: &Step<'_>) -> &[Event] {
        self.found.clear();
        if self.n == 0 {
            return &self.found;
        }
        let times: [f64; N_PARTS + 1] = std::array::from_fn(|k| self.time(step, k));
        for (k, &t) in times.iter().enumerate().skip(1) {
            step.at(t, &mut self.y);
            events.values(t, &self.y, &mut self.samples[k * self.n..(k + 1) * self.n]);
        }
        for i in 0..self.n {
            self.crossings_of(events, step, i, &times);
        }
        // Stable: functions that cross at the same instant keep their order.
        let forward = step.h().signum();
        self.found.sort_by(|a, b| (forward * a.t).total_cmp(&(forward * b.t)));

        self.samples.copy_within(N_PARTS * self.n.., 0);
        self.is_fresh = false;
        &self.found
    }

    /// Time of sample `k`. The first one after a restart comes early: it tells on which side of
    /// zero a function leaves that has just fired.
    fn time(&self, step: &Step<'_>, k: usize) -> f64 {
        let part = match k {
            0 => return step.t0(),
            N_PARTS => return step.t1(),
            1 if self.is_fresh => FRESH_NODE,
            _ => NODES[k],
        };
        step.t0() + part * (step.t1() - step.t0())
    }

    fn crossings_of<E: Events>(
        &mut self,
        events: &mut E,
        step: &Step<'_>,
        i: usize,
        times: &[f64; N_PARTS + 1],
    ) {
        let sample = |search: &Self, k: usize| (times[k], search.samples[k * search.n + i]);
        for k in 1..=N_PARTS {
            let (a, b) = (sample(self, k - 1), sample(self, k));
            if a.1 * b.1 < 0.0 || (b.1 == 0.0 && a.1 != 0.0) {
                self.keep(events, step, i, Bracket { a, b });
            }
            if k == N_PARTS {
                continue;
            }
            // An extremum near the middle of three samples of one sign, the middle nearest to zero.
            let c = sample(self, k + 1);
            let turns = a.1 * b.1 > 0.0
                && b.1 * c.1 > 0.0
                && b.1.abs() <= a.1.abs()
                && b.1.abs() <= c.1.abs();
            if turns && let Some(m) = self.opposite(events, step, i, a, c) {
                self.keep(events, step, i, Bracket { a, b: m });
                self.keep(events, step, i, Bracket { a: m, b: c });
            }
        }
    }

    /// Looks between `a` and `c` for a value of the other sign, by golden section on `|g|`.
    fn opposite<E: Events>(
        &mut self,
        events: &mut E,
        step: &Step<'_>,
        i: usize,
        a: (f64, f64),
        c: (f64, f64),
    ) -> Option<(f64, f64)> {
        const GOLDEN: f64 = 0.381_966_011_250_105_2; // (3 − √5)/2
        let sign = a.1.signum();
        let (mut left, mut right) = (a.0, c.0);
        let mut inner = [GOLDEN, 1.0 - GOLDEN].map(|part| left + part * (right - left));
        let mut g = inner.map(|t| sign * self.value(events, step, i, t));
        for _ in 0..MAX_EXTREMUM {
            for side in 0..2 {
                if g[side] < 0.0 {
                    return Some((inner[side], sign * g[side]));
                }
            }
            if g[0] < g[1] {
                right = inner[1];
                (inner[1], g[1]) = (inner[0], g[0]);
                inner[0] = left + GOLDEN * (right - left);
                g[0] = sign * self.value(events, step, i, inner[0]);
            } else {
                left = inner[0];
                (inner[0], g[0]) = (inner[1], g[1]);
                inner[1] = left + (1.0 - GOLDEN) * (right - left);
                g[1] = sign * self.value(events, step, i, inner[1]);
            }
        }
        None
    }

    /// Locates a bracketed crossing and keeps it if it counts.
    fn keep<E: Events>(&mut self, events: &mut E, step: &Step<'_>, i: usize, bracket: Bracket) {
        let crossing = if bracket.a.1 < 0.0 { Crossing::Rising } else { Crossing::Falling };
        let wanted = events.crossing(i);
        if wanted == Crossing::Either || wanted == crossing {
            let t = self.locate(events, step, i, bracket);
            self.found.push(Event { i, t, crossing });
        }
    }

    /// Shrinks the bracket to rounding by the Illinois rule, with a bisection where that stalls;
    /// returns the end beyond the crossing.
    fn locate<E: Events>(
        &mut self,
        events: &mut E,
        step: &Step<'_>,
        i: usize,
        Bracket { mut a, mut b }: Bracket,
    ) -> f64 {
        for iteration in 0..MAX_BRACKET {
            let width = b.0 - a.0;
            let rounding = 4.0 * f64::EPSILON * a.0.abs().max(b.0.abs());
            if width.abs() <= rounding.max(1e-15 * step.h().abs()) {
                break;
            }
            let secant = b.0 - width * b.1 / (b.1 - a.1);
            let is_inside = (secant - a.0) * (secant - b.0) < 0.0;
            let bisect = iteration % 3 == 2 || !is_inside;
            let t = if bisect { a.0 + 0.5 * width } else { secant };
            if t == a.0 || t == b.0 {
                break;
            }
            let g = self.value(events, step, i, t);
            if g * a.1 > 0.0 {
                a = (t, g);
                b.1 *= 0.5;
            } else {
                b = (t, g);
                a.1 *= 0.5;
            }
        }
        b.0
    }

    fn value<E: Events>(&mut self, events: &mut E, step: &Step<'_>, i: usize, t: f64) -> f64 {
        step.at(t, &mut self.y);
        events.values(t, &self.y, &mut self.scratch);
        self.scratch[i]
    }
}
