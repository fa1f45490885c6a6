//! The shapes that a body of the model has as solids.

use bksim_model::SolidForm;

use super::Sketch;
use super::numbers::Numbers;
use crate::geometry::{Point, circle};
use crate::{Form, Shape, Solid};

impl Sketch<'_> {
    /// The solids of a body.
    pub(super) fn solids(&self, body: usize) -> Vec<Shape> {
        let role = self.role_of(body);
        forms(&self.numbers, body).into_iter().map(|form| Shape { body, role, form }).collect()
    }
}

/// The forms of a body's solids, in its frame.
pub(super) fn forms(numbers: &Numbers<'_>, body: usize) -> Vec<Form> {
    let prism = |ring: &[Point], thickness: f64, solid: &bksim_model::Solid| {
        let half = 0.5 * thickness;
        Form::Solid(Solid::prism(ring, [-half, half], |p| numbers.on_body(solid, p)))
    };
    let form = |solid: &bksim_model::Solid| match &solid.form {
        SolidForm::Box(size) => {
            let [x, y, z] = numbers.vector(size).map(|length| 0.5 * length);
            prism(&[[-x, -y], [x, -y], [x, y], [-x, y]], 2.0 * z, solid)
        }
        SolidForm::Cylinder { radius, length } => {
            prism(&circle([0.0; 2], numbers.value(*radius)), numbers.value(*length), solid)
        }
        SolidForm::Sphere(radius) => {
            let centre = numbers.vector(&solid.position);
            Form::Rod { ends: [centre; 2], radius: numbers.value(*radius) }
        }
        SolidForm::Plate { corners, thickness } => {
            let ring: Vec<Point> =
                corners.iter().map(|corner| corner.map(|e| numbers.value(e))).collect();
            prism(&ring, numbers.value(*thickness), solid)
        }
        SolidForm::Mesh(mesh) => {
            let corners = mesh.corners.iter().map(|&p| numbers.on_body(solid, p)).collect();
            Form::Solid(Solid::new(corners, mesh.faces.iter().map(|face| face.to_vec()).collect()))
        }
    };
    numbers.model.bodies[body].solids.iter().map(form).collect()
}
