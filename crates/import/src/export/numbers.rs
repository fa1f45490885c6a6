//! [`Numbers`]: values of a model at its parameters.

use bksim_model::{Anchor, FixedTurn, Joint, Model, SolidForm};

use crate::shapes::Solid;
use crate::spatial::{Inertia, Pose, Rotation, Vector, of_point, sub};

use super::parts::Report;

/// Numbers of a model.
pub(super) struct Numbers<'m>(pub(super) &'m Model);

impl Numbers<'_> {
    /// The value of an expression that depends on parameters alone.
    pub(super) fn value(&self, e: bksim_expr::Expr) -> Option<f64> {
        let of = |symbol| {
            let known = self.0.parameters.iter().find(|parameter| parameter.symbol == symbol);
            known.map(|parameter| parameter.value)
        };
        self.0.pool.evaluate(e, &of).ok().filter(|value| value.is_finite())
    }

    pub(super) fn vector(&self, vector: bksim_model::Vector) -> Option<Vector> {
        let [x, y, z] = vector.map(|part| self.value(part));
        Some([x?, y?, z?])
    }

    fn turned(&self, turns: &[FixedTurn]) -> Option<Rotation> {
        turns.iter().try_fold(Rotation::NONE, |turned, turn| {
            Some(turned.then(Rotation::about(self.vector(turn.axis)?, self.value(turn.angle)?)))
        })
    }

    /// The frame of an anchor in its body.
    pub(super) fn frame(&self, anchor: Anchor) -> Option<Pose> {
        let Some(point) = anchor.point else { return Some(Pose::NONE) };
        let point = &self.0.bodies[anchor.body.0].points[point.0];
        Some(Pose { at: self.vector(point.position)?, turn: self.turned(&point.orientation)? })
    }

    /// The frames of a joint in both bodies, equal where all its motions are zero.
    pub(super) fn frames(&self, joint: &Joint) -> Option<[Pose; 2]> {
        let fixed = match joint.kind.kept_angle() {
            Some(angle) => Rotation::about([0.0, 0.0, 1.0], self.value(angle)?),
            None => Rotation::NONE,
        };
        let first = self.frame(joint.predecessor)?;
        let second = self.frame(joint.successor)?;
        let aligned = second.turn.then(self.turned(&joint.alignment)?);
        let first = Pose { turn: first.turn.then(fixed), ..first };
        Some([first, Pose { turn: aligned, ..second }])
    }

    /// Inertia about the centre of mass; a flat body has its two other moments as a plate has them.
    pub(super) fn inertia(&self, body: usize, is_planar: bool) -> Option<Inertia> {
        let body = &self.0.bodies[body];
        let (mass, com) = (self.value(body.mass)?, self.vector(body.com)?);
        let [[xx, yy, zz], [xy, yz, zx]] =
            [self.vector(body.inertia.moments)?, self.vector(body.inertia.products)?];
        let mut tensor = [xx, yy, zz, xy, yz, zx];
        if let Some(point) = body.inertia.about {
            let arm = sub(self.vector(body.points[point.0].position)?, com);
            let moved = of_point(mass, arm);
            tensor.iter_mut().zip(moved).for_each(|(entry, moved)| *entry -= moved);
        }
        if is_planar {
            tensor = [tensor[2] / 2.0, tensor[2] / 2.0, tensor[2], 0.0, 0.0, 0.0];
        }
        Some(Inertia { mass, com, tensor })
    }

    pub(super) fn shapes(&self, body: usize, report: &mut Report) -> Vec<(Solid, Pose)> {
        let body = &self.0.bodies[body];
        let mut shapes = Vec::new();
        for solid in &body.solids {
            let form = match &solid.form {
                SolidForm::Box(size) => {
                    self.vector(*size).map(|size| Solid::Box { half: size.map(|side| side / 2.0) })
                }
                SolidForm::Cylinder { radius, length } => self
                    .value(*radius)
                    .zip(self.value(*length))
                    .map(|(radius, length)| Solid::Cylinder { radius, half: length / 2.0 }),
                SolidForm::Sphere(radius) => {
                    self.value(*radius).map(|radius| Solid::Sphere { radius })
                }
                SolidForm::Plate { .. } | SolidForm::Mesh(_) => None,
            };
            let place = self.vector(solid.position).zip(self.turned(&solid.orientation));
            match form.zip(place) {
                Some((form, (at, turn))) => shapes.push((form, Pose { at, turn })),
                None => report.leave_out(format!("a shape of body {}", body.name), &body.span),
            }
        }
        shapes
    }
}
