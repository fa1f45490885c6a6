//! Coupler curves of crank-rockers, and their parts that are nearly on a line or circle: those of many at random are tried, and
//! the best improved by steps at random.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::Point;
use super::four_bar::FourBar;
use super::lines::{on_coupler, pin};

/// Places of the crank in a turn.
pub(super) const TURN: usize = 72;
/// Places of the crank in a turn, for what is reported.
pub(super) const FINE: usize = 1440;
/// Four-bars that are improved, and steps of each.
const FOLLOWED: usize = 24;
const STEPS: usize = 400;
/// Least sine of transmission angles.
const LEAST_SINE: f64 = 0.5;

/// Crank, coupler, rocker over the ground, and the coupler point along and aside.
pub(super) type Shape = [f64; 5];

pub(super) fn pose([a, b, c, along, left]: &Shape, phi: f64) -> Option<FourBar> {
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

/// A part of a curve that is nearly on a line or circle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part<T> {
    /// Angle of the crank where it begins.
    pub(super) from: f64,
    pub(super) on: T,
    /// Largest distance from that, over the largest of the whole curve.
    pub(super) off: f64,
}

/// A coupler curve at even angles of the crank, and its extent.
pub(super) struct Curve {
    pub(super) points: Vec<Point>,
    pub(super) extent: f64,
}

impl Curve {
    /// The curve of a crank-rocker that transmits well enough.
    pub(super) fn of(shape: &Shape) -> Option<Self> {
        if !turns(shape) {
            return None;
        }
        let at = |k: usize| pose(shape, TAU * k as f64 / TURN as f64)?.point;
        let points = (0..TURN).map(at).collect::<Option<Vec<Point>>>()?;
        let extent = |axis: usize| {
            let all = || points.iter().map(|p| p[axis]);
            all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
        };
        let extent = extent(0).hypot(extent(1));
        Some(Self { points, extent })
    }

    /// The best part for a dwell: `fit` gives what some points are on, and the largest distance of these from it and of the
    /// whole curve.
    pub(super) fn best<T>(
        &self,
        dwell: f64,
        fit: impl Fn(&[Point]) -> Option<(T, [f64; 2])>,
    ) -> Option<Part<T>> {
        let n = places(dwell, TURN).clamp(3, TURN - 6);
        let part = |k: usize| {
            let points: Vec<Point> = (k..=k + n).map(|k| self.points[k % TURN]).collect();
            let (on, [off, farthest]) = fit(&points)?;
            // The rest of the curve has to leave it, or nothing ever moves.
            let from = TAU * k as f64 / TURN as f64;
            (farthest > 0.15 * self.extent).then_some(Part { from, on, off: off / farthest })
        };
        (0..TURN).filter_map(part).min_by(|a, b| a.off.total_cmp(&b.off))
    }
}

/// Places of a turn that a dwell passes, to the nearest.
pub(super) fn places(dwell: f64, of_turn: usize) -> usize {
    (1..=of_turn).filter(|&k| TAU * (k as f64 - 0.5) / of_turn as f64 <= dwell).count()
}

/// A four-bar at random, and what steps at random make of it.
fn improved<T: Copy>(
    shape: Shape,
    best_of: &dyn Fn(&Shape) -> Option<Part<T>>,
    seed: u64,
) -> Option<(Shape, Part<T>)> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut best = (shape, best_of(&shape)?);
    let mut size = 0.1;
    for _ in 0..STEPS {
        let mut next = best.0;
        for x in &mut next {
            *x += size * random.random_range(-1.0..1.0);
        }
        match best_of(&next) {
            Some(part) if part.off < best.1.off => best = (next, part),
            _ => size = (0.985 * size).max(1e-3),
        }
    }
    Some(best)
}

/// Crank-rockers with the best parts of their curves, the best of `n` at random, improved.
pub(super) fn searched<T: Copy + Send>(
    n: usize,
    best_of: &(dyn Fn(&Shape) -> Option<Part<T>> + Sync),
) -> Vec<(Shape, Part<T>)> {
    let mut random = Pcg64::seed_from_u64(7);
    let mut drawn = || -> Shape {
        let lengths = [0.1..0.6, 0.3..2.0, 0.3..2.0, -2.0..3.0, -2.0..2.0];
        lengths.map(|range| random.random_range(range))
    };
    let drawn: Vec<Shape> = (0..n).map(|_| drawn()).collect();
    let mut starts: Vec<(f64, Shape)> =
        drawn.into_par_iter().filter_map(|shape| Some((best_of(&shape)?.off, shape))).collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    starts.truncate(FOLLOWED);
    let numbered: Vec<(u64, Shape)> = (0..).zip(starts.iter().map(|start| start.1)).collect();
    numbered.par_iter().filter_map(|(seed, shape)| improved(*shape, best_of, *seed)).collect()
}

/// Difference of the largest and the least of some values.
pub(super) fn width(values: &[f64]) -> f64 {
    let fold = |f: fn(f64, f64) -> f64| values.iter().copied().reduce(f).unwrap_or(0.0);
    fold(f64::max) - fold(f64::min)
}
