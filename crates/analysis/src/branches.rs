//! [`Traced`]: a curve of equilibria over a parameter, with its limit points and branch points.

use bksim_sim::Svd;
use nalgebra::{DMatrix, DVector};

use crate::curve::{Curve, Equations, Point};
use crate::equilibrium_path::EquilibriumPath;
use crate::rows::wrapped;

/// The reason why a point of a branch is told.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum PointKind {
    /// A value of the range.
    Value,
    /// A limit point, or fold: the parameter turns back, and stability changes.
    Limit,
    /// A branch point: another branch crosses.
    Crossing,
    /// An end within the range, beyond which the curve could not be followed.
    End,
}

/// Steps of a branch, in radians, lengths of the longest link and shares of the range.
const STEP: f64 = 0.04;
const MOST_STEPS: usize = 20_000;
/// A curve that has gone this far, in lengths of the longest link, does not come back.
const FAR: f64 = 50.0;
/// A part of a direction below which the parameter does not change.
const NO_CHANGE: f64 = 1e-8;
/// Positions nearer than this are one.
const SAME: f64 = 1e-6;

/// A point of a branch that is told.
#[derive(Clone, Debug)]
pub(crate) struct Event {
    pub(crate) kind: PointKind,
    pub(crate) z: DVector<f64>,
    /// The coordinates, SI.
    pub(crate) q: Vec<f64>,
    /// Of a branch point its number.
    pub(crate) crossing: Option<usize>,
}

impl Event {
    fn at(curve: &Path<'_, '_>, kind: PointKind, z: &DVector<f64>) -> Self {
        Self { kind, z: z.clone(), q: curve.equations.position(z), crossing: None }
    }
}

/// A curve of equilibria within the range.
pub(crate) struct Traced {
    points: Vec<Point>,
    pub(crate) events: Vec<Event>,
    pub(crate) is_closed: bool,
}

/// Equilibria as a curve.
pub(crate) type Path<'b, 'l> = Curve<EquilibriumPath<'b, 'l>>;

impl Traced {
    /// Follows the curve through `z` both ways, to the ends of the range.
    pub(crate) fn through(
        curve: &mut Path<'_, '_>,
        z: DVector<f64>,
        targets: &[f64],
    ) -> Option<Self> {
        let first = curve.first_point(z)?;
        let n = first.z.len() - 1;
        let own = targets.iter().any(|s| *s == first.z[n]);
        let (points, events, is_closed) = one_way(curve, &first, targets);
        let mut traced = Self { points, events, is_closed };
        if own {
            traced.events.insert(0, Event::at(curve, PointKind::Value, &first.z));
        }
        if !is_closed {
            let back = Point { tangent: -&first.tangent, z: first.z.clone() };
            let (others, events, _) = one_way(curve, &back, targets);
            let turned = others.into_iter().skip(1).rev();
            let turned = turned.map(|p| Point { tangent: -&p.tangent, z: p.z });
            traced.points = turned.chain(traced.points).collect();
            traced.events = events.into_iter().rev().chain(traced.events).collect();
        }
        Some(traced)
    }

    /// True where an equilibrium lies on the curve.
    pub(crate) fn holds(&self, curve: &mut Path<'_, '_>, z: &DVector<f64>) -> bool {
        let is_turn = curve.equations.is_turn.clone();
        self.points.iter().any(|from| {
            let off = difference(&is_turn, z, &from.z);
            if off.norm() > 3.0 * STEP {
                return false;
            }
            let along = off.dot(&from.tangent);
            let mut there = &from.z + &from.tangent * along;
            let reached = curve.correct(&mut there, &from.tangent).is_some();
            reached && apart(&is_turn, &there, z) < SAME
        })
    }
}

/// By how much unknowns differ, angles modulo whole turns.
fn difference(is_turn: &[bool], a: &DVector<f64>, b: &DVector<f64>) -> DVector<f64> {
    DVector::from_fn(a.len(), |i, _| {
        let off = a[i] - b[i];
        if is_turn.get(i) == Some(&true) { wrapped(off) } else { off }
    })
}

/// The largest part of that.
pub(crate) fn apart(is_turn: &[bool], a: &DVector<f64>, b: &DVector<f64>) -> f64 {
    difference(is_turn, a, b).amax()
}

/// The determinant of the slopes with the tangent below.
fn crossing(curve: &mut Path<'_, '_>, point: &Point) -> f64 {
    let (_, jacobian) = curve.equations.at(&point.z);
    let n = point.z.len();
    let mut square = DMatrix::zeros(n, n);
    square.rows_mut(0, n - 1).copy_from(&jacobian);
    square.row_mut(n - 1).copy_from(&point.tangent.transpose());
    square.determinant()
}

/// Points in order from `first` on, what is told of them, and whether the curve closes.
fn one_way(
    curve: &mut Path<'_, '_>,
    first: &Point,
    targets: &[f64],
) -> (Vec<Point>, Vec<Event>, bool) {
    let n = first.z.len() - 1;
    let (mut points, mut events) = (vec![first.clone()], Vec::new());
    let is_turn = curve.equations.is_turn.clone();
    let (mut ds, mut gone): (f64, f64) = (0.01, 0.0);
    let mut before = crossing(curve, first);
    // At an end of the range the curve may lead out of it at once.
    let leaves = |from: &Point| {
        (from.z[n] <= 0.0 && from.tangent[n] < 0.0) || (from.z[n] >= 1.0 && from.tangent[n] > 0.0)
    };
    for _ in 0..MOST_STEPS {
        let Some(from) = points.last().cloned() else { break };
        if leaves(&from) {
            break;
        }
        ds = ds.min(STEP);
        let Some((to, length)) = curve.step(&from, &mut ds) else {
            events.push(Event::at(curve, PointKind::End, &from.z));
            break;
        };
        // The first point again.
        let home = difference(&is_turn, &first.z, &from.z);
        let ahead = home.dot(&from.tangent);
        let is_closed = gone > 3.0 * length
            && home.norm() < 1.5 * length
            && ahead > 0.0
            && ahead <= length
            && from.tangent.dot(&first.tangent) > 0.9
            && {
                let mut z = &from.z + &from.tangent * ahead;
                curve.correct(&mut z, &from.tangent).is_some()
                    && apart(&is_turn, &z, &first.z) < SAME
            };
        let whole = if is_closed { ahead } else { length };
        let after = crossing(curve, &to);
        let mut inside = within(curve, (&from, &to), length, (before, after), targets);
        before = after;

        // What lies within the step, up to an end of the range.
        inside.retain(|(at, _)| *at <= whole + SAME);
        let border = |event: &Event| {
            (event.z[n] <= 0.0 && from.z[n] > 0.0) || (event.z[n] >= 1.0 && from.z[n] < 1.0)
        };
        let end =
            inside.iter().position(|(_, event)| event.kind == PointKind::Value && border(event));
        inside.truncate(end.map_or(inside.len(), |end| end + 1));
        events.extend(inside.into_iter().map(|(_, event)| event));
        gone += length;
        if is_closed {
            return (points, events, true);
        }
        let is_far = (0..n).any(|i| !is_turn[i] && (to.z[i] - first.z[i]).abs() > FAR);
        points.push(to);
        if end.is_some() || is_far {
            break;
        }
    }
    (points, events, false)
}

/// Values of the range, limit points and branch points within a step, with their places along it.
fn within(
    curve: &mut Path<'_, '_>,
    (from, to): (&Point, &Point),
    length: f64,
    (before, after): (f64, f64),
    targets: &[f64],
) -> Vec<(f64, Event)> {
    let n = from.z.len() - 1;
    let mut found = Vec::new();
    let place = |point: &Point| from.tangent.dot(&(&point.z - &from.z));
    // A limit point, which parts the step: the parameter passes a value on either side.
    let mut ends = vec![(0.0, from.clone())];
    // Where all poses of a curve are in balance at one value, rounding turns it back and forth.
    let moves = from.tangent[n].abs().max(to.tangent[n].abs()) > NO_CHANGE;
    if moves && (from.tangent[n] > 0.0) != (to.tangent[n] > 0.0) {
        let signs = (from.tangent[n], to.tangent[n]);
        if let Some(point) = curve.root(from, length, signs, &mut |_, p| p.tangent[n]) {
            found.push((place(&point), Event::at(curve, PointKind::Limit, &point.z)));
            ends.push((place(&point), point));
        }
    }
    ends.push((length, to.clone()));
    for pair in ends.windows(2) {
        let ((start, a), (end, b)) = (&pair[0], &pair[1]);
        for &target in targets {
            let (low, high) = (a.z[n] - target, b.z[n] - target);
            if low == 0.0 || (low > 0.0) == (high > 0.0) && high != 0.0 {
                continue;
            }
            let root = curve.root(a, end - start, (low, high), &mut |_, p| p.z[n] - target);
            if let Some(mut point) = root {
                // The value itself, where it can be held.
                let mut z = point.z.clone();
                z[n] = target;
                let parameter = DVector::from_fn(n + 1, |i, _| f64::from(u8::from(i == n)));
                if curve.correct(&mut z, &parameter).is_some_and(|first| first < SAME) {
                    point.z = z;
                }
                found.push((place(&point), Event::at(curve, PointKind::Value, &point.z)));
            }
        }
    }
    if (before > 0.0) != (after > 0.0) {
        let point = curve.root(from, length, (before, after), &mut crossing_of);
        let point = point.unwrap_or_else(|| between(from, to, before / (before - after)));
        let point = refined(curve, &point);
        // A branch that turns back where it crosses another has no limit point of its own.
        found.retain(|(_, event)| {
            event.kind != PointKind::Limit || (&event.z - &point.z).norm() > 1e-2
        });
        found.push((place(&point), Event::at(curve, PointKind::Crossing, &point.z)));
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}

fn crossing_of(curve: &mut Path<'_, '_>, point: &Point) -> f64 {
    crossing(curve, point)
}

fn between(from: &Point, to: &Point, share: f64) -> Point {
    let z = &from.z * (1.0 - share) + &to.z * share;
    let tangent = (&from.tangent * (1.0 - share) + &to.tangent * share).normalize();
    Point { z, tangent }
}

/// A branch point from the points of the curve on either side of it, where the equations are regular.
fn refined(curve: &mut Path<'_, '_>, near: &Point) -> Point {
    let mut best = near.clone();
    for aside in [2e-3, 3.1e-3, 5.3e-3, 9.1e-3] {
        // Once more about the better place.
        let found = around(curve, &best, aside);
        let Some(again) = found.and_then(|point| around(curve, &point, aside)) else { continue };
        best = again;
        break;
    }
    best
}

/// The zero of the cubic through four points of a curve, two and two to either side of a place.
fn around(curve: &mut Path<'_, '_>, near: &Point, aside: f64) -> Option<Point> {
    let mut around: Vec<(f64, Point, f64)> = Vec::new();
    for k in [-2.0, -1.0, 1.0, 2.0] {
        let at: f64 = k * aside;
        let mut z = &near.z + &near.tangent * at;
        curve.correct(&mut z, &near.tangent)?;
        let point = curve.point(z, &near.tangent)?;
        let f = crossing(curve, &point);
        around.push((at, point, f));
    }
    // Lagrange's polynomials through the four.
    let weights = |at: f64| -> Vec<f64> {
        let own = |i: usize| {
            let others = (0..4).filter(|&j| j != i);
            others.map(|j| (at - around[j].0) / (around[i].0 - around[j].0)).product()
        };
        (0..4).map(own).collect()
    };
    let value = |at: f64| weights(at).iter().zip(&around).map(|(w, (.., f))| w * f).sum::<f64>();
    let (mut low, mut high) = (-2.0 * aside, 2.0 * aside);
    let rises = value(high) > 0.0;
    if (value(low) > 0.0) == rises {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (value(middle) > 0.0) == rises { high = middle } else { low = middle }
    }
    let weights = weights(0.5 * (low + high));
    let sum = |of: fn(&Point) -> &DVector<f64>| {
        let parts = weights.iter().zip(&around).map(|(w, (_, p, _))| of(p) * *w);
        parts.fold(DVector::zeros(near.z.len()), |sum, part| sum + part)
    };
    Some(Point { z: sum(|p| &p.z), tangent: sum(|p| &p.tangent).normalize() })
}

/// Equilibria of the other branch through a branch point, a little aside of it.
pub(crate) fn beside(curve: &mut Path<'_, '_>, at: &DVector<f64>) -> Vec<DVector<f64>> {
    const ASIDE: f64 = 0.02;
    let n = at.len();
    let (_, jacobian) = curve.equations.at(at);
    let mut square = DMatrix::zeros(n, n);
    square.rows_mut(0, n - 1).copy_from(&jacobian);
    let Some(Svd { v_t, .. }) = Svd::new(&square).filter(|_| n > 1) else { return Vec::new() };
    // All directions of the plane that the slopes leave free: one of them is across each branch.
    let (a, b) = (v_t.row(n - 1).transpose(), v_t.row(n - 2).transpose());
    let mut found = Vec::new();
    for k in 0..8 {
        let angle = f64::from(k) * std::f64::consts::FRAC_PI_4;
        let direction = &a * angle.cos() + &b * angle.sin();
        let mut z = at + &direction * ASIDE;
        if curve.correct(&mut z, &direction).is_some() && (&z - at).norm() < 4.0 * ASIDE {
            found.push(z);
        }
    }
    found
}
