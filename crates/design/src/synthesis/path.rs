//! Four-bars whose coupler point passes through points, or near to them.
//!
//! ```text
//! nine points, free       all of them, by paths
//! any points              min Σ |P(φₖ) − Pₖ|²     φₖ free, or φ₀ + given angles
//! P(φ) = B + w e^{iα},  B = A + r e^{iφ},  α = arg(D − B) ± arccos((b² + |D − B|² − c²)/(2 b |D − B|))
//! ```

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};
use serde::Deserialize;

use super::four_bar::{FourBar, distance, in_order, one_circuit, side};
use super::nine_points::{self, N_TRIPLES};
use super::{Candidate, DesignError, Point, Synthesis, all_si, none, si};
use crate::base::Watch;
use crate::codes;
use crate::least_squares::{Loss, Residuals, least};
use crate::spec::Written;

type C = Complex<f64>;

#[derive(Deserialize, Debug)]
#[serde(deny_unknown_fields)]
pub(super) struct Wish {
    /// Places of the coupler point, one after the other.
    points: Vec<[Written; 2]>,
    /// Angles of the crank at the points, counted from anywhere.
    #[serde(default)]
    angles: Vec<Written>,
    /// Corners of a rectangle in which both pivots have to be.
    region: Option<[[Written; 2]; 2]>,
    /// Number of four-bars by least squares; 5 unless given.
    candidates: Option<usize>,
    /// Random four-bars that are tried; 4000 unless given.
    starts: Option<usize>,
}

pub(super) fn solve(wish: &Wish) -> Result<Synthesis, DesignError> {
    let point = |[x, y]: &[Written; 2]| Ok(C::new(si(x)?, si(y)?));
    let points = wish.points.iter().map(point).collect::<Result<Vec<C>, DesignError>>()?;
    let angles = all_si(&wish.angles)?;
    let bad = |message: String, help: &str| DesignError::fault(codes::BAD_QUESTION, message, help);
    if points.len() < 5 {
        let message = format!("{} points leave too much of a path open", points.len());
        return Err(bad(message, "give five points or more; nine have all four-bars"));
    }
    if !angles.is_empty() && angles.len() != points.len() {
        let message = format!("{} angles of the crank for {} points", angles.len(), points.len());
        return Err(bad(message, "give one of `angles` for each of `points`, or none"));
    }
    let size = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    let is_apart = |k: usize| (points[k] - points[k - 1]).norm() > 1e-9 * size;
    if size.is_nan() || size <= 0.0 || !(1..points.len()).all(is_apart) {
        let message = "two points in sequence are one".to_owned();
        return Err(bad(message, "give points that differ"));
    }
    let region = match &wish.region {
        None => None,
        Some([from, to]) => Some([point(from)?, point(to)?]),
    };
    let is_in = |p: C| {
        region.is_none_or(|[low, high]| {
            low.re <= p.re && p.re <= high.re && low.im <= p.im && p.im <= high.im
        })
    };
    let scaled: Vec<C> = points.iter().map(|p| (p - points[0]) / size).collect();
    let mut facts = BTreeMap::new();
    let bars = if points.len() == 9 && angles.is_empty() {
        all_of_nine(&scaled, &mut facts)
    } else {
        let n_starts = wish.starts.unwrap_or(4000).clamp(1, 1_000_000);
        by_least_squares(&scaled, &angles, n_starts)
    };
    // Back to the author's lengths.
    let unscaled = |z: C| z * size + points[0];
    let xy = |z: C| [unscaled(z).re, unscaled(z).im];
    let mut candidates = Vec::new();
    for bar in &bars {
        if bar.pivots.iter().all(|p| is_in(unscaled(*p))) {
            candidates.push(candidate(bar, size, &xy));
        }
    }
    candidates.sort_by(|a, b| {
        let (a, b) = (rank(a), rank(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    if bars.iter().all(|bar| bar.rms.is_some()) {
        candidates.truncate(wish.candidates.unwrap_or(5));
    }
    if candidates.is_empty() {
        let help = "widen `region`, raise `starts`, or move a point";
        return Err(none("no four-bar was found that passes these points", help));
    }
    facts.insert("real_four_bars".to_owned(), vec![candidates.len() as f64]);
    Ok(Synthesis { task: "path".to_owned(), facts, candidates, ..Synthesis::default() })
}

/// A four-bar in the first pose with its poses at all points, in units of the task, the first point in the origin.
struct Bar {
    name: String,
    pivots: [C; 2],
    /// Pins of each pose.
    pins: Vec<[C; 2]>,
    /// Coupler points of each pose.
    at: Vec<C>,
    /// Root of the mean square of the distances to the points, and the largest; none where it passes through them.
    rms: Option<[f64; 2]>,
}

/// All four-bars through nine points, the first in the origin.
fn all_of_nine(points: &[C], facts: &mut BTreeMap<String, Vec<f64>>) -> Vec<Bar> {
    let displacements = std::array::from_fn(|k| points[k + 1]);
    let all = nine_points::all(&displacements);
    for (name, value) in [
        ("triples_in_general", N_TRIPLES as f64),
        ("triples_found", all.n_triples as f64),
        ("triples_enclosed", all.n_certain as f64),
        ("real_triples", all.real.len() as f64),
        ("largest_miss_in_thirty_digits", all.left),
    ] {
        facts.insert(name.to_owned(), vec![value]);
    }
    let mut bars = Vec::new();
    for (triple, [a, b, x, y]) in all.real.iter().copied().enumerate() {
        // Roberts' and Chebyshev's theorem.
        let share = -x / (y - x);
        let c = a + (b - a) * share;
        let one = C::from(1.0);
        let cognates = [
            [a, b, x, y],
            [a, c, a - x, c + (y - b) * share],
            [b, c, b - y, c + (x - a) * (one - share)],
        ];
        for (k, [a, b, x, y]) in cognates.into_iter().enumerate() {
            let turns = points.iter().map(|&d| nine_points::turn([a, b, x, y], d));
            let pins = turns.zip(points).map(|(turn, p)| [p + turn * x, p + turn * y]).collect();
            let name = format!("path-{}-{}", triple + 1, k + 1);
            bars.push(Bar { name, pivots: [a, b], pins, at: points.to_vec(), rms: None });
        }
    }
    bars
}

fn candidate(bar: &Bar, size: f64, xy: &dyn Fn(C) -> Point) -> Candidate {
    let pose = |(pins, at): (&[C; 2], &C)| FourBar {
        pivots: bar.pivots.map(xy),
        pins: pins.map(xy),
        point: Some(xy(*at)),
    };
    let bars: Vec<FourBar> = bar.pins.iter().zip(&bar.at).map(pose).collect();
    let mut found = bars[0].candidate(&bar.name);
    let same = |of: &dyn Fn(&FourBar) -> f64| {
        let signs: Vec<bool> = bars.iter().map(|bar| of(bar) > 0.0).collect();
        signs.windows(2).all(|pair| pair[0] == pair[1])
    };
    let driven_at_1 = same(&|bar| side(bar.pins[0], bar.pins[1], bar.pivots[1]));
    let driven_at_2 = same(&|bar| side(bar.pins[1], bar.pins[0], bar.pivots[0]));
    for (name, holds) in [
        ("one_circuit", one_circuit(&bars)),
        ("one_branch_if_driven_at_1", driven_at_1),
        ("one_branch_if_driven_at_2", driven_at_2),
        ("in_order_at_1", in_order(&bars, 0)),
        ("in_order_at_2", in_order(&bars, 1)),
    ] {
        found.checks.insert(name.to_owned(), holds);
    }
    let least = bars.iter().map(FourBar::transmission).fold(f64::INFINITY, f64::min);
    found.numbers.insert("least_transmission_angle".to_owned(), least);
    if let Some([rms, largest]) = bar.rms {
        found.numbers.insert("rms_error".to_owned(), rms * size);
        found.numbers.insert("largest_error".to_owned(), largest * size);
    }
    found
}

/// Order of four-bars: without defects first, then by the error, or by transmission.
fn rank(candidate: &Candidate) -> (bool, f64) {
    let good = |k: u8| {
        candidate.checks["one_circuit"]
            && candidate.checks[&format!("one_branch_if_driven_at_{k}")]
            && candidate.checks[&format!("in_order_at_{k}")]
    };
    let error = candidate.numbers.get("rms_error").copied();
    let by = error.unwrap_or_else(|| -candidate.numbers["least_transmission_angle"]);
    (!(good(1) || good(2)), by)
}

/// Pivots A and D, lengths r, b, c, the point w, then angles of the crank.
#[derive(Clone, Copy)]
struct Shape<'a> {
    x: &'a [f64],
    sign: f64,
}

/// Numbers of a four-bar before the angles of its crank.
const N_SHAPE: usize = 9;

impl Shape<'_> {
    /// Pins B and C, and the coupler point, at an angle of the crank.
    fn pose(&self, phi: f64) -> Option<([C; 2], C)> {
        let x = self.x;
        let (a, d, w) = (C::new(x[0], x[1]), C::new(x[2], x[3]), C::new(x[7], x[8]));
        let (r, b, c) = (x[4], x[5], x[6]);
        let pin = a + C::from_polar(r, phi);
        let l = (d - pin).norm();
        let cosine = (b * b + l * l - c * c) / (2.0 * b * l);
        if cosine.is_nan() || cosine.abs() > 1.0 {
            return None;
        }
        let turn = C::from_polar(1.0, (d - pin).arg() + self.sign * cosine.acos());
        Some(([pin, pin + turn * b], pin + turn * w))
    }
}

/// Distances of a coupler point from points.
struct Near<'a> {
    points: &'a [C],
    /// Angles of the crank from the first unknown one on; empty where each is an unknown.
    angles: &'a [f64],
    sign: f64,
}

impl Near<'_> {
    fn phi(&self, x: &[f64], k: usize) -> f64 {
        if self.angles.is_empty() { x[N_SHAPE + k] } else { x[N_SHAPE] + self.angles[k] }
    }

    fn off(&self, x: &[f64], k: usize) -> Option<C> {
        let shape = Shape { x, sign: self.sign };
        Some(shape.pose(self.phi(x, k))?.1 - self.points[k])
    }
}

impl Residuals for Near<'_> {
    fn at(&self, x: &[f64]) -> Option<Vec<f64>> {
        let off = |k: usize| self.off(x, k).map(|off| [off.re, off.im]);
        let all = (0..self.points.len()).map(off).collect::<Option<Vec<_>>>()?;
        Some(all.concat())
    }

    /// Differences of second order: a point depends on the shape and on its own angle.
    fn slopes(&self, x: &[f64]) -> Option<DMatrix<f64>> {
        const STEP: f64 = 1e-6;
        let mut slopes = DMatrix::zeros(2 * self.points.len(), x.len());
        let mut moved = x.to_vec();
        for k in 0..self.points.len() {
            let own = N_SHAPE + if self.angles.is_empty() { k } else { 0 };
            for j in (0..N_SHAPE).chain([own]) {
                let mut at = |step: f64| {
                    moved[j] = x[j] + step;
                    let off = self.off(&moved, k);
                    moved[j] = x[j];
                    off
                };
                let slope = match (at(STEP), at(-STEP)) {
                    (Some(high), Some(low)) => (high - low) / (2.0 * STEP),
                    // At the end of its range from one side.
                    (Some(high), None) => (high - self.off(x, k)?) / STEP,
                    (None, Some(low)) => (self.off(x, k)? - low) / STEP,
                    (None, None) => return None,
                };
                slopes[(2 * k, j)] = slope.re;
                slopes[(2 * k + 1, j)] = slope.im;
            }
        }
        Some(slopes)
    }
}

/// Four-bars near to the points, the nearest first, each once.
fn by_least_squares(points: &[C], angles: &[f64], n_starts: usize) -> Vec<Bar> {
    /// Starts that are followed.
    const FOLLOWED: usize = 60;
    let mut random = Pcg64::seed_from_u64(7);
    let drawn: Vec<(Vec<f64>, f64)> = (0..n_starts).map(|_| drawn(points, &mut random)).collect();
    let mut starts: Vec<(f64, Vec<f64>, f64)> = drawn
        .into_par_iter()
        .filter_map(|(shape, sign)| {
            let (miss, x) = begun(points, angles, shape, sign)?;
            Some((miss, x, sign))
        })
        .collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    starts.truncate(FOLLOWED);
    let mut ends: Vec<(f64, Vec<f64>, f64)> = starts
        .par_iter()
        .filter_map(|(_, x, sign)| {
            let near = Near { points, angles, sign: *sign };
            let scale = vec![1.0; x.len()];
            let found = least(&near, x.clone(), &scale, Loss::Squares, Watch::default())?;
            let sum = found.residuals.iter().map(|r| r * r).sum::<f64>();
            Some(((sum / points.len() as f64).sqrt(), found.x, *sign))
        })
        .collect();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut bars: Vec<Bar> = Vec::new();
    for (rms, x, sign) in ends {
        let near = Near { points, angles, sign };
        let shape = Shape { x: &x, sign };
        let poses = (0..points.len()).map(|k| shape.pose(near.phi(&x, k)));
        let Some(poses) = poses.collect::<Option<Vec<_>>>() else { continue };
        let pivots = [C::new(x[0], x[1]), C::new(x[2], x[3])];
        let is_same = |bar: &Bar| {
            (0..2).all(|k| {
                (bar.pivots[k] - pivots[k]).norm() + (bar.pins[0][k] - poses[0].0[k]).norm() < 1e-4
            })
        };
        if bars.iter().any(is_same) {
            continue;
        }
        let off = poses.iter().zip(points).map(|((_, at), p)| (at - p).norm());
        bars.push(Bar {
            name: format!("path-{}", bars.len() + 1),
            pivots,
            rms: Some([rms, off.fold(0.0, f64::max)]),
            pins: poses.iter().map(|(pins, _)| *pins).collect(),
            at: poses.iter().map(|(_, at)| *at).collect(),
        });
    }
    bars
}

/// A four-bar at random, of the size of the task.
fn drawn(points: &[C], random: &mut Pcg64) -> (Vec<f64>, f64) {
    let middle = points.iter().sum::<C>() / points.len() as f64;
    let mut around = |reach: f64| random.random_range(-reach..reach);
    let pivots = [middle.re, middle.im, middle.re, middle.im].map(|x| x + around(2.0));
    let point = [around(2.0), around(2.0)];
    let lengths = [0.1..1.2, 0.3..3.0, 0.3..3.0].map(|range| random.random_range(range));
    let sign = if random.random_range(0.0..1.0) < 0.5 { -1.0 } else { 1.0 };
    ([pivots.as_slice(), &lengths, &point].concat(), sign)
}

/// The mean square of the distances at the angles that suit a four-bar best, which is moved, turned and scaled to the points.
fn begun(points: &[C], angles: &[f64], mut x: Vec<f64>, sign: f64) -> Option<(f64, Vec<f64>)> {
    const N: usize = 72;
    const N_ROUNDS: usize = 3;
    let phi = |k: usize| TAU * k as f64 / N as f64;
    let curve: Vec<Option<C>> =
        (0..N).map(|k| Some(Shape { x: &x, sign }.pose(phi(k))?.1)).collect();
    let n = points.len();
    let mut chosen: Vec<f64> = Vec::new();
    let mut similar = (C::from(1.0), C::default());
    let mut miss = f64::INFINITY;
    for _ in 0..N_ROUNDS {
        let (turn, shift) = similar;
        chosen = if angles.is_empty() {
            let nearest = |p: &C| {
                let off = |k: usize| curve[k].map(|at| ((turn * at + shift - p).norm_sqr(), k));
                (0..N).filter_map(off).min_by(|a, b| a.0.total_cmp(&b.0))
            };
            let all = points.iter().map(nearest).collect::<Option<Vec<_>>>()?;
            all.into_iter().map(|(_, k)| phi(k)).collect()
        } else {
            // The first angle that brings the others nearest.
            let sum = |k: usize| {
                let shape = Shape { x: &x, sign };
                let off = |(p, angle): (&C, &f64)| {
                    let at = shape.pose(phi(k) + angle)?.1;
                    Some((turn * at + shift - p).norm_sqr())
                };
                Some((points.iter().zip(angles).map(off).sum::<Option<f64>>()?, phi(k)))
            };
            vec![(0..N).filter_map(sum).min_by(|a, b| a.0.total_cmp(&b.0))?.1]
        };
        // The similar displacement of least squares.
        let angle = |k: usize| if angles.is_empty() { chosen[k] } else { chosen[0] + angles[k] };
        let shape = Shape { x: &x, sign };
        let at = (0..n).map(|k| Some(shape.pose(angle(k))?.1)).collect::<Option<Vec<C>>>()?;
        let (m, p) = (at.iter().sum::<C>() / n as f64, points.iter().sum::<C>() / n as f64);
        let of = at.iter().map(|a| (a - m).norm_sqr()).sum::<f64>();
        let with = at.iter().zip(points).map(|(a, b)| (a - m).conj() * (b - p)).sum::<C>();
        if of < 1e-12 || with.norm() < 1e-3 * of {
            return None;
        }
        let turn = with / of;
        similar = (turn, p - turn * m);
        let off = at.iter().zip(points).map(|(a, b)| (turn * a + similar.1 - b).norm_sqr());
        miss = off.sum::<f64>() / n as f64;
    }
    let (turn, shift) = similar;
    for k in [0, 2] {
        let pivot = turn * C::new(x[k], x[k + 1]) + shift;
        (x[k], x[k + 1]) = (pivot.re, pivot.im);
    }
    x[4..].iter_mut().for_each(|length| *length *= turn.norm());
    x.extend(chosen.iter().map(|phi| phi + turn.arg()));
    // A four-bar much larger than the path is of no use.
    let is_small = distance([x[0], x[1]], [x[2], x[3]]) < 20.0;
    is_small.then_some((miss, x))
}
