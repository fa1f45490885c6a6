//! Equilibria along one free motion: the poses in which the work of the forces changes its sign.
//!
//! ```text
//! w(σ) = (Q − ∂V/∂q) · τ
//! w_k(σ), k = 0, ±1, …      the same in the k-th turn of a motion that closes
//! ```
//!
//! A motion that closes has the same poses turn after turn; a torsion spring counts turns, and so may laws of angles.

use nalgebra::DVector;

use crate::around::Way;
use crate::balance::Balance;
use crate::curve::{Curve, Point};
use crate::doctor::{crossing, orientation};
use crate::error::AnalysisError;
use crate::path::{Law, Path};
use crate::poses::Poses;
use crate::trace::Trace;
use crate::whole_turns::{MOST_TURNS, Turn};

/// Part of the largest work below which a difference of two is rounding.
const ROUNDING: f64 = 1e-9;
/// Part of what joints bear below which work along the motion is rounding.
const NO_WORK: f64 = 1e-12;

/// Positions in balance, those on stops with their numbers, and whether there are no others on the way.
type OneMotion = (Vec<Vec<f64>>, Vec<(usize, Vec<f64>)>, bool);

/// A zero of the work along a branch, and the branches that cross in it.
enum Zero {
    /// It is a zero of this branch alone, and a regular pose.
    Regular,
    /// Branches cross in it, and the forces work along one of them: no equilibrium.
    Unbalanced,
    /// The forces work along none of the branches that cross in this position.
    Balanced(Vec<f64>),
}

/// One free motion with whole turns of its angles.
struct Turns<'r> {
    curve: Curve<Path<'r>>,
    trace: Trace,
    /// The change of the unknowns in a turn.
    turn: DVector<f64>,
}

impl Turns<'_> {
    /// A point of the trace, some turns later.
    fn point(&self, k: usize, turns: f64) -> Point {
        let own = &self.trace.points[k];
        Point { z: &own.z + &self.turn * turns, tangent: own.tangent.clone() }
    }
}

impl Balance<'_> {
    /// Positions of the equilibria along the one free motion, and those in which a stop closes and is pressed on; from each of
    /// several poses where branches cross in the start.
    ///
    /// # Errors
    /// [`AnalysisError`] when there is not one free motion.
    pub(crate) fn along_free_motion(&mut self, from: &[Vec<f64>]) -> Result<Poses, AnalysisError> {
        let (mut found, mut on_stops, mut is_complete) = (Vec::new(), Vec::new(), true);
        for q in from {
            let (own, pressed, is_all) = self.along_motion_from(q)?;
            found.extend(own);
            on_stops.extend(pressed);
            is_complete &= is_all;
        }
        Ok(self.sorted(found, Some(on_stops), is_complete))
    }

    fn along_motion_from(&mut self, q: &[f64]) -> Result<OneMotion, AnalysisError> {
        let mut rows = self.loaded.rows()?;
        let is_turn = rows.is_turn.clone();
        let x = rows.scaled(q);
        let law = Law { t: self.loaded.t, ..Law::default() };
        let one = |n_free| AnalysisError::NotOneMotion { n_free };
        let mut curve = Path::through(&mut rows, (law, false), &x)
            .map_err(|no_path| self.loaded.no_path(no_path, one))?;
        let Some(trace) = Trace::through(&mut curve, &x) else {
            return Err(AnalysisError::NoEquilibrium);
        };
        let turn = DVector::from_vec(trace.turn(&is_turn).by);
        let mut turns = Turns { curve, trace, turn };

        let mut values = self.works(&turns, 0.0);
        let size = largest(&values);
        // What forces in balance leave by rounding.
        let lambda = self.balancing(q).unwrap_or_default();
        let rounding = NO_WORK * self.load_size(q, &lambda);
        let rounding = if rounding.is_finite() { rounding } else { 0.0 };
        if size <= rounding {
            return Ok((vec![q.to_vec()], Vec::new(), true));
        }
        values.iter_mut().filter(|value| value.abs() <= rounding).for_each(|value| *value = 0.0);
        let is_at_start = values[0] == 0.0;
        if turns.trace.is_closed {
            let next = self.works(&turns, 1.0);
            let off = values.iter().zip(&next).map(|(a, b)| (a - b).abs());
            if off.fold(0.0, f64::max) > ROUNDING * size {
                self.counts_turns = true;
                let (found, is_complete) = self.over_turns(&mut turns, &values);
                let on_stops = self.on_stops(&mut turns, rounding);
                return Ok((found, on_stops, is_complete));
            }
            // One pose, one value: rounding after a whole turn could hide an equilibrium in the start.
            let last = values.len() - 1;
            values[last] = values[0];
        }
        let mut found = self.zeros(&mut turns, 0.0, &values);
        // Of a closed curve, an equilibrium in the start lies at both ends.
        if is_at_start && turns.trace.is_closed {
            found.pop();
        }
        if is_at_start {
            found.insert(0, q.to_vec());
        }
        if turns.trace.is_closed {
            let turn = self.turn(&turns);
            found = found.iter().map(|q| self.allowed_turn(&turn, q)).collect();
        }
        let on_stops = self.on_stops(&mut turns, rounding);
        let have_values = values.iter().all(|value| value.is_finite());
        Ok((found, on_stops, turns.trace.is_closed && have_values))
    }

    /// A turn as coordinates count it.
    fn turn(&self, turns: &Turns<'_>) -> Turn {
        let by = turns.curve.equations.rows.unscaled(turns.turn.as_slice());
        Turn { start: self.start(), by }
    }

    /// Positions in which an open stop closes and forces press on it that do more work than `rounding`, each with the number of
    /// the stop.
    fn on_stops(&mut self, turns: &mut Turns<'_>, rounding: f64) -> Vec<(usize, Vec<f64>)> {
        let mut found = Vec::new();
        let turn = self.turn(turns);
        for stop in 0..self.stops.n() {
            // The trace once, or turn after turn where the stop counts turns.
            let first = self.stops.penetrations(&turn.start)[stop];
            let further = self.stops.penetrations(&turn.later(&turn.start, 1.0))[stop];
            let counts = turns.trace.is_closed && (further - first).abs() > ROUNDING;
            let most = if counts { MOST_TURNS } else { 0 };
            for point in self.closing(turns, stop, most) {
                let rows = &turns.curve.equations.rows;
                let mut q = rows.unscaled(point.z.as_slice());
                if turns.trace.is_closed && !counts {
                    q = turn.nearest(&q);
                }
                let direction = turns.curve.equations.rows.unscaled(point.tangent.as_slice());
                let work = self.work_of(&q, &direction);
                let slope = self.stops.along(&q, &direction)[stop];
                let is_pressed = slope != 0.0 && work * slope.signum() > rounding;
                // An angle that is known within a turn alone jumps, too.
                if is_pressed && self.stops.is_closed(stop, &q) && self.stops.allow(&q) {
                    found.push((stop, q));
                }
            }
        }
        found
    }

    /// Points of the trace in which the penetration of a stop is zero, over so many turns to either side.
    fn closing(&mut self, turns: &mut Turns<'_>, stop: usize, most: usize) -> Vec<Point> {
        let n_steps = turns.trace.steps.len();
        let turn_of = |k: usize| (k / n_steps.max(1)) as f64 - most as f64;
        // Where turns meet one point has one value.
        let last = (2 * most + 1) * n_steps;
        let place = |k: usize| {
            if k == last { (most as f64, n_steps) } else { (turn_of(k), k % n_steps.max(1)) }
        };
        let mut depths = Vec::with_capacity(last + 1);
        for k in 0..=last {
            let (number, at) = place(k);
            let z = turns.point(at, number).z;
            let q = turns.curve.equations.rows.unscaled(z.as_slice());
            depths.push(self.stops.penetrations(&q)[stop]);
        }
        if turns.trace.is_closed && most == 0 {
            depths[last] = depths[0];
        }
        let mut found = Vec::new();
        for k in 1..=last {
            let (before, after) = (depths[k - 1], depths[k]);
            if before == 0.0 || (before > 0.0) == (after > 0.0) && after != 0.0 {
                continue;
            }
            let (number, at) = place(k - 1);
            let (from, step) = (turns.point(at, number), turns.trace.steps[at]);
            found.extend(turns.curve.root(&from, step, (before, after), &mut |curve, point| {
                let q = curve.equations.rows.unscaled(point.z.as_slice());
                self.stops.penetrations(&q)[stop]
            }));
        }
        found
    }

    /// Equilibria of a motion that closes under forces that count its turns, those of `first` in the turn of the start.
    fn over_turns(&mut self, turns: &mut Turns<'_>, first: &[f64]) -> (Vec<Vec<f64>>, bool) {
        let found = self.zeros(turns, 0.0, first);
        let (mut before, backward_ends) = self.outward(turns, first, -1.0);
        let (after, forward_ends) = self.outward(turns, first, 1.0);
        before.reverse();
        let all = before.into_iter().flatten().chain(found).chain(after.into_iter().flatten());
        (all.collect(), backward_ends && forward_ends)
    }

    /// Equilibria of each further turn in one direction, and whether there are none beyond these.
    fn outward(
        &mut self,
        turns: &mut Turns<'_>,
        first: &[f64],
        direction: f64,
    ) -> (Vec<Vec<Vec<f64>>>, bool) {
        let mut found = Vec::new();
        let mut last = [Vec::new(), first.to_vec()];
        for (_, k) in (0..MOST_TURNS).zip(1_i32..) {
            let number = direction * f64::from(k);
            let mut values = self.works(turns, number);
            // One pose, one value, where turns meet.
            let [from, to] =
                if direction > 0.0 { [values.len() - 1, 0] } else { [0, values.len() - 1] };
            values[to] = last[1][from];
            found.push(self.zeros(turns, number, &values));

            // Work that changes by the same from turn to turn, away from zero, has no zero any more.
            let size = largest(&values);
            let inner = 1..values.len() - 1;
            let is_linear = !last[0].is_empty() && {
                let bend = |i: usize| (values[i] - 2.0 * last[1][i] + last[0][i]).abs();
                inner.clone().map(bend).fold(0.0, f64::max) <= ROUNDING * size
            };
            let mut grows = inner.map(|i| values[i] * (values[i] - last[1][i]));
            if is_linear && grows.all(|product| product > 0.0) {
                return (found, true);
            }
            let [_, previous] = last;
            last = [previous, values];
        }
        (found, false)
    }

    /// The work at every point of the trace, some turns later.
    fn works(&mut self, turns: &Turns<'_>, number: f64) -> Vec<f64> {
        let points = 0..turns.trace.points.len();
        points.map(|k| self.work_at(&turns.curve, &turns.point(k, number))).collect()
    }

    /// Zeros between points of the trace where the work has these values.
    fn zeros(&mut self, turns: &mut Turns<'_>, number: f64, values: &[f64]) -> Vec<Vec<f64>> {
        let mut found = Vec::new();
        for k in 1..values.len() {
            let (before, after) = (values[k - 1], values[k]);
            // Poses that are all in balance: one in their middle stands for them.
            if before == 0.0 && after == 0.0 {
                let is_last = values.get(k + 1).is_none_or(|next| *next != 0.0);
                let n_zeros = values[..=k].iter().rev().take_while(|value| **value == 0.0).count();
                if is_last {
                    let middle = turns.point(k - n_zeros / 2, number);
                    found.push(turns.curve.equations.rows.unscaled(middle.z.as_slice()));
                }
                continue;
            }
            let begins = after == 0.0 && values.get(k + 1) == Some(&0.0);
            if begins || before == 0.0 || (before > 0.0) == (after > 0.0) && after != 0.0 {
                continue;
            }
            let (from, step) = (turns.point(k - 1, number), turns.trace.steps[k - 1]);
            let ends = (&from, &turns.point(k, number));
            match self.zero_at_crossing(&mut turns.curve, ends, step) {
                Zero::Regular => {}
                Zero::Unbalanced => continue,
                Zero::Balanced(q) => {
                    found.push(q);
                    continue;
                }
            }
            let curve = &mut turns.curve;
            let root = curve.root(&from, step, (before, after), &mut |c, p| self.work_at(c, p));
            // Where loads have a pole their work has another sign on either side, and no zero.
            let most = 1e-6 * largest(&[before, after]);
            let root = root.filter(|point| self.work_at(curve, point).abs() <= most);
            if let Some(point) = root {
                found.push(curve.equations.rows.unscaled(point.z.as_slice()));
            }
        }
        found
    }

    /// The zero of the work between two points, by the branches that cross in it.
    fn zero_at_crossing(
        &mut self,
        curve: &mut Curve<Path<'_>>,
        (from, to): (&Point, &Point),
        step: f64,
    ) -> Zero {
        let signs = [orientation(curve, from), orientation(curve, to)];
        if signs[0] * signs[1] >= 0.0 {
            return Zero::Regular;
        }
        let there = crossing(curve, from, step, signs);
        let q = curve.equations.rows.unscaled(there.z.as_slice());
        let Some(ways) = self.ways_at(&q) else { return Zero::Regular };
        // The branch that is followed has the direction of both ends.
        let along = &from.tangent + &to.tangent;
        let is_nearer = |a: &&Way, b: &&Way| {
            let [a, b] = [a, b].map(|way| way.tangent.dot(&along).abs());
            a.total_cmp(&b)
        };
        let Some(own) = ways.iter().max_by(is_nearer) else { return Zero::Regular };
        if !self.rests_on_all(&q, std::slice::from_ref(own)) {
            return Zero::Regular;
        }
        if self.rests_on_all(&q, &ways) { Zero::Balanced(q) } else { Zero::Unbalanced }
    }

    /// Work of the forces per step along the motion, at rest.
    fn work_at(&mut self, curve: &Curve<Path<'_>>, point: &Point) -> f64 {
        let rows = &curve.equations.rows;
        let q = rows.unscaled(point.z.as_slice());
        self.work_of(&q, &rows.unscaled(point.tangent.as_slice()))
    }

    /// Work of the forces along a direction, at rest.
    fn work_of(&mut self, q: &[f64], direction: &[f64]) -> f64 {
        let nothing = vec![0.0; self.forces.nc()];
        let residual = self.at(q, &nothing).residual;
        -residual.iter().zip(direction).map(|(r, d)| r * d).sum::<f64>()
    }
}

/// The largest size.
fn largest(values: &[f64]) -> f64 {
    values.iter().filter(|x| x.is_finite()).fold(0.0, |a: f64, b| a.max(b.abs()))
}
