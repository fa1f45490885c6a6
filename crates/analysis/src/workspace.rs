//! The workspace of a point: where it can be brought in the plane, for mechanisms with two free motions or more.
//!
//! Its boundary is made of poses in which the point cannot move in one direction w of the plane, and of such poses with
//! stops at their limits:
//!
//! ```text
//! Φ(x) = 0
//! (∂Φ/∂x)ᵀ λ + (∂p/∂x)ᵀ w = 0
//! λᵀλ + wᵀw = 1
//! ```
//!
//! one equation less than there are unknowns x, λ, w. Each curve of solutions is cut where it crosses others; a
//! piece is boundary where the point can be brought to one side of it alone.
//!
//! Source: E. J. Haug, C. M. Luh, F. A. Adkins and J. Y. Wang, *Numerical algorithms for mapping boundaries of
//! manipulator workspaces*, Journal of Mechanical Design 118 (1996).

use bksim_model::{LoadKind, Measure, Model, Space};
use nalgebra::{DMatrix, DVector};

use crate::assemblies::{closed, closed_poses};
use crate::curve::{Curve, Equations, Point, independent_rows};
use crate::curves::point;
use crate::double_points::cross;
use crate::error::AnalysisError;
use crate::path::{Law, Path};
use crate::positions::Positions;
use crate::quantity::PoseQuantity;
use crate::rows::{Clock, Rows, wrapped};
use crate::scalar::Scalars;
use crate::trace::{Trace, closed_way};

/// The region of the plane that a point reaches.
#[derive(Clone, PartialEq, Debug)]
pub struct Workspace {
    /// The point.
    pub name: String,
    /// Pieces of its boundary, the region on their left, m.
    pub boundary: Vec<Vec<[f64; 2]>>,
    /// Curves inside on which the point cannot go straight on in one of the assemblies, m.
    pub barriers: Vec<Vec<[f64; 2]>>,
    /// Area, m²; of a region that is bounded.
    pub area: f64,
}

/// Distance from a boundary at which it is decided which side can be reached, longest links.
const ASIDE: f64 = 2e-3;
/// Poses from which that is tried.
const MOST_SEEDS: usize = 60;
/// Limits are kept to this, rad or longest links.
const AT_LIMIT: f64 = 1e-9;

/// Finds where `model`, whose drives are released, brings the points of these names.
///
/// # Errors
/// [`AnalysisError`] when the start does not close, fewer than two motions are free, or a name is not known.
pub fn workspaces(model: Model, names: &[String]) -> Result<Vec<Workspace>, AnalysisError> {
    let positions = Positions::of(model)?;
    if positions.model().space != Space::Planar {
        return Err(AnalysisError::NotPlanar { what: "workspaces" });
    }
    let released: Vec<usize> = (0..positions.model().drives.len()).collect();
    let limits = Limit::all(&positions)?;
    let mut rows = positions.rows(&[], &released, Clock::Held)?;
    let start = rows.scaled(&positions.q);
    let at = rows.at(positions.t(), &start, &[]).jacobian;
    let n_free = start.len() - independent_rows(&at).len();
    if n_free < 2 {
        return Err(AnalysisError::OneMotion { n_free });
    }
    let mut seeds = closed_poses(&positions, &mut rows);
    seeds.push(start);
    let mut found = Vec::new();
    for name in names {
        let mut reach = Reach::of(&positions, name, limits.clone())?;
        let mut critical = Vec::new();
        for held in reach.held_sets(n_free) {
            critical.extend(reach.critical(&positions, (&held, &released), n_free, &seeds)?);
        }
        found.push(reach.workspace(&mut rows, name, &critical, &seeds));
    }
    Ok(found)
}

/// An end of the travel of a joint.
#[derive(Clone, Copy, Debug)]
struct Limit {
    measure: Measure,
    value: f64,
    /// Positive for a largest value.
    sign: f64,
    /// Of an angle the one in the middle of what is allowed: whole turns away from it mean nothing.
    middle: Option<f64>,
    unit: f64,
}

impl Limit {
    fn all(positions: &Positions) -> Result<Vec<Self>, AnalysisError> {
        let mut all = Vec::new();
        for load in &positions.model().loads {
            let LoadKind::Stop { joint, motion_idx, min, max, .. } = load.kind else { continue };
            let measure = Measure::JointPosition(joint, motion_idx);
            let is_turn = measure.unit(positions.model()) == "rad";
            let unit = if is_turn { 1.0 } else { positions.size };
            let ends =
                [min, max].map(|end| Some(positions.constant(end?)).filter(|x| x.is_finite()));
            let middle = match ends {
                [Some(min), Some(max)] => 0.5 * (min + max),
                _ => positions.value(measure)?,
            };
            let middle = is_turn.then_some(middle);
            for (value, sign) in ends.into_iter().zip([-1.0, 1.0]) {
                all.extend(value.map(|value| Self { measure, value, sign, middle, unit }));
            }
        }
        Ok(all)
    }
}

/// A point with the limits of the joints, as functions of the position.
struct Reach {
    /// x and y of the point, then the joints with limits.
    scalars: Scalars,
    limits: Vec<Limit>,
    t: f64,
    size: f64,
}

/// The point along a critical curve, with its pose in units of the mechanism.
#[derive(Clone, Debug)]
struct Stop {
    p: [f64; 2],
    x: Vec<f64>,
}

impl Reach {
    fn of(positions: &Positions, name: &str, limits: Vec<Limit>) -> Result<Self, AnalysisError> {
        let [x, y, _] = point(positions, name)?;
        let quantity =
            |value| PoseQuantity { names: [const { String::new() }; 3], unit: "", value };
        let kinematics = &positions.system().kinematics;
        let measures = limits.iter().map(|l| kinematics.measure(positions.model(), l.measure));
        let all: Vec<PoseQuantity> = [x, y].into_iter().chain(measures).map(quantity).collect();
        let (t, size) = (positions.t(), positions.size);
        Ok(Self { scalars: positions.scalars(&all)?, limits, t, size })
    }

    /// Sets of limits that leave at least one motion, none of a joint twice.
    fn held_sets(&self, n_free: usize) -> Vec<Vec<usize>> {
        let mut sets: Vec<Vec<usize>> = vec![Vec::new()];
        for limit in 0..self.limits.len() {
            let is_other = |&k: &usize| self.limits[k].measure != self.limits[limit].measure;
            let more: Vec<Vec<usize>> = sets
                .iter()
                .filter(|set| set.len() + 1 < n_free && set.iter().all(is_other))
                .map(|set| [set.as_slice(), &[limit]].concat())
                .collect();
            sets.extend(more);
        }
        sets
    }

    /// Place of the point, and by how much each limit is passed, positive beyond it.
    fn at(&mut self, q: &[f64]) -> ([f64; 2], Vec<f64>) {
        let values = self.scalars.values(self.t, q);
        let passed = self.limits.iter().zip(&values[2..]);
        let passed = passed.map(|(l, &value)| {
            let value = l.middle.map_or(value, |middle| middle + wrapped(value - middle));
            l.sign * (value - l.value) / l.unit
        });
        let passed = passed.collect();
        ([values[0], values[1]], passed)
    }

    /// The curves on which the point is critical with these limits held, cut where other limits are passed.
    fn critical(
        &mut self,
        positions: &Positions,
        (held, released): (&[usize], &[usize]),
        n_free: usize,
        seeds: &[Vec<f64>],
    ) -> Result<Vec<Vec<Stop>>, AnalysisError> {
        let measures: Vec<Measure> = held.iter().map(|&k| self.limits[k].measure).collect();
        let u: Vec<f64> = held.iter().map(|&k| self.limits[k].value).collect();
        let mut rows = positions.rows(&measures, released, Clock::Held)?;
        let seeds: Vec<Vec<f64>> =
            seeds.iter().filter_map(|x| closed(&mut rows, self.t, x.clone(), &u)).collect();
        if n_free - held.len() == 1 {
            let law = Law { t: self.t, u_slope: vec![0.0; u.len()], u, ..Law::default() };
            let Some(first) = seeds.first() else { return Ok(Vec::new()) };
            let Ok(mut curve) = Path::through(&mut rows, (law, false), first) else {
                return Ok(Vec::new());
            };
            let traces = Trace::all(&mut curve, first, &seeds);
            let traces = traces.into_iter().map(|trace| trace.points);
            return Ok(traces.flat_map(|way| self.within(&mut curve, &way, held)).collect());
        }
        let n = rows.n();
        let active = seeds.first().map(|x| independent_rows(&rows.at(self.t, x, &u).jacobian));
        let active = active.unwrap_or_default();
        let is_turn = rows.is_turn.clone();
        let n_all = n + active.len() + 2;
        let turns: Vec<bool> = (0..n_all).map(|i| i < n && is_turn[i]).collect();
        let point = self.scalars.clone();
        let equations = Critical { rows: &mut rows, point, active, u, t: self.t, size: self.size };
        let mut curve = Curve { equations };
        let mut ways: Vec<Vec<Point>> = Vec::new();
        for x in &seeds {
            let Some(z) = curve.equations.stationary(x) else { continue };
            if ways.iter().any(|way| holds(way, &z, (&turns, n))) {
                continue;
            }
            if let Some(first) = curve.first_point(z) {
                ways.push(closed_way(&mut curve, &first, &turns));
            }
        }
        Ok(ways.iter().flat_map(|way| self.within(&mut curve, way, held)).collect())
    }

    /// The parts of a curve on which no limit is passed.
    fn within<E: Equations + InMechanism>(
        &mut self,
        curve: &mut Curve<E>,
        way: &[Point],
        held: &[usize],
    ) -> Vec<Vec<Stop>> {
        let beyond = |reach: &mut Self, curve: &Curve<E>, point: &Point| {
            let (p, passed) = reach.at(&curve.equations.q(point));
            let free = (0..passed.len()).filter(|k| !held.contains(k));
            let worst = free.max_by(|&a, &b| passed[a].total_cmp(&passed[b]));
            (p, worst.map_or((0, -1.0), |k| (k, passed[k])))
        };
        let mut parts: Vec<Vec<Stop>> = vec![Vec::new()];
        let mut last: Option<(&Point, f64)> = None;
        for point in way {
            let (p, (k, passed)) = beyond(self, curve, point);
            // Where a limit is met between two points.
            if let Some((from, before)) = last
                && (before > AT_LIMIT) != (passed > AT_LIMIT)
            {
                let limit = if passed > AT_LIMIT { k } else { beyond(self, curve, from).1.0 };
                let value = |reach: &mut Self, curve: &Curve<E>, point: &Point| {
                    reach.at(&curve.equations.q(point)).1[limit]
                };
                let signs = (value(self, curve, from), value(self, curve, point));
                let whole = from.tangent.dot(&(&point.z - &from.z));
                let met = curve.root(from, whole, signs, &mut |curve, at| value(self, curve, at));
                if let Some(met) = met {
                    if before > AT_LIMIT {
                        parts.push(Vec::new());
                    }
                    let (p, _) = beyond(self, curve, &met);
                    let x = curve.equations.x(&met);
                    parts
                        .last_mut()
                        .into_iter()
                        .for_each(|part| part.push(Stop { p, x: x.clone() }));
                }
            }
            if passed <= AT_LIMIT {
                let x = curve.equations.x(point);
                parts.last_mut().into_iter().for_each(|part| part.push(Stop { p, x: x.clone() }));
            } else if last.is_some_and(|(_, before)| before <= AT_LIMIT) {
                parts.push(Vec::new());
            }
            last = Some((point, passed));
        }
        parts.retain(|part| part.len() > 1);
        parts
    }

    /// The pieces of critical curves that bound what is reached, and those inside of it.
    fn workspace(
        &mut self,
        rows: &mut Rows,
        name: &str,
        critical: &[Vec<Stop>],
        seeds: &[Vec<f64>],
    ) -> Workspace {
        let mut pool: Vec<Stop> = Vec::new();
        let all = critical.iter().flat_map(|way| way.iter().step_by(5).map(|stop| &stop.x));
        for x in seeds.iter().chain(all) {
            let (p, _) = self.at(&rows.unscaled(x));
            pool.push(Stop { p, x: x.clone() });
        }
        let mut found = Workspace {
            name: name.to_owned(),
            boundary: Vec::new(),
            barriers: Vec::new(),
            area: 0.0,
        };
        for mut piece in pieces(critical, self.size) {
            let middle = piece.len() / 2;
            let [a, b] = [piece[middle - 1], piece[middle]];
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let long = dx.hypot(dy);
            if long == 0.0 {
                continue;
            }
            let side = |sign: f64| {
                let aside = sign * ASIDE * self.size / long;
                [0.5 * (a[0] + b[0]) - aside * dy, 0.5 * (a[1] + b[1]) + aside * dx]
            };
            let [left, right] = [side(1.0), side(-1.0)].map(|p| self.reaches(rows, p, &pool));
            match (left, right) {
                (true, true) => found.barriers.push(piece),
                (true, false) => found.boundary.push(piece),
                (false, true) => {
                    piece.reverse();
                    found.boundary.push(piece);
                }
                (false, false) => (),
            }
        }
        found.boundary = without_twins(found.boundary, self.size);
        let area = |piece: &Vec<[f64; 2]>| {
            piece
                .windows(2)
                .map(|pair| 0.5 * (pair[0][0] * pair[1][1] - pair[0][1] * pair[1][0]))
                .sum::<f64>()
        };
        found.area = found.boundary.iter().map(area).sum();
        found
    }

    /// Whether the point can be brought to a place without passing a limit.
    fn reaches(&mut self, rows: &mut Rows, target: [f64; 2], pool: &[Stop]) -> bool {
        let off = |p: [f64; 2]| (p[0] - target[0]).hypot(p[1] - target[1]);
        let mut near: Vec<&Stop> = pool.iter().collect();
        near.sort_by(|a, b| off(a.p).total_cmp(&off(b.p)));
        // The nearest ones, and some from everywhere.
        let stride = (pool.len() / (MOST_SEEDS / 2)).max(1);
        let (first, rest) = near.split_at(near.len().min(MOST_SEEDS / 2));
        let seeds = first.iter().chain(rest.iter().step_by(stride));
        seeds.copied().any(|seed| self.brought(rows, seed.x.clone(), target))
    }

    /// Whether Newton's iteration from a pose brings the point to a place within the limits.
    fn brought(&mut self, rows: &mut Rows, mut x: Vec<f64>, target: [f64; 2]) -> bool {
        const MOST: usize = 25;
        let n = x.len();
        for _ in 0..MOST {
            let at = rows.at(self.t, &x, &[]);
            let q = rows.unscaled(&x);
            let (p, passed) = self.at(&q);
            let m = at.value.len();
            let off = [0, 1].map(|i| (p[i] - target[i]) / self.size);
            let value =
                DVector::from_fn(m + 2, |i, _| if i < m { at.value[i] } else { off[i - m] });
            if value.amax() < 1e-10 {
                return passed.iter().all(|passed| *passed <= AT_LIMIT);
            }
            let slopes = self.scalars.gradients(self.t, &q);
            let jacobian = DMatrix::from_fn(m + 2, n, |i, k| {
                if i < m {
                    at.jacobian[(i, k)]
                } else {
                    slopes[i - m][k] * rows.unit_of_column[k] / self.size
                }
            });
            let Ok(step) = jacobian.svd(true, true).solve(&value, 1e-9) else { return false };
            let size = step.norm();
            if !size.is_finite() {
                return false;
            }
            let share = if size > 0.5 { 0.5 / size } else { 1.0 };
            x.iter_mut().zip(step.iter()).for_each(|(x, step)| *x -= share * step);
        }
        false
    }
}

/// Equations some of whose unknowns are the coordinates.
trait InMechanism {
    /// Coordinates in units of the mechanism.
    fn x(&self, point: &Point) -> Vec<f64>;
    /// Coordinates.
    fn q(&self, point: &Point) -> Vec<f64>;
}

impl InMechanism for Path<'_> {
    fn x(&self, point: &Point) -> Vec<f64> {
        point.z.as_slice()[..self.rows.n()].to_vec()
    }

    fn q(&self, point: &Point) -> Vec<f64> {
        self.rows.unscaled(&point.z.as_slice()[..self.rows.n()])
    }
}

/// The equations of critical poses: x, λ, w.
struct Critical<'r> {
    rows: &'r mut Rows,
    /// x and y of the point first.
    point: Scalars,
    active: Vec<usize>,
    u: Vec<f64>,
    t: f64,
    size: f64,
}

impl InMechanism for Critical<'_> {
    fn x(&self, point: &Point) -> Vec<f64> {
        point.z.as_slice()[..self.rows.n()].to_vec()
    }

    fn q(&self, point: &Point) -> Vec<f64> {
        self.rows.unscaled(&point.z.as_slice()[..self.rows.n()])
    }
}

impl Critical<'_> {
    /// Φ, and the slopes of Φ and of the point, in units of the mechanism.
    fn slopes(&mut self, x: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let at = self.rows.at(self.t, x, &self.u);
        let q = self.rows.unscaled(x);
        let of_point = self.point.gradients(self.t, &q);
        let m = self.active.len();
        let slopes = DMatrix::from_fn(m + 2, x.len(), |i, k| match self.active.get(i) {
            Some(&row) => at.jacobian[(row, k)],
            None => of_point[i - m][k] * self.rows.unit_of_column[k] / self.size,
        });
        (DVector::from_fn(m, |i, _| at.value[self.active[i]]), slopes)
    }

    /// A critical pose near `x`, by Gauss and Newton's iteration.
    fn stationary(&mut self, x: &[f64]) -> Option<DVector<f64>> {
        const MOST: usize = 60;
        let (n, m) = (x.len(), self.active.len());
        // The combination of slopes that is least.
        let (_, slopes) = self.slopes(x);
        let mut square = DMatrix::zeros(n.max(m + 2), m + 2);
        square.rows_mut(0, n).copy_from(&slopes.transpose());
        let v_t = square.svd(false, true).v_t?;
        let least = v_t.row(v_t.nrows() - 1);
        let mut z = DVector::from_fn(n + m + 2, |i, _| if i < n { x[i] } else { least[i - n] });
        for _ in 0..MOST {
            let (value, jacobian) = self.at(&z);
            if value.amax() < 1e-12 {
                return Some(z);
            }
            let step = jacobian.svd(true, true).solve(&value, 1e-10).ok()?;
            let size = step.norm();
            if !size.is_finite() {
                return None;
            }
            z -= step * if size > 0.4 { 0.4 / size } else { 1.0 };
        }
        None
    }
}

impl Equations for Critical<'_> {
    fn at(&mut self, z: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        const ASIDE: f64 = 1e-6;
        let (n, m) = (self.rows.n(), self.active.len());
        let x = z.as_slice()[..n].to_vec();
        let weights = z.rows(n, m + 2).into_owned();
        let (phi, slopes) = self.slopes(&x);
        let mut value = DVector::zeros(m + n + 1);
        value.rows_mut(0, m).copy_from(&phi);
        value.rows_mut(m, n).copy_from(&(slopes.transpose() * &weights));
        value[m + n] = 0.5 * (weights.norm_squared() - 1.0);
        let mut jacobian = DMatrix::zeros(m + n + 1, z.len());
        jacobian.view_mut((0, 0), (m, n)).copy_from(&slopes.rows(0, m));
        jacobian.view_mut((m, n), (n, m + 2)).copy_from(&slopes.transpose());
        jacobian.view_mut((m + n, n), (1, m + 2)).copy_from(&weights.transpose());
        // Second derivatives by central differences: Newton's iteration needs no more digits of them.
        for k in 0..n {
            let mut beside = |off: f64| {
                let mut x = x.clone();
                x[k] += off;
                self.slopes(&x).1.transpose() * &weights
            };
            let change = (beside(ASIDE) - beside(-ASIDE)) / (2.0 * ASIDE);
            jacobian.view_mut((m, k), (n, 1)).copy_from(&change);
        }
        (value, jacobian)
    }
}

/// Whether a critical pose lies on a curve of such, with λ and w of either sign.
fn holds(way: &[Point], z: &DVector<f64>, (is_turn, n): (&[bool], usize)) -> bool {
    let off = |from: &Point, sign: f64| {
        let off = DVector::from_fn(z.len(), |i, _| {
            let off = if i < n { z[i] - from.z[i] } else { sign * z[i] - from.z[i] };
            if is_turn[i] { wrapped(off) } else { off }
        });
        let along = off.dot(&from.tangent);
        (along.abs() < 0.05, (off - &from.tangent * along).norm())
    };
    let is_near = |(is_beside, aside): (bool, f64)| is_beside && aside < 2e-3;
    way.iter().any(|from| is_near(off(from, 1.0)) || is_near(off(from, -1.0)))
}

/// Critical curves, cut where they cross each other and themselves.
fn pieces(critical: &[Vec<Stop>], size: f64) -> Vec<Vec<[f64; 2]>> {
    let chords: Vec<(usize, usize)> = critical
        .iter()
        .enumerate()
        .flat_map(|(of, way)| (1..way.len()).map(move |k| (of, k - 1)))
        .collect();
    let ends = |&(of, k): &(usize, usize)| [critical[of][k].p, critical[of][k + 1].p];
    let mut cuts: Vec<Vec<(usize, f64, [f64; 2])>> = vec![Vec::new(); critical.len()];
    for (i, a) in chords.iter().enumerate() {
        for b in &chords[i + 1..] {
            let (p, q) = (ends(a), ends(b));
            let is_apart = (0..2).any(|axis| {
                p[0][axis].max(p[1][axis]) < q[0][axis].min(q[1][axis])
                    || q[0][axis].max(q[1][axis]) < p[0][axis].min(p[1][axis])
            });
            let are_neighbours = a.0 == b.0 && a.1.abs_diff(b.1) <= 1;
            if is_apart || are_neighbours || !cross(p, q) {
                continue;
            }
            let [u, v] = [p, q].map(|[a, b]| [b[0] - a[0], b[1] - a[1]]);
            let across = u[0] * v[1] - u[1] * v[0];
            // Curves that lie on each other do not cross.
            if across.abs() < 1e-3 * u[0].hypot(u[1]) * v[0].hypot(v[1]) {
                continue;
            }
            let off = [q[0][0] - p[0][0], q[0][1] - p[0][1]];
            let share = (off[0] * v[1] - off[1] * v[0]) / across;
            let of_other = (off[0] * u[1] - off[1] * u[0]) / across;
            let at = [p[0][0] + share * u[0], p[0][1] + share * u[1]];
            cuts[a.0].push((a.1, share, at));
            cuts[b.0].push((b.1, of_other, at));
        }
    }
    let mut all = Vec::new();
    for (way, mut cuts) in critical.iter().zip(cuts) {
        cuts.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut piece: Vec<[f64; 2]> = Vec::new();
        let mut cuts = cuts.into_iter().peekable();
        for (k, stop) in way.iter().enumerate() {
            piece.push(stop.p);
            while let Some((_, _, at)) = cuts.next_if(|cut| cut.0 == k) {
                piece.push(at);
                all.push(std::mem::replace(&mut piece, vec![at]));
            }
        }
        all.push(piece);
    }
    let extent = |piece: &Vec<[f64; 2]>| {
        piece.iter().map(|p| (p[0] - piece[0][0]).hypot(p[1] - piece[0][1])).fold(0.0, f64::max)
    };
    all.retain(|piece| piece.len() > 1 && extent(piece) > 1e-9 * size);
    all
}

/// Pieces of a boundary, each once: several assemblies may end on one curve.
fn without_twins(pieces: Vec<Vec<[f64; 2]>>, size: f64) -> Vec<Vec<[f64; 2]>> {
    let off = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let mut kept: Vec<Vec<[f64; 2]>> = Vec::new();
    for piece in pieces {
        let middle = piece[piece.len() / 2];
        let lies_on = |other: &Vec<[f64; 2]>| {
            other.windows(2).any(|pair| {
                let long = off(pair[0], pair[1]).max(f64::MIN_POSITIVE);
                let u = [(pair[1][0] - pair[0][0]) / long, (pair[1][1] - pair[0][1]) / long];
                let d = [middle[0] - pair[0][0], middle[1] - pair[0][1]];
                let along = d[0] * u[0] + d[1] * u[1];
                let aside = (d[0] * u[1] - d[1] * u[0]).abs();
                (0.0..=long).contains(&along) && aside < 1e-4 * size
            })
        };
        if !kept.iter().any(lies_on) {
            kept.push(piece);
        }
    }
    kept
}
