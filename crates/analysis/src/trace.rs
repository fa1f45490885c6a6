//! [`Trace`]: the whole of a curve of positions, until it closes or goes no further.

use std::f64::consts::TAU;

use nalgebra::DVector;

use crate::curve::{Curve, Equations, Point};
use crate::path::Path;
use crate::rows::wrapped;
use crate::whole_turns::Turn;

/// Positions along one free motion, in order.
#[derive(Clone, Debug)]
pub(crate) struct Trace {
    /// The points; of a closed curve the first is also the last.
    pub(crate) points: Vec<Point>,
    /// Length of each step.
    pub(crate) steps: Vec<f64>,
    /// True if the curve comes back to where it began.
    pub(crate) is_closed: bool,
    /// True where something has turned so often that it is taken to turn for ever, and the curve has not closed.
    pub(crate) is_endless: bool,
}

/// Steps of a trace, in radians and lengths of the longest link: short, so that few pairs of zeros
/// of what is watched lie within one.
const STEP: f64 = 0.02;
const MOST_STEPS: usize = 60_000;
/// A curve that has gone this far, in lengths of the longest link, does not come back.
const FAR: f64 = 50.0;
/// Turns after which a curve that has not come back is left.
const MOST_TURNS: f64 = 20.0;

impl Trace {
    /// Follows `curve` from `x` in one direction, and where it does not close, in the other, too.
    pub(crate) fn through(curve: &mut Curve<Path<'_>>, x: &[f64]) -> Option<Self> {
        let first = curve.first_point(curve.equations.unknowns(x))?;
        let is_turn = curve.equations.rows.is_turn.clone();
        let (mut points, mut steps, end) = one_way(curve, &first, &is_turn);
        let is_closed = end == End::Closed;
        if !is_closed {
            let back = Point { tangent: -&first.tangent, z: first.z.clone() };
            let (others, lengths, _) = one_way(curve, &back, &is_turn);
            let turned = others.into_iter().skip(1).rev();
            let turned = turned.map(|p| Point { tangent: -&p.tangent, z: p.z });
            points = turned.chain(points).collect();
            steps = lengths.into_iter().rev().chain(steps).collect();
        }
        Some(Self { points, steps, is_closed, is_endless: end == End::Turning })
    }

    /// Whole turns that the way from its first point to its last one adds to angles.
    pub(crate) fn turn(&self, is_turn: &[bool]) -> Turn {
        let ends = self.points.first().zip(self.points.last());
        let [first, last] = ends.map_or_else(Default::default, |(first, last)| {
            [first, last].map(|point| point.z.as_slice().to_vec())
        });
        let turns = |i: usize| ((last[i] - first[i]) / TAU).round();
        let of = |i: usize| if is_turn.get(i) == Some(&true) { TAU * turns(i) } else { 0.0 };
        Turn { by: (0..first.len()).map(of).collect(), start: first }
    }

    /// The traces through `x` and through those of `others` that lie on none before.
    pub(crate) fn all(curve: &mut Curve<Path<'_>>, x: &[f64], others: &[Vec<f64>]) -> Vec<Self> {
        let mut traces: Vec<Self> = Vec::new();
        for x in std::iter::once(x).chain(others.iter().map(Vec::as_slice)) {
            let mut is_known = false;
            for trace in &traces {
                is_known |= trace.holds(curve, x);
            }
            if !is_known && let Some(trace) = Self::through(curve, x) {
                traces.push(trace);
            }
        }
        traces
    }

    /// True if a position, in units of the mechanism, lies on the curve.
    pub(crate) fn holds(&self, curve: &mut Curve<Path<'_>>, x: &[f64]) -> bool {
        for from in &self.points {
            let z = nearest_turn(&curve.equations.rows.is_turn, x, &from.z);
            let off = &z - &from.z;
            if off.norm() > 2.0 * STEP {
                continue;
            }
            let along = off.dot(&from.tangent);
            let mut there = &from.z + &from.tangent * along;
            let reached = curve.correct(&mut there, &from.tangent).is_some();
            if reached && (&there - &z).norm() < 1e-6 {
                return true;
            }
        }
        false
    }
}

/// A position with its angles within half a turn of those of another.
fn nearest_turn(is_turn: &[bool], x: &[f64], to: &DVector<f64>) -> DVector<f64> {
    DVector::from_fn(x.len(), |i, _| {
        let off = x[i] - to[i];
        to[i] + if is_turn[i] { wrapped(off) } else { off }
    })
}

/// The points of a curve in both directions, or until it closes; `is_turn` tells the unknowns of which whole turns mean
/// nothing.
pub(crate) fn closed_way<E: Equations>(
    curve: &mut Curve<E>,
    first: &Point,
    is_turn: &[bool],
) -> Vec<Point> {
    let (points, _, end) = one_way(curve, first, is_turn);
    if end == End::Closed {
        return points;
    }
    let back = Point { tangent: -&first.tangent, z: first.z.clone() };
    let (others, ..) = one_way(curve, &back, is_turn);
    let turned = others.into_iter().skip(1).rev();
    turned.map(|p| Point { tangent: -&p.tangent, z: p.z }).chain(points).collect()
}

/// The end of a curve in one direction.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    /// Where it began.
    Closed,
    /// After so many turns that more would tell nothing new.
    Turning,
    /// It goes no further, or far away.
    Open,
}

fn one_way<E: Equations>(
    curve: &mut Curve<E>,
    first: &Point,
    is_turn: &[bool],
) -> (Vec<Point>, Vec<f64>, End) {
    let mut points = vec![first.clone()];
    let mut steps = Vec::new();
    let n = is_turn.len();
    let mut ds = STEP;
    let mut gone = 0.0;
    for _ in 0..MOST_STEPS {
        let Some(from) = points.last().cloned() else { break };
        ds = ds.min(STEP);
        let Some((to, length)) = curve.step(&from, &mut ds) else { break };
        gone += length;

        // Back at the first point, in the same direction.
        let home = nearest_turn(is_turn, &first.z.as_slice()[..n], &from.z);
        let ahead = (&home - &from.z).dot(&from.tangent);
        let is_near = (&home - &from.z).norm() < 1.5 * length;
        if gone > 3.0 * length && is_near && ahead > 0.0 && ahead <= length {
            let mut z = &from.z + &from.tangent * ahead;
            let met = curve.correct(&mut z, &from.tangent).is_some() && (&z - &home).norm() < 1e-6;
            if met && from.tangent.dot(&first.tangent) > 0.9 {
                points.push(Point { z: home, tangent: first.tangent.clone() });
                steps.push(ahead);
                return (points, steps, End::Closed);
            }
        }
        let slid = (0..n).filter(|&i| !is_turn[i]).map(|i| (to.z[i] - first.z[i]).abs());
        let turned = (0..n).filter(|&i| is_turn[i]).map(|i| (to.z[i] - first.z[i]).abs() / TAU);
        let is_far = slid.fold(0.0, f64::max) > FAR;
        let is_turning = turned.fold(0.0, f64::max) > MOST_TURNS;
        points.push(to);
        steps.push(length);
        if is_far || is_turning {
            return (points, steps, if is_far { End::Open } else { End::Turning });
        }
    }
    (points, steps, End::Open)
}
