//! The numbers of a model at one set of parameters.

use std::collections::HashMap;

use bksim_expr::{Expr, SymbolId};
use bksim_model::{Anchor, Axis, FixedTurn, Initial, Joint, JointId, Measure, Model, Vector};
use bksim_sim::pose::Pose;

use crate::Attached;
use crate::geometry::{Point, distance_from_edges, turned3};

/// Values of a model's expressions.
pub(super) struct Numbers<'a> {
    pub(super) model: &'a Model,
    values: HashMap<SymbolId, f64>,
    /// The bodies at some instants of the motion, if it is known.
    motion: &'a [Vec<Pose>],
}

impl<'a> Numbers<'a> {
    pub(super) fn new(model: &'a Model, parameters: &[f64], motion: &'a [Vec<Pose>]) -> Self {
        let symbols = model.parameters.iter().map(|parameter| parameter.symbol);
        Self { model, values: symbols.zip(parameters.iter().copied()).collect(), motion }
    }

    /// The value of an expression; zero where it depends on time or motion, or is not finite.
    pub(super) fn value(&self, e: Expr) -> f64 {
        let known = |symbol| self.values.get(&symbol).copied();
        let value = self.model.pool.evaluate(e, &known).ok();
        value.filter(|value| value.is_finite()).unwrap_or(0.0)
    }

    /// Value ([`Numbers::value`]) with a value for one more symbol.
    pub(super) fn value_at(&self, e: Expr, (symbol, at): (SymbolId, f64)) -> f64 {
        let known = |s| if s == symbol { Some(at) } else { self.values.get(&s).copied() };
        self.model.pool.evaluate(e, &known).unwrap_or(f64::NAN)
    }

    /// A vector from a point, in the frame of that point, as a position in the frame of its body.
    pub(super) fn in_frame(&self, anchor: Anchor, offset: [f64; 3]) -> [f64; 3] {
        let body = &self.model.bodies[anchor.body.0];
        let Some(point) = anchor.point.map(|point| &body.points[point.0]) else { return offset };
        let (at, turned) = (self.vector(&point.position), self.turned(&point.orientation, offset));
        std::array::from_fn(|i| at[i] + turned[i])
    }

    pub(super) fn vector(&self, vector: &Vector) -> [f64; 3] {
        vector.map(|e| self.value(e))
    }

    /// The axis of a joint in the frame of one of its two bodies; before any motion the frames of the
    /// joint's points coincide.
    pub(super) fn axis(&self, joint: &Joint, body: usize) -> [f64; 3] {
        let is_second = joint.successor.body.0 == body;
        let anchor = if is_second { joint.successor } else { joint.predecessor };
        self.on_anchor(anchor, self.vector(&joint.axis))
    }

    /// A direction in the frame of a point, in that of its body.
    pub(super) fn on_anchor(&self, anchor: Anchor, direction: [f64; 3]) -> [f64; 3] {
        let Some(point) = anchor.point else { return direction };
        self.turned(&self.model.bodies[anchor.body.0].points[point.0].orientation, direction)
    }

    pub(super) fn attached(&self, anchor: Anchor) -> Attached {
        let body = &self.model.bodies[anchor.body.0];
        // Points of a beam have bodies that go where it bends to.
        let section = body.flexible.as_ref().zip(anchor.point);
        if let Some(section) = section.and_then(|(beam, at)| beam.sections.get(at.0)) {
            return Attached { body: section.0, position: [0.0; 3] };
        }
        let position = anchor.point.map(|point| self.vector(&body.points[point.0].position));
        Attached { body: anchor.body.0, position: position.unwrap_or_default() }
    }

    /// The outline of a body, closed polygons in its frame.
    pub(super) fn outline(&self, body: usize) -> Vec<Vec<Point>> {
        let ring = |ring: &Vec<[Expr; 2]>| ring.iter().map(|p| p.map(|e| self.value(e))).collect();
        self.model.bodies[body].outline.iter().map(ring).collect()
    }

    /// A point in the frame of a solid, in that of its body.
    pub(super) fn on_body(&self, solid: &bksim_model::Solid, p: [f64; 3]) -> [f64; 3] {
        let turned = self.turned(&solid.orientation, p);
        let at = self.vector(&solid.position);
        std::array::from_fn(|i| at[i] + turned[i])
    }

    /// A vector in a frame turned by these turns, each about an axis that those before it have turned.
    fn turned(&self, turns: &[FixedTurn], v: [f64; 3]) -> [f64; 3] {
        let turn =
            |v, turn: &FixedTurn| turned3(v, self.vector(&turn.axis), self.value(turn.angle));
        turns.iter().rev().fold(v, turn)
    }

    /// Distance of a point of a body from the edges of its outline, if it has one.
    pub(super) fn edge_distance(&self, at: Attached) -> Option<f64> {
        let [x, y, _] = at.position;
        let outline = self.outline(at.body);
        outline.iter().map(|ring| distance_from_edges([x, y], ring)).reduce(f64::min)
    }

    /// Smallest and largest position of a joint along its axis: over the motion if that is known,
    /// else `reach` to both sides of its start.
    pub(super) fn travel(&self, joint: usize, reach: f64) -> [f64; 2] {
        let ends = &self.model.joints[joint];
        let (from, to) = (self.attached(ends.predecessor), self.attached(ends.successor));
        let axis = self.axis(ends, from.body);
        let range = range(self.motion.iter().filter_map(|poses| along(poses, from, to, axis)));
        range.unwrap_or_else(|| {
            let start = self.start(joint);
            [start - reach, start + reach]
        })
    }

    /// Position of a joint along its axis at the first instant of the motion, if it is known.
    pub(super) fn first_travel(&self, joint: usize) -> Option<f64> {
        let ends = &self.model.joints[joint];
        let (from, to) = (self.attached(ends.predecessor), self.attached(ends.successor));
        along(self.motion.first()?, from, to, self.axis(ends, from.body))
    }

    /// Position of a joint at the start if the model states it, else zero.
    fn start(&self, joint: usize) -> f64 {
        let is_its =
            |initial: &&Initial| initial.measure == Measure::JointPosition(JointId(joint), 0);
        let own = self.model.initial.iter().find(is_its);
        own.map_or(0.0, |initial| self.value(initial.value))
    }

    /// World vectors from one point to another at the instants of the motion.
    pub(super) fn vectors(&self, from: Attached, to: Attached) -> impl Iterator<Item = [f64; 3]> {
        self.motion.iter().filter_map(move |poses| {
            let p = poses.get(from.body)?.place(from.position);
            let q = poses.get(to.body)?.place(to.position);
            Some(std::array::from_fn(|i| q[i] - p[i]))
        })
    }

    /// The poses of the bodies at the first instant of the motion, if it is known.
    pub(super) fn first_poses(&self) -> Option<&'a [Pose]> {
        self.motion.first().map(Vec::as_slice)
    }

    /// The pose of a body at the first instant of the motion, if it is known.
    pub(super) fn first_pose(&self, body: usize) -> Option<&'a Pose> {
        self.first_poses()?.get(body)
    }

    /// Magnitudes of the initial positions that the model states, m.
    pub(super) fn stated_lengths(&self) -> impl Iterator<Item = f64> {
        let is_length = |initial: &&Initial| {
            matches!(initial.measure, Measure::PointPosition(_, _, Axis::X | Axis::Y | Axis::Z))
        };
        self.model.initial.iter().filter(is_length).map(|initial| self.value(initial.value).abs())
    }
}

/// The part of the vector between two points along an axis of the first body.
fn along(poses: &[Pose], from: Attached, to: Attached, axis: [f64; 3]) -> Option<f64> {
    let (pose, other) = (poses.get(from.body)?, poses.get(to.body)?);
    let (p, q, e) = (pose.place(from.position), other.place(to.position), pose.turn(axis));
    Some((0..3).map(|i| e[i] * (q[i] - p[i])).sum::<f64>())
}

/// Smallest and largest of the finite values.
pub(super) fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.filter(|x| x.is_finite()).fold(None, |range, x| match range {
        None => Some([x, x]),
        Some([low, high]) => Some([low.min(x), high.max(x)]),
    })
}
