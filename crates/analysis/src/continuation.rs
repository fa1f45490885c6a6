//! Equilibria over a range of a parameter: every branch followed by arc length, with its limit points and the
//! points where branches cross.
//!
//! ```text
//! Φ(x, s) = 0,   τ tangent        limit point: τ_s = 0        branch point: det [ ∂Φ ; τᵀ ] = 0
//! ```
//!
//! Source: E. L. Allgower and K. Georg, *Introduction to Numerical Continuation Methods* (2003), chapters 8
//! and 9; H. B. Keller (1977).

use bksim_model::Model;
use nalgebra::{DMatrix, DVector};

use crate::balance::Balance;
use crate::curve::{Curve, Equations, Point};
use crate::drive::Range;
use crate::equilibrium::{Equilibrium, Stability, cells, columns};
use crate::equilibrium_path::EquilibriumPath;
use crate::error::AnalysisError;
use crate::loaded::Loaded;
use crate::rows::wrapped;
use crate::table::{Column, Table};

/// Equilibria over a range of a parameter.
#[derive(Clone, PartialEq, Debug)]
pub struct Continuation {
    /// The parameter and its unit.
    pub parameter: Column,
    /// Names of the joints, for the reactions.
    pub joints: Vec<String>,
    /// The independent quantities that the stiffness is by, with their units.
    pub by: Vec<(String, &'static str)>,
    /// Equilibria that are connected within the range, each in order along its curve.
    pub branches: Vec<EquilibriumBranch>,
    /// Stops and friction that count as constraints.
    pub held: Vec<String>,
}

/// Equilibria along one curve.
#[derive(Clone, PartialEq, Debug)]
pub struct EquilibriumBranch {
    /// In order along the curve.
    pub points: Vec<BranchPoint>,
    /// Whether the curve comes back to where it began.
    pub is_closed: bool,
}

/// One equilibrium of a branch.
#[derive(Clone, PartialEq, Debug)]
pub struct BranchPoint {
    /// The reason why it is told.
    pub kind: PointKind,
    /// Name of a limit point or branch point: `L1`, `B2`; a branch point has it on every branch through it.
    pub name: Option<String>,
    /// Value of the parameter, SI.
    pub value: f64,
    /// The equilibrium.
    pub equilibrium: Equilibrium,
}

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
const MOST_BRANCHES: usize = 64;
/// A curve that has gone this far, in lengths of the longest link, does not come back.
const FAR: f64 = 50.0;
/// Positions nearer than this are one.
const SAME: f64 = 1e-6;

/// Follows the equilibria of `model` over a `range` of the parameter `name`; the stiffness is by the measures
/// `by`, else by coordinates.
///
/// # Errors
/// [`AnalysisError`] when no parameter has this name, or no equilibrium is found at any value.
pub fn statics_over(
    model: Model,
    (name, range): (&str, Range),
    by: &[String],
) -> Result<Continuation, AnalysisError> {
    let mut loaded = Loaded::of(model)?;
    let id = loaded.parameter(name)?;
    let last = (range.n - 1).max(1) as f64;
    let targets: Vec<f64> = (0..range.n).map(|k| k as f64 / last).collect();

    // Equilibria to begin with, at some of the values.
    let own = loaded.mechanism.parameters.clone();
    let mut seeds: Vec<(f64, Vec<f64>)> = Vec::new();
    let mut fault = None;
    for s in seed_values(&targets, loaded.model().joints.len()) {
        let values = loaded.parameters_with(&[id], &[range.at(s)]);
        let found = loaded
            .restart(&values[..own.len()])
            .and_then(|()| Balance::of(&loaded, &[], &[])?.all());
        match found {
            Ok((poses, _)) => seeds.extend(poses.into_iter().map(|q| (s, q))),
            Err(error) => fault = Some(error),
        }
    }
    loaded.restart(&own)?;
    if seeds.is_empty() {
        return Err(fault.unwrap_or(AnalysisError::NoEquilibrium));
    }

    // Branches through them, and branches that cross those.
    let mut balance = Balance::of(&loaded, by, &[id])?;
    let mut found = Vec::new();
    let mut crossings: Vec<DVector<f64>> = Vec::new();
    let mut next = 0;
    while next < seeds.len() && found.len() < MOST_BRANCHES {
        let (s, q) = seeds[next].clone();
        next += 1;
        let mut curve = EquilibriumPath::about(&mut balance, range, (&q, s));
        let mut z = curve.equations.unknowns(&q, s);
        let parameter = DVector::from_fn(z.len(), |i, _| f64::from(u8::from(i + 1 == z.len())));
        if targets.contains(&s) {
            // Where the parameter cannot be held the seed is a limit point itself.
            let kept = z.clone();
            if curve.correct(&mut z, &parameter).is_none() {
                z = kept;
            }
        }
        if found.iter().any(|traced: &Traced| traced.holds(&mut curve, &z)) {
            continue;
        }
        let Some(mut traced) = Traced::through(&mut curve, z, &targets) else { continue };
        for event in traced.events.iter_mut().filter(|event| event.kind == PointKind::Crossing) {
            let is_turn = &curve.equations.is_turn;
            let known = crossings.iter().position(|z| apart(is_turn, z, &event.z) < 1e-3);
            event.crossing = Some(known.unwrap_or(crossings.len()));
            if known.is_some() {
                continue;
            }
            crossings.push(event.z.clone());
            for z in beside(&mut curve, &event.z) {
                seeds.push((z[z.len() - 1], curve.equations.position(&z)));
            }
        }
        found.push(traced);
    }
    let branches = told(&mut balance, range, &found)?;
    let first = branches.iter().flat_map(|branch: &EquilibriumBranch| &branch.points).next();
    let Some(first) = first.map(|point| (point.value, point.equilibrium.q.clone())) else {
        return Err(AnalysisError::NoEquilibrium);
    };
    balance.set(&[first.0]);
    let unit = loaded.model().parameters[id.0].unit.clone();
    Ok(Continuation {
        parameter: Column::new(name, unit),
        joints: loaded.mechanism.compiled.joints.clone(),
        by: balance.by_names(&first.1)?,
        branches,
        held: loaded.held_contacts(),
    })
}

/// The values at which equilibria are searched: of a large mechanism fewer.
fn seed_values(targets: &[f64], n_joints: usize) -> Vec<f64> {
    let most = if n_joints > 8 { 3 } else { 7 };
    let n = targets.len().min(most);
    let place = |k: usize| k * (targets.len() - 1) / (n - 1).max(1);
    (0..n).map(|k| targets[place(k)]).collect()
}

impl Continuation {
    /// A row for each point: branch, kind (0 value, 1 limit point, 2 branch point, 3 end), parameter, then as of
    /// a table of equilibria.
    pub fn table(&self) -> Table {
        let all = || self.branches.iter().flat_map(|branch| &branch.points);
        let heads = [Column::new("branch", ""), Column::new("kind", ""), self.parameter.clone()];
        let rest = columns(all().next().map(|point| &point.equilibrium), &self.joints);
        let rows = self.branches.iter().enumerate().flat_map(|(k, branch)| {
            branch.points.iter().map(move |point| {
                let kind = match point.kind {
                    PointKind::Value => 0.0,
                    PointKind::Limit => 1.0,
                    PointKind::Crossing => 2.0,
                    PointKind::End => 3.0,
                };
                [(k + 1) as f64, kind, point.value]
                    .into_iter()
                    .chain(cells(&point.equilibrium))
                    .collect()
            })
        });
        Table { rows: rows.collect(), columns: heads.into_iter().chain(rest).collect() }
    }
}

/// A point of a branch that is told.
#[derive(Clone, Debug)]
struct Event {
    kind: PointKind,
    z: DVector<f64>,
    /// The coordinates, SI.
    q: Vec<f64>,
    /// Of a branch point its number.
    crossing: Option<usize>,
}

impl Event {
    fn at(curve: &Path<'_, '_>, kind: PointKind, z: &DVector<f64>) -> Self {
        Self { kind, z: z.clone(), q: curve.equations.position(z), crossing: None }
    }
}

/// A curve of equilibria within the range.
struct Traced {
    points: Vec<Point>,
    events: Vec<Event>,
    is_closed: bool,
}

type Path<'b, 'l> = Curve<EquilibriumPath<'b, 'l>>;

impl Traced {
    /// Follows the curve through `z` both ways, to the ends of the range.
    fn through(curve: &mut Path<'_, '_>, z: DVector<f64>, targets: &[f64]) -> Option<Self> {
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

    /// Whether an equilibrium lies on the curve.
    fn holds(&self, curve: &mut Path<'_, '_>, z: &DVector<f64>) -> bool {
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

fn apart(is_turn: &[bool], a: &DVector<f64>, b: &DVector<f64>) -> f64 {
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
    if (from.tangent[n] > 0.0) != (to.tangent[n] > 0.0) {
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
fn beside(curve: &mut Path<'_, '_>, at: &DVector<f64>) -> Vec<DVector<f64>> {
    const ASIDE: f64 = 0.02;
    let n = at.len();
    let (_, jacobian) = curve.equations.at(at);
    let mut square = DMatrix::zeros(n, n);
    square.rows_mut(0, n - 1).copy_from(&jacobian);
    let svd = square.svd(false, true);
    let Some(v_t) = svd.v_t else { return Vec::new() };
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| svd.singular_values[a].total_cmp(&svd.singular_values[b]));
    // All directions of the plane that the slopes leave free: one of them is across each branch.
    let (a, b) = (v_t.row(order[0]).transpose(), v_t.row(order[1]).transpose());
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

/// Branches with their equilibria; limit points and branch points get their names.
fn told(
    balance: &mut Balance<'_>,
    range: Range,
    found: &[Traced],
) -> Result<Vec<EquilibriumBranch>, AnalysisError> {
    let mut n_limits = 0;
    let mut branches = Vec::new();
    for traced in found {
        let mut points = Vec::new();
        for event in &traced.events {
            let value = range.at(event.z[event.z.len() - 1]);
            balance.set(&[value]);
            let mut equilibrium = balance.equilibrium(&event.q)?;
            let name = match event.kind {
                PointKind::Limit => {
                    n_limits += 1;
                    Some(format!("L{n_limits}"))
                }
                PointKind::Crossing => event.crossing.map(|k| format!("B{}", k + 1)),
                PointKind::Value | PointKind::End => None,
            };
            if name.is_some() {
                equilibrium.stability = Stability::Neutral;
            }
            points.push(BranchPoint { kind: event.kind, name, value, equilibrium });
        }
        if !points.is_empty() {
            branches.push(EquilibriumBranch { points, is_closed: traced.is_closed });
        }
    }
    Ok(branches)
}
