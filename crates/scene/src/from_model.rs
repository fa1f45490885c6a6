//! From a model to its scene.

use bksim_mbs::model::{Anchor, Model, Space, Vector};

use crate::{Attached, Form, Marker, MarkerKind, Role, Scene, Shape};

impl Scene {
    /// The shapes of a model at these values of its parameters: the outlines that it has, and symbols
    /// for the rest.
    ///
    /// # Panics
    /// If `parameters` are not as many as in the model.
    pub fn of(model: &Model, parameters: &[f64]) -> Self {
        assert_eq!(parameters.len(), model.parameters.len(), "one value per parameter");
        let numbers = Numbers { model, parameters };
        let mut scene = Self {
            is_planar: model.space == Space::Planar,
            bodies: model.bodies.iter().map(|body| body.name.clone()).collect(),
            pin: 0.01,
            ..Self::default()
        };
        for (joint_idx, joint) in model.joints.iter().enumerate() {
            let at = numbers.attached(joint.successor);
            let kind = MarkerKind::Joint(joint_idx);
            scene.markers.push(Marker { name: joint.name.clone(), kind, at });
        }
        for (body_idx, body) in model.bodies.iter().enumerate().skip(1) {
            let com = numbers.vector(&body.com);
            let mut points: Vec<[f64; 3]> = vec![com, [0.0; 3]];
            points.extend(body.points.iter().map(|point| numbers.vector(&point.position)));
            let form = Form::Line { points, is_closed: false };
            let role = Role::Body(u8::try_from(body_idx % 250).unwrap_or(0));
            scene.shapes.push(Shape { body: body_idx, role, form });
        }
        scene
    }
}

/// Values of a model's expressions.
struct Numbers<'a> {
    model: &'a Model,
    parameters: &'a [f64],
}

impl Numbers<'_> {
    fn vector(&self, vector: &Vector) -> [f64; 3] {
        let value = |symbol| {
            let mut known = self.model.parameters.iter().zip(self.parameters);
            known.find(|(parameter, _)| parameter.symbol == symbol).map(|(_, &value)| value)
        };
        vector.map(|e| self.model.pool.evaluate(e, &value).unwrap_or(0.0))
    }

    fn attached(&self, anchor: Anchor) -> Attached {
        let body = &self.model.bodies[anchor.body.0];
        let position = anchor.point.map(|point| self.vector(&body.points[point.0].position));
        Attached { body: anchor.body.0, position: position.unwrap_or_default() }
    }
}
