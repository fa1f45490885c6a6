//! Six-bars whose output rests while the crank turns on: a coupler point goes nearly on a circle, and a link as long as its
//! radius leads from it to the pin of a second rocker, which rests as long as that pin is the circle's centre.
//!
//! ```text
//! P(φ) = B + w e^{iα}        |P(φ) − O| ≈ R   for φ₀ ≤ φ ≤ φ₀ + δ
//! Q: |Q − P(φ)| = R, |Q − G| = g             ψ(φ) = arg(Q − G), rests at arg(O − G)
//! ```
//!
//! Crank-rockers of many shapes are tried with the circle of least squares (Kåsa) through each part of their curves; the
//! best are improved by steps at random, and get the rocker with the best transmission. Source: Norton, Design of
//! Machinery, ch. 3.9.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};
use serde::Deserialize;

use super::four_bar::{FourBar, distance};
use super::lines::{on_coupler, pin};
use super::{Candidate, DesignError, Point, Synthesis, none, optional};
use crate::codes;
use crate::spec::Written;

#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct Wish {
    /// Angle of the crank during which the output rests.
    dwell: Written,
    /// Angle through which the output swings in the rest of the turn; 30° unless given.
    swing: Option<Written>,
    /// Distance of the pivots of the four-bar; 1 m unless given.
    ground: Option<Written>,
    /// Number of linkages; 5 unless given.
    candidates: Option<usize>,
    /// Four-bars that are tried; 4000 unless given.
    starts: Option<usize>,
}

/// Places of the crank in a turn.
const TURN: usize = 72;
/// Places of the crank in a turn, for what is reported.
const FINE: usize = 1440;
/// Four-bars that are improved, and steps of each.
const FOLLOWED: usize = 24;
const STEPS: usize = 400;
/// Least sine of transmission angles.
const LEAST_SINE: f64 = 0.5;

/// Crank, coupler, rocker over the ground, and the coupler point along and aside.
type Shape = [f64; 5];

fn pose([a, b, c, along, left]: &Shape, phi: f64) -> Option<FourBar> {
    let pivots = [[0.0, 0.0], [1.0, 0.0]];
    let crank_pin = [a * phi.cos(), a * phi.sin()];
    let rocker_pin = pin(crank_pin, *b, pivots[1], *c)?;
    let point = Some(on_coupler(crank_pin, rocker_pin, *along, *left));
    Some(FourBar { pivots, pins: [crank_pin, rocker_pin], point })
}

/// True of a crank-rocker that transmits well enough over its turn.
fn turns([a, b, c, ..]: &Shape) -> bool {
    let cosine = |d: f64| ((b * b + c * c - d * d) / (2.0 * b * c)).abs();
    *a > 0.05 && *a < b.min(*c).min(1.0) && {
        let least = (1.0 - LEAST_SINE * LEAST_SINE).sqrt();
        cosine(1.0 - a) < least && cosine(1.0 + a) < least
    }
}

/// A part of a curve that is nearly on a circle.
#[derive(Clone, Copy, Debug)]
struct Arc {
    /// Angle of the crank where it begins.
    from: f64,
    centre: Point,
    radius: f64,
    /// Largest distance from the circle over the extent of the curve.
    off: f64,
}

/// The circle of least squares through points, and the largest distance from it.
fn circle(points: &[Point]) -> Option<(Point, f64, f64)> {
    let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for [x, y] in points {
        let row = Vector3::new(*x, *y, 1.0);
        matrix += row * row.transpose();
        right += row * (x * x + y * y);
    }
    let found = matrix.lu().solve(&right)?;
    let centre = [0.5 * found[0], 0.5 * found[1]];
    let radius = (found[2] + centre[0].powi(2) + centre[1].powi(2)).max(0.0).sqrt();
    let off = points.iter().map(|p| (distance(*p, centre) - radius).abs()).fold(0.0, f64::max);
    (radius.is_finite() && off.is_finite()).then_some((centre, radius, off))
}

/// Places of a turn that a dwell passes, to the nearest.
fn places(dwell: f64, of_turn: usize) -> usize {
    (1..=of_turn).filter(|&k| TAU * (k as f64 - 0.5) / of_turn as f64 <= dwell).count()
}

/// The best part of a coupler curve for a dwell.
fn arc(shape: &Shape, dwell: f64) -> Option<Arc> {
    if !turns(shape) {
        return None;
    }
    let at = |k: usize| pose(shape, TAU * k as f64 / TURN as f64)?.point;
    let curve = (0..TURN).map(at).collect::<Option<Vec<Point>>>()?;
    let extent = |axis: usize| {
        let all = || curve.iter().map(|p| p[axis]);
        all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
    };
    let extent = extent(0).hypot(extent(1));
    let n = places(dwell, TURN).clamp(3, TURN - 6);
    let part = |k: usize| {
        let points: Vec<Point> = (k..=k + n).map(|k| curve[k % TURN]).collect();
        let (centre, radius, off) = circle(&points)?;
        // The rest of the curve has to leave the circle, or nothing ever moves, and links have lengths that can be built.
        let farthest =
            curve.iter().map(|p| (distance(*p, centre) - radius).abs()).fold(0.0, f64::max);
        let is_useful = farthest > 0.15 * extent && radius < 5.0 && radius > 0.2 * extent;
        let from = TAU * k as f64 / TURN as f64;
        is_useful.then_some(Arc { from, centre, radius, off: off / farthest })
    };
    (0..TURN).filter_map(part).min_by(|a, b| a.off.total_cmp(&b.off))
}

/// A four-bar at random, and what steps at random make of it.
fn improved(shape: Shape, dwell: f64, seed: u64) -> Option<(Shape, Arc)> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut best = (shape, arc(&shape, dwell)?);
    let mut size = 0.1;
    for _ in 0..STEPS {
        let mut next = best.0;
        for x in &mut next {
            *x += size * random.random_range(-1.0..1.0);
        }
        match arc(&next, dwell) {
            Some(arc) if arc.off < best.1.off => best = (next, arc),
            _ => size = (0.985 * size).max(1e-3),
        }
    }
    Some(best)
}

/// The second rocker: its pivot and length, the swing, and the least sine of the transmission at its pin.
#[derive(Clone, Copy, Debug)]
struct Output {
    pivot: Point,
    length: f64,
    side: bool,
    swing: f64,
    sine: f64,
}

/// The pin of the second rocker at a place of the coupler point.
fn joined(p: Point, radius: f64, pivot: Point, length: f64, side: bool) -> Option<Point> {
    if side { pin(p, radius, pivot, length) } else { pin(pivot, length, p, radius) }
}

/// Angles of the second rocker over a turn, each less than half a turn from the one before.
fn angles(points: &[Point], arc: &Arc, out: &Output) -> Option<(Vec<f64>, f64)> {
    let (mut all, mut sine) = (Vec::<f64>::with_capacity(points.len()), f64::INFINITY);
    for p in points {
        let q = joined(*p, arc.radius, out.pivot, out.length, out.side)?;
        let psi = (q[1] - out.pivot[1]).atan2(q[0] - out.pivot[0]);
        let along = (q[1] - p[1]).atan2(q[0] - p[0]);
        sine = sine.min((psi - along).sin().abs());
        let turns = all.last().map_or(0.0, |last| ((last - psi) / TAU).round());
        all.push(psi + TAU * turns);
    }
    Some((all, sine))
}

fn width(values: &[f64]) -> f64 {
    let fold = |f: fn(f64, f64) -> f64| values.iter().copied().reduce(f).unwrap_or(0.0);
    fold(f64::max) - fold(f64::min)
}

/// The second rocker with the best transmission among those that swing as wanted.
fn output(shape: &Shape, arc: &Arc, swing: f64) -> Option<Output> {
    let at = |k: usize| pose(shape, TAU * k as f64 / TURN as f64)?.point;
    let points = (0..TURN).map(at).collect::<Option<Vec<Point>>>()?;
    // Rockers of one direction swing less the longer they are: bisected to the wanted swing.
    let in_direction = |k: usize| {
        let (angle, side) = (PI * (k / 2) as f64 / 36.0, k.is_multiple_of(2));
        let of = |length: f64| {
            let pivot =
                [arc.centre[0] + length * angle.cos(), arc.centre[1] + length * angle.sin()];
            let blank = Output { pivot, length, side, swing: 0.0, sine: 0.0 };
            let (all, sine) = angles(&points, arc, &blank)?;
            Some(Output { swing: width(&all), sine, ..blank })
        };
        let (mut short, mut long) = (0.02, 20.0);
        for _ in 0..40 {
            let middle = f64::sqrt(short * long);
            match of(middle) {
                Some(found) if found.swing < swing => long = middle,
                _ => short = middle,
            }
        }
        of(long).filter(|found| (found.swing - swing).abs() < 1e-4 && found.sine > 0.2)
    };
    (0..144).filter_map(in_direction).max_by(|a, b| a.sine.total_cmp(&b.sine))
}

pub(super) fn solve(wish: &Wish) -> Result<Synthesis, DesignError> {
    let dwell = super::si(&wish.dwell)?;
    let swing = optional(wish.swing.as_ref())?.unwrap_or(PI / 6.0);
    let ground = optional(wish.ground.as_ref())?.unwrap_or(1.0);
    if !(0.1..5.5).contains(&dwell)
        || !(0.01..2.5).contains(&swing)
        || ground.is_nan()
        || ground <= 0.0
    {
        let message = "the dwell, the swing or the ground has no size that a linkage can have";
        let help =
            "write `dwell` from 6 to 315 deg, `swing` from 1 to 140 deg, and `ground` above zero";
        return Err(DesignError::fault(codes::BAD_QUESTION, message, help));
    }
    let mut random = Pcg64::seed_from_u64(7);
    let mut drawn = || -> Shape {
        let lengths = [0.1..0.6, 0.3..2.0, 0.3..2.0, -2.0..3.0, -2.0..2.0];
        lengths.map(|range| random.random_range(range))
    };
    let n = wish.starts.unwrap_or(4000).clamp(1, 1_000_000);
    let drawn: Vec<Shape> = (0..n).map(|_| drawn()).collect();
    let mut starts: Vec<(f64, Shape)> =
        drawn.into_par_iter().filter_map(|shape| Some((arc(&shape, dwell)?.off, shape))).collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    starts.truncate(FOLLOWED);
    let numbered: Vec<(u64, Shape)> = (0..).zip(starts.iter().map(|start| start.1)).collect();
    let found: Vec<(Shape, Arc, Output)> = numbered
        .par_iter()
        .filter_map(|(seed, shape)| {
            let (shape, arc) = improved(*shape, dwell, *seed)?;
            let out = output(&shape, &arc, swing)?;
            Some((shape, arc, out))
        })
        .collect();
    let one =
        |(shape, arc, out): &(Shape, Arc, Output)| candidate(shape, arc, out, (dwell, ground));
    let mut candidates: Vec<Candidate> = found.iter().filter_map(one).collect();
    candidates.sort_by(|a, b| a.numbers["dwell_error"].total_cmp(&b.numbers["dwell_error"]));
    candidates.truncate(wish.candidates.unwrap_or(5));
    if candidates.is_empty() {
        let help = "ask for a shorter `dwell` or less `swing`, or raise `starts`";
        return Err(none("no six-bar was found that rests so long and swings so far", help));
    }
    for (k, candidate) in candidates.iter_mut().enumerate() {
        let name = format!("dwell-{}", k + 1);
        candidate.model = candidate.model.replacen(&candidate.name, &name, 1);
        candidate.name = name;
    }
    Ok(Synthesis { task: "dwell".to_owned(), candidates, ..Synthesis::default() })
}

/// The six-bar at its size, with what a fine turn of its crank shows.
fn candidate(
    shape: &Shape,
    arc: &Arc,
    out: &Output,
    (dwell, ground): (f64, f64),
) -> Option<Candidate> {
    let bars = (0..=FINE).map(|k| pose(shape, arc.from + TAU * k as f64 / FINE as f64));
    let bars = bars.collect::<Option<Vec<FourBar>>>()?;
    let points = bars.iter().map(|bar| bar.point).collect::<Option<Vec<Point>>>()?;
    let (all, sine) = angles(&points, arc, out)?;
    let n = places(dwell, FINE);
    let scaled = |p: Point| p.map(|x| x * ground);
    let first = &bars[0];
    let bar = FourBar {
        pivots: first.pivots.map(scaled),
        pins: first.pins.map(scaled),
        point: first.point.map(scaled),
    };
    let pivot = scaled(out.pivot);
    let q = scaled(joined(points[0], arc.radius, out.pivot, out.length, out.side)?);
    let mut found = bar.candidate("dwell");
    found.model = bar.model_with("dwell", Some([pivot, q]));
    let least = bars.iter().map(FourBar::transmission).fold(f64::INFINITY, f64::min);
    let point = [shape[3] * ground, shape[4] * ground];
    for (name, value) in [
        ("dwell", dwell),
        ("dwell_from", arc.from),
        ("dwell_error", width(&all[..=n.min(FINE)])),
        ("swing", width(&all)),
        ("link", arc.radius * ground),
        ("output", out.length * ground),
        ("pivot_3_x", pivot[0]),
        ("pivot_3_y", pivot[1]),
        ("pin_3_x", q[0]),
        ("pin_3_y", q[1]),
        ("point_along_coupler", point[0]),
        ("point_left_of_coupler", point[1]),
        ("least_transmission_angle", least),
        ("least_transmission_angle_of_output", sine.asin()),
    ] {
        found.numbers.insert(name.to_owned(), value);
    }
    Some(found)
}
