//! Limit positions: where joints and bodies turn back.

use std::f64::consts::TAU;

use crate::curve::{Curve, Point};
use crate::error::AnalysisError;
use crate::path::Path;
use crate::positions::Positions;
use crate::quantity::PoseQuantity;
use crate::scalar::Scalars;
use crate::whole_turns::Turn;

/// A pose in which a quantity is largest or smallest for a moment: a dead point of a mechanism that it drives.
#[derive(Clone, PartialEq, Debug)]
pub struct Extreme {
    /// The quantity that turns back: `rocker.angle`.
    pub name: String,
    /// True if it is largest there.
    pub is_maximum: bool,
    /// Value of the extreme, rad or m.
    pub value: f64,
    /// All joint positions and body angles there, in the order of the quantities.
    pub pose: Vec<(String, f64)>,
}

impl Extreme {
    /// Counts an angle so that it lies in a range, here and in the pose.
    pub(crate) fn within(&mut self, name: &str, [min, max]: [f64; 2]) {
        let turned = |value: f64| {
            let middle = 0.5 * (min + max);
            value + TAU * ((middle - value) / TAU).round()
        };
        if self.name == name {
            self.value = turned(self.value);
        }
        let own = self.pose.iter_mut().filter(|(known, _)| known == name);
        own.for_each(|(_, value)| *value = turned(*value));
    }
}

/// Quantities that are watched along a curve.
#[derive(Debug)]
pub(crate) struct Extremes {
    names: Vec<String>,
    scalars: Scalars,
    /// The unit of each, in SI: 1 rad or the longest link.
    units: Vec<f64>,
    unit_names: Vec<&'static str>,
    /// The turn of a motion that closes, near whose start poses are told.
    turn: Option<Turn>,
}

/// Slopes below this are none: a slider does not turn.
const NO_SLOPE: f64 = 1e-9;

impl Extremes {
    /// Positions of joints, angles and centres of bodies, and `more`.
    pub(crate) fn of(positions: &Positions, more: &[PoseQuantity]) -> Result<Self, AnalysisError> {
        let mut watched = watched(positions);
        watched.extend_from_slice(more);
        let units =
            watched.iter().map(|q| if q.is_angle() { 1.0 } else { positions.size }).collect();
        Ok(Self {
            scalars: positions.scalars(&watched)?,
            unit_names: watched.iter().map(|q| q.unit).collect(),
            names: watched.into_iter().map(|q| q.names[0].clone()).collect(),
            units,
            turn: None,
        })
    }

    /// Tells poses in the turn nearest to where a motion begins; without one in that in which they are reached.
    pub(crate) fn tell_near_start(&mut self, turn: Option<Turn>) {
        self.turn = turn;
    }

    /// Names of what is watched.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// SI units of what is watched.
    pub(crate) fn unit_names(&self) -> &[&'static str] {
        &self.unit_names
    }

    /// Values of what is watched.
    pub(crate) fn values(&mut self, curve: &Curve<Path<'_>>, point: &Point) -> Vec<f64> {
        let n = curve.equations.rows.n();
        let s = point.z.as_slice().get(n).copied().unwrap_or(0.0);
        let z = self.turn.as_ref().map(|turn| turn.nearest(point.z.as_slice()));
        let z = z.as_deref().unwrap_or(point.z.as_slice());
        let q = curve.equations.rows.unscaled(&z[..n]);
        self.scalars.values(curve.equations.time(s), &q)
    }

    /// Slopes along the direction of a point, in units of the mechanism.
    pub(crate) fn slopes(&mut self, curve: &Curve<Path<'_>>, point: &Point) -> Vec<f64> {
        let n = curve.equations.rows.n();
        let (x, direction) = (&point.z.as_slice()[..n], &point.tangent.as_slice()[..n]);
        let s = point.z.as_slice().get(n).copied().unwrap_or(0.0);
        let (q, direction) =
            (curve.equations.rows.unscaled(x), curve.equations.rows.unscaled(direction));
        let slopes = self.scalars.along(curve.equations.time(s), &q, &direction);
        slopes.iter().zip(&self.units).map(|(slope, unit)| slope / unit).collect()
    }

    /// Limit positions within a step of length `whole`, of which `gone` counts.
    pub(crate) fn between(
        &mut self,
        curve: &mut Curve<Path<'_>>,
        (from, to): (&Point, &Point),
        [whole, gone]: [f64; 2],
    ) -> Vec<Extreme> {
        let (before, after) = (self.slopes(curve, from), self.slopes(curve, to));
        let mut found = Vec::new();
        for k in 0..before.len() {
            let is_moving = before[k].abs().max(after[k].abs()) > NO_SLOPE;
            if !is_moving || (before[k] > 0.0) == (after[k] > 0.0) {
                continue;
            }
            let signs = (before[k], after[k]);
            let root = curve.root(from, whole, signs, &mut |curve, p| self.slopes(curve, p)[k]);
            let Some(point) = root else { continue };
            if from.tangent.dot(&(&point.z - &from.z)) > gone + 1e-9 {
                continue;
            }
            found.push(self.at(curve, &point, k, before[k] > 0.0));
        }
        found
    }

    fn at(
        &mut self,
        curve: &Curve<Path<'_>>,
        point: &Point,
        k: usize,
        is_maximum: bool,
    ) -> Extreme {
        let pose = self.pose(curve, point);
        Extreme { name: self.names[k].clone(), is_maximum, value: pose[k].1, pose }
    }

    /// Values of everything watched.
    pub(crate) fn pose(&mut self, curve: &Curve<Path<'_>>, point: &Point) -> Vec<(String, f64)> {
        let values = self.values(curve, point);
        self.names.iter().cloned().zip(values).collect()
    }
}

/// Positions of joints, angles and centres of bodies.
fn watched(positions: &Positions) -> Vec<PoseQuantity> {
    let model = positions.model();
    let n_joint_motions: usize = model.joints.iter().map(|joint| joint.kind.motions().len()).sum();
    let is_watched = |(idx, quantity): (usize, &PoseQuantity)| {
        let name = &quantity.names[0];
        let is_of_body = model.bodies.iter().skip(1).any(|body| {
            let words = ["angle", "x", "y", "z"];
            words.iter().any(|word| *name == format!("{}.{word}", body.name))
        });
        idx < n_joint_motions || is_of_body
    };
    let all = positions.quantities().iter().enumerate();
    all.filter(|&(idx, quantity)| is_watched((idx, quantity))).map(|(_, q)| q.clone()).collect()
}
