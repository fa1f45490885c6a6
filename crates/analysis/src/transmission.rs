//! Transmission angles: between the links that a joint connects, as the acute angle μ, and the pressure angle 90° − μ.
//!
//! ```text
//! sin² μ = (a × b)² / (a·a b·b)     smooth everywhere; its extremes are those of μ
//! ```
//!
//! a and b go from the joint to the next pins of its loop; next to a guide the arm is across the guide, so that the pressure
//! angle is that between the coupler and the guide. Source: R. L. Norton, *Design of Machinery*, sections 3.3 and 4.10.

use std::f64::consts::{FRAC_PI_2, PI};

use bksim_model::{Anchor, GROUND, JointId, Model, Space, Vector};
use bksim_sim::mobility::loop_through;

use crate::curve::Curve;
use crate::error::AnalysisError;
use crate::extreme::Extremes;
use crate::path::Path;
use crate::positions::Positions;
use crate::quantity::PoseQuantity;
use crate::trace::Trace;
use crate::whole_turns::Turn;

/// The transmission angle of a joint over a motion.
#[derive(Clone, PartialEq, Debug)]
pub struct Transmission {
    /// The joint, `C`, or an end of a link without mass, `rod at piston`.
    pub at: String,
    /// Where it is least, and the pressure angle greatest.
    pub least: TransmissionAt,
    /// Where it is greatest.
    pub greatest: TransmissionAt,
}

/// A transmission angle in a pose.
#[derive(Clone, PartialEq, Debug)]
pub struct TransmissionAt {
    /// μ, rad, from 0 to π/2.
    pub angle: f64,
    /// All joint positions and body angles there.
    pub pose: Vec<(String, f64)>,
}

impl TransmissionAt {
    /// 90° − μ, rad.
    pub fn pressure(&self) -> f64 {
        FRAC_PI_2 - self.angle
    }
}

/// The two directions at a joint of a loop.
pub(crate) struct Arms {
    at: String,
    arms: [Vector; 2],
}

/// The arms at all pins between moving bodies, and at the ends of massless links on them.
pub(crate) fn arms(positions: &Positions) -> Vec<Arms> {
    let model = positions.model();
    let mut all = Vec::new();
    if model.space != Space::Planar {
        return all;
    }
    for (idx, joint) in model.joints.iter().enumerate() {
        let around = loop_through(model, JointId(idx));
        let place = around.iter().position(|j| j.0 == idx).unwrap_or(0);
        if around.len() < 3 {
            continue;
        }
        // A loop begins with its joint: its neighbours are the next and the last.
        let neighbours =
            [around[(place + 1) % around.len()], around[(place + around.len() - 1) % around.len()]];
        let ends = [joint.predecessor, joint.successor];
        if joint.kind.is_pin() && ends.iter().all(|end| end.body != GROUND) {
            let own = neighbours.map(|j| arm(positions, joint.successor, j));
            if let [Some(a), Some(b)] = own {
                all.push(Arms { at: joint.name.clone(), arms: [a, b] });
            }
        }
        if joint.kind.link_length().is_none() {
            continue;
        }
        for (end, other) in [(ends[0], ends[1]), (ends[1], ends[0])] {
            let touches = |j: &JointId| touches(model, *j, end);
            let Some(next) = neighbours.into_iter().find(touches) else { continue };
            let (here, there) = (anchor(positions, end), anchor(positions, other));
            let along = bksim_mbs::spatial::sub(&model.pool, &there, &here);
            let Some(own) = arm(positions, end, next) else { continue };
            if end.body != GROUND {
                let body = &model.bodies[end.body.0].name;
                let at = format!("{} at {body}", joint.name);
                all.push(Arms { at, arms: [along, own] });
            }
        }
    }
    all
}

fn anchor(positions: &Positions, end: Anchor) -> Vector {
    positions.system().kinematics.anchor(positions.model(), end)
}

fn touches(model: &Model, joint: JointId, end: Anchor) -> bool {
    let joint = &model.joints[joint.0];
    [joint.predecessor.body, joint.successor.body].contains(&end.body)
}

/// The way from a point to the next joint of a loop, or across the guide that it is.
fn arm(positions: &Positions, from: Anchor, to: JointId) -> Option<Vector> {
    let model = positions.model();
    let pool = &model.pool;
    let joint = &model.joints[to.0];
    if joint.kind.is_slide() {
        let sides = positions.system().kinematics.sides(model, joint);
        let [x, y, z] = sides.predecessor.rotation.apply(pool, &joint.axis);
        return Some([pool.neg(y), x, z]);
    }
    let there = match joint.kind.link_length() {
        Some(_) if joint.predecessor.body == from.body => joint.predecessor,
        None if !joint.kind.is_pin() && !joint.kind.is_slot() => return None,
        _ => joint.successor,
    };
    let (here, there) = (anchor(positions, from), anchor(positions, there));
    Some(bksim_mbs::spatial::sub(pool, &there, &here))
}

/// Names of the angles from the first arm to the second begin so.
pub(crate) const TRANSMISSION: &str = "transmission ";

/// The angles from the first arm to the second, counted round.
pub(crate) fn angles(positions: &Positions, arms: &[Arms]) -> Vec<PoseQuantity> {
    let pool = &positions.model().pool;
    let angle = |of: &Arms| {
        let [a, b] = &of.arms;
        let across = bksim_mbs::spatial::cross(pool, a, b)[2];
        let along = bksim_mbs::spatial::dot(pool, a, b);
        quantity(format!("{TRANSMISSION}{}", of.at), "rad", pool.atan2(across, along))
    };
    arms.iter().map(angle).collect()
}

fn quantity(name: String, unit: &'static str, value: bksim_expr::Expr) -> PoseQuantity {
    PoseQuantity { names: [name, String::new(), String::new()], unit, value }
}

/// The acute angle between two lines, from that of their directions, rad.
pub(crate) fn acute(angle: f64) -> f64 {
    let angle = angle.abs().rem_euclid(PI);
    angle.min(PI - angle)
}

/// Transmission angles that are watched along a curve.
pub(crate) struct Transmissions {
    names: Vec<String>,
    extremes: Extremes,
}

/// Names of the squares of sines among what is watched.
const SQUARE: &str = "sin² ";

impl Transmissions {
    pub(crate) fn of(positions: &Positions, arms: &[Arms]) -> Result<Self, AnalysisError> {
        let pool = &positions.model().pool;
        let square = |of: &Arms| {
            let [a, b] = &of.arms;
            let across = bksim_mbs::spatial::cross(pool, a, b)[2];
            let lengths = [a, b].map(|v| bksim_mbs::spatial::dot(pool, v, v));
            let value = pool.div(pool.mul(across, across), pool.mul(lengths[0], lengths[1]));
            quantity(format!("{SQUARE}{}", of.at), "", value)
        };
        let mut more = angles(positions, arms);
        more.extend(arms.iter().map(square));
        let names = arms.iter().map(|of| of.at.clone()).collect();
        Ok(Self { names, extremes: Extremes::of(positions, &more)? })
    }

    /// The least and greatest angles along a trace, its ends among them; poses are told in the turn of the start.
    pub(crate) fn along(
        &mut self,
        curve: &mut Curve<Path<'_>>,
        trace: &Trace,
        turn: Option<Turn>,
    ) -> Vec<Transmission> {
        self.extremes.tell_near_start(turn);
        if self.names.is_empty() {
            return Vec::new();
        }
        let mut poses: Vec<Vec<(String, f64)>> = Vec::new();
        let ends = [trace.points.first(), trace.points.last()].into_iter().flatten();
        if !trace.is_closed {
            poses.extend(ends.map(|end| self.extremes.pose(curve, end)));
        }
        for (pair, &step) in trace.points.windows(2).zip(&trace.steps) {
            let found = self.extremes.between(curve, (&pair[0], &pair[1]), [step, step]);
            let own = found.into_iter().filter(|extreme| extreme.name.starts_with(SQUARE));
            poses.extend(own.map(|extreme| extreme.pose));
        }
        // An angle that never changes.
        if let (Some(first), true) = (trace.points.first(), poses.is_empty()) {
            poses.push(self.extremes.pose(curve, first));
        }
        self.names.iter().filter_map(|name| transmission(name, &poses)).collect()
    }
}

/// The extremes of an angle over some poses.
fn transmission(name: &str, poses: &[Vec<(String, f64)>]) -> Option<Transmission> {
    let raw = format!("{TRANSMISSION}{name}");
    let at = |pose: &Vec<(String, f64)>| {
        let (_, angle) = pose.iter().find(|(known, _)| *known == raw)?;
        let is_shown = |(name, _): &&(String, f64)| {
            !name.starts_with(SQUARE) && !name.starts_with(TRANSMISSION)
        };
        let pose = pose.iter().filter(is_shown).cloned().collect();
        Some(TransmissionAt { angle: acute(*angle), pose })
    };
    let all: Vec<TransmissionAt> = poses.iter().filter_map(at).collect();
    let order = |a: &&TransmissionAt, b: &&TransmissionAt| a.angle.total_cmp(&b.angle);
    Some(Transmission {
        at: name.to_owned(),
        least: all.iter().min_by(order)?.clone(),
        greatest: all.iter().max_by(order)?.clone(),
    })
}
