//! The curves that points follow, with the rollers and the faces on them.

use std::f64::consts::TAU;

use bksim_model::{Anchor, Curve, Joint};

use super::Sketch;
use crate::{Form, Role, Shape};

/// Points of a line that stands for a curve.
const N_POINTS: usize = 240;
/// Ends nearer to each other than this part of the curve's extent meet.
const MEETS: f64 = 1e-6;
/// Points of the circle of a roller.
const N_ROUND: usize = 48;

impl Sketch<'_> {
    /// The curve of every joint that follows one, and what touches it.
    pub(super) fn curves(&self) -> Vec<Shape> {
        let of_joint = |joint: &Joint| {
            let curve = &self.model().curves[joint.kind.curve()?.0];
            let follower = match joint.kind.second_curve() {
                Some(second) => Some(self.curve(joint.successor, &self.model().curves[second.0])),
                None if joint.kind.is_face() => Some(self.face(joint, curve)),
                None => (joint.kind.roller())
                    .or(curve.cam.as_ref().and_then(|cam| cam.roller))
                    .map(|distance| self.roller(joint, self.numbers.value(distance).abs())),
            };
            Some([Some(self.curve(joint.predecessor, curve)), follower])
        };
        self.model().joints.iter().filter_map(of_joint).flatten().flatten().collect()
    }

    /// A circle about the successor's point.
    fn roller(&self, joint: &Joint, radius: f64) -> Shape {
        let on_circle = |at: usize| {
            let (sin, cos) = (TAU * at as f64 / N_ROUND as f64).sin_cos();
            self.numbers.in_frame(joint.successor, [radius * cos, radius * sin, 0.0])
        };
        let points = (0..N_ROUND).map(on_circle).collect();
        let body = joint.successor.body.0;
        Shape { body, role: self.role_of(body), form: Form::Line { points, is_closed: true } }
    }

    /// A line to both sides of the successor's point, as long as the curve is wide.
    fn face(&self, joint: &Joint, curve: &Curve) -> Shape {
        let (points, _) = self.points_of(joint.predecessor, curve);
        let half = 0.5 * extent(&points);
        let axis = self.numbers.vector(&joint.axis);
        let end = |side: f64| self.numbers.in_frame(joint.successor, axis.map(|e| side * half * e));
        let points = vec![end(-1.0), end(1.0)];
        let body = joint.successor.body.0;
        Shape { body, role: self.role_of(body), form: Form::Line { points, is_closed: false } }
    }

    fn curve(&self, owner: Anchor, curve: &Curve) -> Shape {
        let (points, is_closed) = self.points_of(owner, curve);
        let form = Form::Line { points, is_closed };
        Shape { body: owner.body.0, role: Role::Guide, form }
    }

    /// Points along a curve in the frame of its owner, and whether its ends meet.
    fn points_of(&self, owner: Anchor, curve: &Curve) -> (Vec<[f64; 3]>, bool) {
        let numbers = &self.numbers;
        let [from, to] = curve.range.map(|end| numbers.value(end));
        let point = |k: usize| {
            let at = from + (to - from) * k as f64 / (N_POINTS - 1) as f64;
            let offset = curve.position.map(|e| numbers.value_at(e, (curve.parameter, at)));
            numbers.in_frame(owner, offset)
        };
        let mut points: Vec<[f64; 3]> = (0..N_POINTS).map(point).collect();
        let is_closed = distance(&points[0], &points[N_POINTS - 1]) <= MEETS * extent(&points);
        if is_closed {
            points.pop();
        }
        (points, is_closed)
    }
}

/// The largest difference of two points along an axis.
fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max)
}

/// The largest distance from the first point.
fn extent(points: &[[f64; 3]]) -> f64 {
    points.iter().map(|point| distance(point, &points[0])).fold(0.0, f64::max)
}
