//! Six-bars whose output rests while the crank turns on: a coupler point goes nearly on a circle, and a link as long as its
//! radius leads from it to the pin of a second rocker, which rests as long as that pin is the circle's centre.
//!
//! ```text
//! P(φ) = B + w e^{iα}        |P(φ) − O| ≈ R   for φ₀ ≤ φ ≤ φ₀ + δ
//! Q: |Q − P(φ)| = R, |Q − G| = g             ψ(φ) = arg(Q − G), rests at arg(O − G)
//! ```
//!
//! Crank-rockers of many shapes are tried with the circle of least squares (Kåsa) through each part of their curves; the
//! best are improved by steps at random, and get the rocker with the best transmission. Nearly straight parts rest an arm with
//! a slot ([`slide`](super::slide)). Source: Norton, Design of Machinery, ch. 3.9.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, Vector3};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde::Deserialize;

use super::curves::{Curve, FINE, Part, Shape, TURN, places, pose, searched, width};
use super::four_bar::{FourBar, Second, distance};
use super::lines::pin;
use super::slide::{self, Line};
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
    /// Kind of the link that rests: a rocker unless given.
    #[serde(default)]
    output: OutputKind,
    /// Distance of the pivots of the four-bar; 1 m unless given.
    ground: Option<Written>,
    /// Number of linkages; 5 unless given.
    candidates: Option<usize>,
    /// Four-bars that are tried; 4000 unless given.
    starts: Option<usize>,
}

/// Kind of the link that a coupler point moves.
#[derive(Clone, Copy, Default, PartialEq, Eq, Deserialize, Debug)]
#[serde(rename_all = "snake_case")]
enum OutputKind {
    /// A link and a second rocker.
    #[default]
    Rocker,
    /// A block in the slot of an arm.
    Slide,
}

/// A circle.
#[derive(Clone, Copy, Debug)]
struct Circle {
    centre: Point,
    radius: f64,
}

type Arc = Part<Circle>;

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

/// The best part of a coupler curve for a dwell.
fn arc(shape: &Shape, dwell: f64) -> Option<Arc> {
    let curve = Curve::of(shape)?;
    curve.best(dwell, |points| {
        let (centre, radius, off) = circle(points)?;
        let far = |p: &Point| (distance(*p, centre) - radius).abs();
        let farthest = curve.points.iter().map(far).fold(0.0, f64::max);
        // Links have lengths that can be built.
        let is_useful = radius < 5.0 && radius > 0.2 * curve.extent;
        is_useful.then_some((Circle { centre, radius }, [off, farthest]))
    })
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
        let q = joined(*p, arc.on.radius, out.pivot, out.length, out.side)?;
        let psi = (q[1] - out.pivot[1]).atan2(q[0] - out.pivot[0]);
        let along = (q[1] - p[1]).atan2(q[0] - p[0]);
        sine = sine.min((psi - along).sin().abs());
        let turns = all.last().map_or(0.0, |last| ((last - psi) / TAU).round());
        all.push(psi + TAU * turns);
    }
    Some((all, sine))
}

/// The second rocker with the best transmission among those that swing as wanted.
fn output(shape: &Shape, arc: &Arc, swing: f64) -> Option<Output> {
    let at = |k: usize| pose(shape, TAU * k as f64 / TURN as f64)?.point;
    let points = (0..TURN).map(at).collect::<Option<Vec<Point>>>()?;
    // Rockers of one direction swing less the longer they are: bisected to the wanted swing.
    let in_direction = |k: usize| {
        let (angle, side) = (PI * (k / 2) as f64 / 36.0, k.is_multiple_of(2));
        let of = |length: f64| {
            let [x, y] = arc.on.centre;
            let pivot = [x + length * angle.cos(), y + length * angle.sin()];
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
    let n = wish.starts.unwrap_or(4000).clamp(1, 1_000_000);
    let mut candidates: Vec<Candidate> = match wish.output {
        OutputKind::Rocker => {
            let found = searched(n, &|shape| arc(shape, dwell));
            let one = |(shape, arc): &(Shape, Arc)| {
                let out = output(shape, arc, swing)?;
                candidate(shape, arc, &out, (dwell, ground))
            };
            found.par_iter().filter_map(one).collect()
        }
        OutputKind::Slide => {
            let found = searched(n, &|shape| slide::straight(shape, dwell));
            let one = |(shape, part): &(Shape, Part<Line>)| {
                slide::candidate(shape, part, swing, (dwell, ground))
            };
            found.iter().filter_map(one).collect()
        }
    };
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
    let q = scaled(joined(points[0], arc.on.radius, out.pivot, out.length, out.side)?);
    let mut found = bar.candidate("dwell");
    found.model = bar.model_with("dwell", Some(Second::Rocker([pivot, q])));
    let least = bars.iter().map(FourBar::transmission).fold(f64::INFINITY, f64::min);
    let point = [shape[3] * ground, shape[4] * ground];
    for (name, value) in [
        ("dwell", dwell),
        ("dwell_from", arc.from),
        ("dwell_error", width(&all[..=n.min(FINE)])),
        ("swing", width(&all)),
        ("link", arc.on.radius * ground),
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
