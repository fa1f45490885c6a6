//! The curves that points follow.

use bksim_model::{Curve, Joint, JointKind};

use super::Sketch;
use crate::{Form, Role, Shape};

/// Points of a line that stands for a curve.
const N_POINTS: usize = 240;
/// Ends nearer to each other than this part of the curve's extent meet.
const MEETS: f64 = 1e-6;

impl Sketch<'_> {
    /// The curve of every joint that follows one.
    pub(super) fn curves(&self) -> Vec<Shape> {
        let of_joint = |joint: &Joint| match joint.kind {
            JointKind::PointOnCurve { curve } => {
                Some(self.curve(joint, &self.model().curves[curve.0]))
            }
            _ => None,
        };
        self.model().joints.iter().filter_map(of_joint).collect()
    }

    fn curve(&self, joint: &Joint, curve: &Curve) -> Shape {
        let numbers = &self.numbers;
        let [from, to] = curve.range.map(|end| numbers.value(end));
        let point = |k: usize| {
            let at = from + (to - from) * k as f64 / (N_POINTS - 1) as f64;
            let offset = curve.position.map(|e| numbers.value_at(e, (curve.parameter, at)));
            numbers.in_frame(joint.predecessor, offset)
        };
        let mut points: Vec<[f64; 3]> = (0..N_POINTS).map(point).collect();
        let distance =
            |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max);
        let extent = points.iter().map(|point| distance(point, &points[0])).fold(0.0, f64::max);
        let is_closed = distance(&points[0], &points[N_POINTS - 1]) <= MEETS * extent;
        if is_closed {
            points.pop();
        }
        let form = Form::Line { points, is_closed };
        Shape { body: joint.predecessor.body.0, role: Role::Guide, form }
    }
}
