//! [`Drag`]: a point of a body is pulled, and the mechanism follows as far as its joints allow.
//!
//! ```text
//! min |p(q) − p*|²   subject to g(q) = 0, φ(q) ≤ 0
//!
//! Π = 1 − G⁺G                      projector onto the free motions
//! δ = (P Π)⁺ (p* − p)              shortest free motion that takes the point nearest; P = ∂p/∂q
//! q ← q + δ, then q ← q − G⁺g      until g = 0
//! ```
//!
//! Steps are short and each returns to the constraints by a correction that is shorter still, so the way is
//! followed and never left for another assembly. Drives are released: the hand moves what they would move.
//! Stops end the way; where one is reached, the motion that would press on it is left out of Π.

use bksim_mbs::constraint::Source;
use bksim_mbs::coordinate::Coordinate;
use bksim_model::{BodyId, Model};
use bksim_sim::{Mechanism, Svd};
use nalgebra::{DMatrix, DVector, Vector3};

use crate::beyond::{Limit, depths, limits};
use crate::error::AnalysisError;
use crate::positions::Positions;
use crate::quantity::PoseQuantity;
use crate::rows::{Clock, RANK_TOLERANCE, Rows, rank, rank_of};
use crate::scalar::Scalars;
use crate::transmission::{TRANSMISSION, acute, angles, arms};

/// The longest step, rad or parts of the longest link: the branch of a loop is followed, not guessed.
const STEP: f64 = 0.08;
/// Most steps of one pull; the way of a crank is done in forty.
const MOST_STEPS: usize = 160;
/// Constraints that count as met, rad or parts of the longest link.
const MET: f64 = 1e-13;
/// A correction longer than this part of its step means that the step was too long.
const CURVED: f64 = 0.3;
/// Steps below it change nothing that can be seen.
const STILL: f64 = 1e-12;
/// Velocity of the point below which a free motion does not count as one of it.
const SLOWEST: f64 = 1e-7;
/// A point whose free motion is slower than this part of the mechanism's is at a dead point.
const DEAD: f64 = 1e-3;
/// The longest way to the pose of changed lengths, rad or parts of the longest link.
const NEAR: f64 = 0.7;
/// Gap of a stop that counts as closed, rad or parts of the longest link.
const CLOSED: f64 = 1e-10;

/// A mechanism that follows one of its points as a hand drags it.
#[derive(Debug)]
pub struct Drag {
    mechanism: Mechanism,
    rows: Rows,
    stops: Vec<Limit>,
    penetrations: Scalars,
    /// Transmission angles by their names; the functions are compiled when they are first asked for.
    transmissions: (Vec<PoseQuantity>, Option<Scalars>),
    grabbed: Option<Scalars>,
    /// Coordinates, in units of the mechanism.
    x: Vec<f64>,
    /// The longest link, m.
    size: f64,
}

/// The end of one pull.
#[derive(Clone, PartialEq, Debug)]
pub struct Dragged {
    /// Distance of the point from where it was pulled to, m.
    pub distance: f64,
    /// The reason for a distance, if it is known.
    pub limit: Option<DragLimit>,
}

/// Reason why a pull ended before its target.
#[derive(Clone, PartialEq, Debug)]
pub enum DragLimit {
    /// A stop of the joint of this name.
    Stop(String),
    /// The point turns back: it has no velocity, however the mechanism moves.
    DeadPoint,
}

impl Drag {
    /// A mechanism at its start, which `model` closes at; masses take no part.
    ///
    /// # Errors
    /// [`AnalysisError::Rejected`] when it does not close.
    pub fn of(model: Model) -> Result<Self, AnalysisError> {
        let positions = Positions::of(model)?;
        let (model, system) = (positions.model(), positions.system());
        let is_kept = |row: &usize| !matches!(system.constraints[*row].source, Source::Drive(_));
        let kept: Vec<usize> = (0..system.constraints.len()).filter(is_kept).collect();
        let numbers = (positions.mechanism.parameters.as_slice(), positions.size, Clock::Held);
        let rows = Rows::compile(model, system, &[], &kept, numbers)?;
        let stops = limits(&positions);
        let penetrations = depths((model, system), &stops, &positions.mechanism.parameters)?;
        let transmissions = (angles(&positions, &arms(&positions)), None);
        let x = rows.scaled(&positions.q);
        let (mechanism, size) = (positions.mechanism, positions.size);
        let grabbed = None;
        Ok(Self { mechanism, rows, stops, penetrations, transmissions, grabbed, x, size })
    }

    /// The mechanism, of positions alone.
    pub fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    /// The coordinates now.
    pub fn q(&self) -> Vec<f64> {
        self.rows.unscaled(&self.x)
    }

    /// Puts the mechanism into another pose, one that satisfies its constraints.
    ///
    /// # Panics
    /// If `q` has not one number for each coordinate.
    pub fn set_q(&mut self, q: &[f64]) {
        assert_eq!(q.len(), self.x.len(), "one number for each coordinate");
        self.x = self.rows.scaled(q);
    }

    /// Goes to the pose on the constraints that is nearest to these coordinates, one after a small change of
    /// lengths; false, and nothing changes, where there is none near.
    ///
    /// # Panics
    /// If `q` has not one number for each coordinate.
    pub fn go_near(&mut self, q: &[f64]) -> bool {
        assert_eq!(q.len(), self.x.len(), "one number for each coordinate");
        let x = self.rows.scaled(q);
        let found = self.corrected(x, NEAR);
        found.map(|x| self.x = x).is_some()
    }

    /// Coordinates that fix the pose, as few as do, if all drives stand still.
    pub fn independent(&mut self) -> Vec<usize> {
        let (t, n) = (self.t(), self.x.len());
        let Mechanism { model, system, parameters, .. } = &self.mechanism;
        let all: Vec<usize> = (0..system.constraints.len()).collect();
        let numbers = (parameters.as_slice(), self.size, Clock::Held);
        let Ok(mut rows) = Rows::compile(model, system, &[], &all, numbers) else {
            return Vec::new();
        };
        let mut conditions = rows.at(t, &self.x, &[]).jacobian;
        let mut found = Vec::new();
        for column in 0..n {
            let m = conditions.nrows();
            let mut more = conditions.clone().insert_row(m, 0.0);
            more[(m, column)] = 1.0;
            if rank(&more) > rank(&conditions) {
                conditions = more;
                found.push(column);
            }
        }
        found
    }

    /// The transmission angles of the pose, acute, rad, by the joints that they are at.
    ///
    /// # Errors
    /// [`AnalysisError::Compile`] never comes of a model that was derived.
    pub fn transmissions(&mut self) -> Result<Vec<(String, f64)>, AnalysisError> {
        let (t, q) = (self.t(), self.q());
        let Mechanism { model, system, parameters, .. } = &self.mechanism;
        let (quantities, compiled) = &mut self.transmissions;
        if compiled.is_none() {
            let functions: Vec<_> = quantities.iter().map(|quantity| quantity.value).collect();
            *compiled = Some(Scalars::compile(model, system, &functions, parameters)?);
        }
        let values = compiled.as_mut().map_or_else(Vec::new, |of| of.values(t, &q));
        let at = |quantity: &PoseQuantity| {
            quantity.names[0].strip_prefix(TRANSMISSION).unwrap_or_default().to_owned()
        };
        Ok(quantities.iter().zip(values).map(|(of, angle)| (at(of), acute(angle))).collect())
    }

    /// The longest link, m.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// The generalised coordinates.
    pub fn coordinates(&self) -> &[Coordinate] {
        self.mechanism.system.coordinates()
    }

    /// Takes hold of a point in the frame of a body, m.
    ///
    /// # Errors
    /// [`AnalysisError::Compile`] never comes of a model that was derived.
    pub fn grab(&mut self, body: BodyId, point: [f64; 3]) -> Result<(), AnalysisError> {
        let Mechanism { model, system, parameters, .. } = &self.mechanism;
        let pool = &model.pool;
        let number = |x: f64| pool.number(bksim_expr::Number::float(x));
        let place = system.kinematics.poses[body.0].position(pool, &point.map(number));
        self.grabbed = Some(Scalars::compile(model, system, &place, parameters)?);
        Ok(())
    }

    /// Lets go.
    pub fn release(&mut self) {
        self.grabbed = None;
    }

    /// Pulls the point that is held to a place in the world, m, as near as the joints allow.
    pub fn to(&mut self, target: [f64; 3]) -> Dragged {
        let Some(mut grabbed) = self.grabbed.take() else {
            return Dragged { distance: 0.0, limit: None };
        };
        let dragged = self.pull(&mut grabbed, Vector3::from(target) / self.size);
        self.grabbed = Some(grabbed);
        dragged
    }

    fn pull(&mut self, grabbed: &mut Scalars, target: Vector3<f64>) -> Dragged {
        let mut limit = None;
        let mut off = target - self.place(grabbed, &self.x);
        for _ in 0..MOST_STEPS {
            let Some((step, stop)) = self.free_step(grabbed, &off) else { break };
            limit = stop;
            match self.advance(grabbed, &step, (&target, off.norm())) {
                Some(next) => {
                    let gained = off.norm() - next.norm();
                    off = next;
                    if gained < STILL || off.norm() < STILL {
                        break;
                    }
                }
                None => break,
            }
        }
        let distance = off.norm() * self.size;
        let is_there = off.norm() < 1e-9;
        Dragged { distance, limit: limit.filter(|_| !is_there) }
    }

    /// World position of the point in units of the mechanism.
    fn place(&self, grabbed: &mut Scalars, x: &[f64]) -> Vector3<f64> {
        let p = grabbed.values(self.t(), &self.rows.unscaled(x));
        Vector3::new(p[0], p[1], p[2]) / self.size
    }

    fn t(&self) -> f64 {
        self.mechanism.model.solve.t_start
    }

    /// δ, no longer than [`STEP`], and what keeps it from being longer.
    fn free_step(
        &mut self,
        grabbed: &mut Scalars,
        off: &Vector3<f64>,
    ) -> Option<(DVector<f64>, Option<DragLimit>)> {
        let t = self.t();
        let (n, q) = (self.x.len(), self.q());
        let slopes = grabbed.gradients(t, &q);
        let unit = self.rows.unit_of_column.clone();
        let point = DMatrix::from_fn(3, n, |i, j| slopes[i][j] * unit[j] / self.size);
        let mut conditions = self.rows.at(t, &self.x, &[]).jacobian;
        let depths = self.penetrations.values(t, &q);
        let walls = self.penetrations.gradients(t, &q);
        let mut limit = None;
        let off = DVector::from_column_slice(off.as_slice());
        // One more closed stop that the motion would press on is held in each round.
        for _ in 0..=self.stops.len() {
            let free = free_motions(&conditions)?;
            let ways = Svd::new(&(&point * &free))?;
            if limit.is_none() && ways.largest() < DEAD {
                limit = Some(DragLimit::DeadPoint);
            }
            let mut step = ways.solve(&off, SLOWEST);
            let longest = step.amax();
            if longest > STEP {
                step *= STEP / longest;
            }
            let pressing = (0..self.stops.len()).find(|&k| {
                let unit_of_stop = self.stops[k].unit;
                let along: f64 = (0..n).map(|j| walls[k][j] * unit[j] * step[j]).sum();
                depths[k] / unit_of_stop > -CLOSED && along / unit_of_stop > STILL
            });
            let Some(k) = pressing else { return Some((step, limit)) };
            limit = Some(DragLimit::Stop(self.stops[k].joint.clone()));
            let m = conditions.nrows();
            conditions = conditions.insert_row(m, 0.0);
            for j in 0..n {
                conditions[(m, j)] = walls[k][j] * unit[j] / self.stops[k].unit;
            }
        }
        None
    }

    /// Makes as much of a step as brings the point nearer; the rest of the way, if it did.
    fn advance(
        &mut self,
        grabbed: &mut Scalars,
        step: &DVector<f64>,
        (target, before): (&Vector3<f64>, f64),
    ) -> Option<Vector3<f64>> {
        let mut part = 1.0;
        while part * step.amax() > STILL {
            let moved: Vec<f64> =
                self.x.iter().zip(step.iter()).map(|(x, d)| x + part * d).collect();
            let corrected = self.corrected(moved, CURVED * part * step.amax());
            if let Some(x) = corrected.filter(|x| self.allow(x)) {
                let off = target - self.place(grabbed, &x);
                if off.norm() < before {
                    self.x = x;
                    return Some(off);
                }
            }
            part *= 0.5;
        }
        None
    }

    /// Coordinates on the constraints near some; `None` where they are farther away than `most`.
    fn corrected(&mut self, mut x: Vec<f64>, most: f64) -> Option<Vec<f64>> {
        let t = self.t();
        let mut left = most.max(1e3 * STILL);
        for _ in 0..12 {
            let at = self.rows.at(t, &x, &[]);
            if at.value.amax() < MET {
                return Some(x);
            }
            let svd = Svd::new(&at.jacobian)?;
            let correction = svd.solve(&at.value, RANK_TOLERANCE * svd.largest());
            left -= correction.amax();
            if left < 0.0 || correction.iter().any(|d| !d.is_finite()) {
                return None;
            }
            x.iter_mut().zip(correction.iter()).for_each(|(x, d)| *x -= d);
            if correction.amax() < 1e-15 {
                return Some(x);
            }
        }
        None
    }

    /// Whether no stop is passed, or none farther than where it was passed before.
    fn allow(&mut self, x: &[f64]) -> bool {
        if self.stops.is_empty() {
            return true;
        }
        let t = self.t();
        let before = self.penetrations.values(t, &self.q());
        let after = self.penetrations.values(t, &self.rows.unscaled(x));
        let mut pairs = before.iter().zip(&after).zip(&self.stops);
        pairs.all(|((before, after), stop)| after / stop.unit < CLOSED || after <= before)
    }
}

/// Π for these conditions.
fn free_motions(conditions: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = conditions.ncols();
    let svd = Svd::new(conditions)?;
    let rank = rank_of(&svd.singular_values);
    let held = svd.v_t.rows(0, rank);
    Some(DMatrix::identity(n, n) - held.transpose() * held)
}
