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
                // A body without mass has its name at the middle of its points.
                let is_massless = numbers.value(body.mass) == 0.0;
                let middle = is_massless.then(|| middle(&self.marked_points(body_idx))).flatten();
                let at = at(middle.unwrap_or_else(|| numbers.vector(&body.com)));
                markers.push(Marker { name: body.name.clone(), kind: MarkerKind::Mass, at });
            }
        }
        markers
    }

    /// Points that joints and loads are attached to, or that have names.
    fn marked_points(&self, body: usize) -> Vec<[f64; 3]> {
        let named = self.model().bodies[body].points.iter();
        let named = named.map(|point| self.numbers.vector(&point.position));
        self.attached[body].iter().copied().chain(named).collect()
    }
}

/// The middle of the box around points.
fn middle(points: &[[f64; 3]]) -> Option<[f64; 3]> {
    let first = *points.first()?;
    let ends = points.iter().fold((first, first), |(low, high), p| {
        (std::array::from_fn(|i| low[i].min(p[i])), std::array::from_fn(|i| high[i].max(p[i])))
    });
    Some(std::array::from_fn(|i| 0.5 * (ends.0[i] + ends.1[i])))
}
