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
//! one equation less than there are unknowns x, λ, w. The curves of solutions cut the plane into cells; the point can be
//! brought to all places of a cell, or to none.
//!
//! Source: E. J. Haug, C. M. Luh, F. A. Adkins and J. Y. Wang, *Numerical algorithms for mapping boundaries of
//! manipulator workspaces*, Journal of Mechanical Design 118 (1996).

mod cells;
mod critical;
mod pieces;

use bksim_model::{Measure, Model, Space};
use bksim_sim::Svd;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::assemblies::{closed, closed_poses};
use crate::curve::{Curve, Equations, Point, independent_rows};
use crate::curves::point;
use crate::error::AnalysisError;
use crate::path::{Law, Path};
use crate::positions::Positions;
use crate::quantity::PoseQuantity;
use crate::region::doubled_area;
use crate::rows::{Clock, Rows, wrapped};
use crate::scalar::Scalars;
use crate::trace::{Trace, closed_way};
use cells::{Cell, boundary, cells};
use critical::{Critical, InMechanism, holds};
use pieces::pieces;

/// The region of the plane that a point reaches.
#[derive(Clone, PartialEq, Debug)]
pub struct Workspace {
    /// The point.
    pub name: String,
    /// Boundary: closed curves, the region on their left, m.
    pub boundary: Vec<Vec<[f64; 2]>>,
    /// Curves inside on which the point cannot go straight on in one of the assemblies, m.
    pub barriers: Vec<Vec<[f64; 2]>>,
    /// Area, m²; of a region that is bounded.
    pub area: f64,
}

/// Distance from a curve at which it is decided whether both sides can be reached, longest links.
const ASIDE: f64 = 2e-3;
/// Poses from which that is tried.
const MOST_SEEDS: usize = 60;
/// Part of a limit, rad or longest links, by which the way to a place may pass it.
const BEYOND: f64 = 0.01;
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
    let seeds = closed_poses(&positions, &mut rows);
    let mut found = Vec::new();
    for name in names {
        let mut reach = Reach::of(&positions, name, limits.clone())?;
        let near = reach.wandered(&mut rows, &start);
        let seeds = [near.as_slice(), &seeds].concat();
        let mut critical = Vec::new();
        for held in reach.held_sets(n_free) {
            critical.extend(reach.critical(&positions, (&held, &released), n_free, &seeds)?);
        }
        found.push(reach.workspace(&mut rows, name, &critical, &near));
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
            let (Some((joint, motion_idx)), Some([min, max])) =
                (load.kind.joint_motion(), load.kind.limits())
            else {
                continue;
            };
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

    /// Poses to which the mechanism gets from its start without passing a limit, by steps to random sides.
    fn wandered(&mut self, rows: &mut Rows, start: &[f64]) -> Vec<Vec<f64>> {
        const MOST: usize = 400;
        const TRIES: usize = 3000;
        const STEP: f64 = 0.35;
        let mut random = Pcg64::seed_from_u64(3);
        let mut found = vec![start.to_vec()];
        for _ in 0..TRIES {
            if found.len() == MOST {
                break;
            }
            let from = &found[random.random_range(0..found.len())];
            let aside: Vec<f64> =
                from.iter().map(|x| x + STEP * random.random_range(-1.0..1.0)).collect();
            let Some(x) = closed(rows, self.t, aside.clone(), &[]) else { continue };
            let went = x.iter().zip(&aside).map(|(x, aside)| (x - aside).abs()).fold(0.0, f64::max);
            let (_, passed) = self.at(&rows.unscaled(&x));
            if went < STEP && passed.iter().all(|passed| *passed <= AT_LIMIT) {
                found.push(x);
            }
        }
        found
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
        for x in seeds {
            let (p, _) = self.at(&rows.unscaled(x));
            pool.push(Stop { p, x: x.clone() });
        }
        let ways: Vec<Vec<[f64; 2]>> =
            critical.iter().map(|way| way.iter().map(|stop| stop.p).collect()).collect();
        let all = cells(&ways, self.size);
        // Critical curves alone lead from what is reached to what is not.
        let mut is_reached = |cell: &Cell| {
            pool.iter().any(|stop| cell.holds(stop.p, 0.1))
                || self.reaches(rows, cell.middle, &pool)
        };
        let mut reached = all;
        reached.retain(|cell| is_reached(cell));
        let is_barrier = |piece: &Vec<[f64; 2]>| {
            let middle = piece.len() / 2;
            let [a, b] = [piece[middle - 1], piece[middle]];
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let long = dx.hypot(dy);
            let is_within = |sign: f64| {
                let aside = sign * ASIDE * self.size / long;
                let p = [0.5 * (a[0] + b[0]) - aside * dy, 0.5 * (a[1] + b[1]) + aside * dx];
                reached.iter().any(|cell| cell.has(p))
            };
            long > 0.0 && is_within(1.0) && is_within(-1.0)
        };
        let barriers = pieces(&ways, self.size).into_iter().filter(is_barrier).collect();
        let boundary = boundary(&reached, self.size);
        let area = boundary.iter().map(|ring| 0.5 * doubled_area(ring)).sum();
        Workspace { name: name.to_owned(), boundary, barriers, area }
    }

    /// True if the point can be brought to a place without passing a limit.
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

    /// True if Newton's iteration from a pose brings the point to a place within the limits.
    fn brought(&mut self, rows: &mut Rows, mut x: Vec<f64>, target: [f64; 2]) -> bool {
        const MOST: usize = 60;
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
            // A little beyond a limit the way may still turn back.
            if passed.iter().any(|passed| *passed > BEYOND) {
                return false;
            }
            let slopes = self.scalars.gradients(self.t, &q);
            let jacobian = DMatrix::from_fn(m + 2, n, |i, k| {
                if i < m {
                    at.jacobian[(i, k)]
                } else {
                    slopes[i - m][k] * rows.unit_of_column[k] / self.size
                }
            });
            let Some(svd) = Svd::new(&jacobian) else { return false };
            let step = svd.solve(&value, 1e-9);
            let size = step.norm();
            if !size.is_finite() {
                return false;
            }
            // By short steps, so that none leads into another assembly past a limit.
            let share = if size > 0.2 { 0.2 / size } else { 1.0 };
            x.iter_mut().zip(step.iter()).for_each(|(x, step)| *x -= share * step);
        }
        false
    }
}
