//! [`Legs`]: two rigid parts and what keeps points of one at distances from points of the other.
//!
//! A leg is a link joint, or a chain of parts from a ball or cross on one part to one on the other, with no other joints in
//! between than pins about the line through both ends. A chain of a pin and a ball keeps a point on a circle, which are two
//! distances: from any two points of the axis. What is held moves as one. Everything is measured in the start, in
//! world axes.

use bksim_model::{Joint, JointKind, Measure, Model, MotionKind, Space};
use nalgebra::Vector3;

use crate::error::AnalysisError;
use crate::positions::Positions;
use crate::scalar::Scalars;

/// A condition on the distance of two points.
pub(super) struct Leg {
    /// On the base and on the platform, m.
    pub(super) ends: [Vector3<f64>; 2],
    /// Joints by number, from the base on.
    pub(super) joints: Vec<usize>,
    /// True of one of the two distances of a pin and a ball.
    pub(super) is_circle: bool,
}

/// A platform on six legs.
pub(super) struct Legs {
    /// The legs, in the order of their joints.
    pub(super) six: Vec<Leg>,
    /// A body of the base, the ground if it is part of it, and one of the platform.
    pub(super) bodies: [usize; 2],
    /// The longest link, m.
    pub(super) size: f64,
    /// Of each body whether it belongs to a leg.
    is_in_leg: Vec<bool>,
}

/// A joint in the start.
struct Placed {
    parts: [usize; 2],
    points: [Vector3<f64>; 2],
    axis: Vector3<f64>,
    /// Motions without those that are held.
    left: Left,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Left {
    Nothing,
    /// About its axis.
    Pin,
    Cross,
    Ball,
    /// A distance.
    Link,
}

/// Number of legs that hold a body.
const N_LEGS: usize = 6;

impl Legs {
    /// The legs of a mechanism whose `held` measures and drives do not move; none for one of another kind.
    pub(super) fn of(
        positions: &Positions,
        held: &[Measure],
    ) -> Result<Option<Self>, AnalysisError> {
        let model = positions.model();
        let bends = model.bodies.iter().any(|body| body.flexible.is_some());
        if model.space == Space::Planar || bends || !model.couplings.is_empty() {
            return Ok(None);
        }
        let Some(left) = left_motions(model, held) else { return Ok(None) };
        let joints = placed(positions, &left)?;
        Ok(Self::found(model, joints, positions.size))
    }

    fn found(model: &Model, mut joints: Vec<Placed>, size: f64) -> Option<Self> {
        // Parts by the smallest number of their bodies.
        let mut part: Vec<usize> = (0..model.bodies.len()).collect();
        for joint in joints.iter().filter(|joint| joint.left == Left::Nothing) {
            let [a, b] = joint.parts.map(|body| part[body]);
            part.iter_mut().filter(|p| **p == a.max(b)).for_each(|p| *p = a.min(b));
        }
        for joint in &mut joints {
            joint.parts = joint.parts.map(|body| part[body]);
        }
        let between: Vec<usize> = (0..joints.len())
            .filter(|&k| {
                joints[k].left != Left::Nothing && joints[k].parts[0] != joints[k].parts[1]
            })
            .collect();
        let on = |p: usize| between.iter().filter(|&&k| joints[k].parts.contains(&p)).count();
        let mut many: Vec<usize> = part.clone();
        many.sort_unstable();
        many.dedup();
        many.retain(|p| on(*p) != 2);
        let [base, platform] = many[..] else { return None };

        // From the base on along every joint.
        let mut legs = Vec::new();
        let mut used = 0;
        for &first in between.iter().filter(|&&k| joints[k].parts.contains(&base)) {
            let (mut chain, mut here) = (vec![first], other(&joints[first], base));
            while here != platform && here != base {
                let last = chain[chain.len() - 1];
                let mut onward = between.iter().filter(|&&k| k != last);
                let next = *onward.find(|&&k| joints[k].parts.contains(&here))?;
                chain.push(next);
                here = other(&joints[next], here);
            }
            if here == base {
                return None;
            }
            used += chain.len();
            match circle(&joints, &chain, base, size) {
                Some(both) => legs.extend(both),
                None => legs.push(leg(&joints, chain, base, size)?),
            }
        }
        let is_all = used == between.len() && legs.len() == N_LEGS;
        let is_in_leg = part.iter().map(|p| ![base, platform].contains(p)).collect();
        is_all.then_some(Self { six: legs, bodies: [base, platform], size, is_in_leg })
    }

    /// True of a joint on a body of a leg.
    pub(super) fn holds(&self, joint: &Joint) -> bool {
        [joint.predecessor.body, joint.successor.body].iter().any(|body| self.is_in_leg[body.0])
    }
}

/// The part at the other end of a joint.
fn other(joint: &Placed, part: usize) -> usize {
    let [a, b] = joint.parts;
    if a == part { b } else { a }
}

/// The distance that a chain from the base keeps; none for one that asks for more or less than that.
fn leg(joints: &[Placed], chain: Vec<usize>, base: usize, size: f64) -> Option<Leg> {
    /// Distance of a pin from the line of its leg, in lengths of the longest link.
    const ON_LINE: f64 = 1e-9;
    let first = &joints[chain[0]];
    let from = first.points[usize::from(first.parts[0] != base)];
    if let [only] = chain[..] {
        let joint = &joints[only];
        let to = joint.points[usize::from(joint.parts[0] == base)];
        let is_link = joint.left == Left::Link;
        return is_link.then_some(Leg { ends: [from, to], joints: chain, is_circle: false });
    }
    let last = &joints[chain[chain.len() - 1]];
    let to = last.points[0];
    let is_end = |joint: &Placed| matches!(joint.left, Left::Cross | Left::Ball);
    let inner = &chain[1..chain.len() - 1];
    let is_along = |&k: &usize| {
        let joint = &joints[k];
        let off = |p: Vector3<f64>| (p - joint.points[0]).cross(&joint.axis).norm();
        joint.left == Left::Pin && off(from) < ON_LINE * size && off(to) < ON_LINE * size
    };
    // Two crosses without a pin between them hold the turn about the line, too.
    let has_ball = [first, last].iter().any(|joint| joint.left == Left::Ball);
    let is_leg = is_end(first)
        && is_end(last)
        && inner.iter().all(is_along)
        && (has_ball || inner.len() == 1)
        && (from - to).norm() > ON_LINE * size;
    is_leg.then_some(Leg { ends: [from, to], joints: chain, is_circle: false })
}

/// The distances of a ball from two points on the axis of a pin; none of another chain.
fn circle(joints: &[Placed], chain: &[usize], base: usize, size: f64) -> Option<[Leg; 2]> {
    /// Radius of a circle that is one, in lengths of the longest link.
    const LEAST: f64 = 1e-6;
    let [first, last] = *chain else { return None };
    let of = |kind: Left| [first, last].into_iter().find(|&k| joints[k].left == kind);
    let (pin, ball) = (&joints[of(Left::Pin)?], of(Left::Ball)?);
    // A ball is at one place on both of its parts.
    let (centre, axis) = (joints[ball].points[0], pin.axis.normalize());
    let foot = pin.points[0] + axis * axis.dot(&(centre - pin.points[0]));
    let radius = (centre - foot).norm();
    let is_from_base = joints[first].left == Left::Pin && joints[first].parts.contains(&base);
    let leg = |side: f64| {
        let on_axis = foot + axis * (side * radius);
        let ends = if is_from_base { [on_axis, centre] } else { [centre, on_axis] };
        Leg { ends, joints: chain.to_vec(), is_circle: true }
    };
    (radius > LEAST * size).then(|| [-1.0, 1.0].map(leg))
}

/// The motions of each joint without those that drives and measures hold; none where these are not known.
fn left_motions(model: &Model, held: &[Measure]) -> Option<Vec<Left>> {
    let drives = model.drives.iter();
    let mut still: Vec<(usize, usize)> =
        drives.map(|drive| (drive.joint.0, drive.motion_idx)).collect();
    for measure in held {
        let Measure::JointPosition(joint, motion) = *measure else { return None };
        still.push((joint.0, motion));
    }
    let left = |(idx, joint): (usize, &Joint)| {
        let motions = joint.kind.motions();
        let free: Vec<MotionKind> = (0..motions.len())
            .filter(|motion| !still.contains(&(idx, *motion)))
            .map(|motion| motions[motion])
            .collect();
        match (joint.kind, &free[..]) {
            (JointKind::Link { .. }, _) => Some(Left::Link),
            (JointKind::Spherical, all) if all.len() == motions.len() => Some(Left::Ball),
            (JointKind::Universal { .. }, all) if all.len() == motions.len() => Some(Left::Cross),
            (JointKind::Weld { .. } | JointKind::Revolute | JointKind::Prismatic { .. }, []) => {
                Some(Left::Nothing)
            }
            (JointKind::Revolute | JointKind::Cylindrical, [MotionKind::Rotation]) => {
                Some(Left::Pin)
            }
            (JointKind::Cylindrical, []) => Some(Left::Nothing),
            _ => None,
        }
    };
    model.joints.iter().enumerate().map(left).collect()
}

/// All joints in the start, parts being bodies.
fn placed(positions: &Positions, left: &[Left]) -> Result<Vec<Placed>, AnalysisError> {
    let (model, kinematics) = (positions.model(), &positions.system().kinematics);
    let functions = |joint: &Joint| {
        let sides = kinematics.sides(model, joint);
        let axis = sides.predecessor.rotation.apply(&model.pool, &joint.axis);
        [sides.p_world_predecessor, sides.p_world_successor, axis].concat()
    };
    let functions: Vec<_> = model.joints.iter().flat_map(functions).collect();
    let parameters = &positions.mechanism.parameters;
    let values = Scalars::compile(model, positions.system(), &functions, parameters)?
        .values(positions.t(), &positions.q);
    let joint = |(k, (joint, left)): (usize, (&Joint, &Left))| {
        let vector =
            |i: usize| Vector3::from_column_slice(&values[9 * k + 3 * i..9 * k + 3 * i + 3]);
        Placed {
            parts: [joint.predecessor.body.0, joint.successor.body.0],
            points: [vector(0), vector(1)],
            axis: vector(2),
            left: *left,
        }
    };
    Ok(model.joints.iter().zip(left).enumerate().map(joint).collect())
}
