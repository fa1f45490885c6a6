//! Markers: the points that have a name.

use super::Sketch;
use crate::{Attached, Marker, MarkerKind};

impl Sketch<'_> {
    /// The joints in file order, then the named points and the centre of mass of each body.
    pub(super) fn markers(&self) -> Vec<Marker> {
        let (model, numbers) = (self.model(), &self.numbers);
        let mut markers = Vec::new();
        for (joint_idx, joint) in model.joints.iter().enumerate() {
            let at = numbers.attached(joint.successor);
            let kind = MarkerKind::Joint(joint_idx);
            markers.push(Marker { name: joint.name.clone(), kind, at });
        }
        for (body_idx, body) in model.bodies.iter().enumerate() {
            let at = |position| Attached { body: body_idx, position };
            for point in &body.points {
                let name = format!("{}.{}", body.name, point.name);
                let at = at(numbers.vector(&point.position));
                markers.push(Marker { name, kind: MarkerKind::Point, at });
            }
            if body_idx > 0 {
                let at = at(numbers.vector(&body.com));
                markers.push(Marker { name: body.name.clone(), kind: MarkerKind::Mass, at });
            }
        }
        markers
    }
}
