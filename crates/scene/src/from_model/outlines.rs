//! Outlines that touch: discs, rings, edges and closed outlines of contacts, on bodies without a shape of their own; balls, bowls
//! and planes in space.

use bksim_model::{EdgesForm, Shape as Outline};

use super::Sketch;
use super::wheels::fine_circle;
use crate::geometry::{Plane, across3, cross3, distance3};
use crate::{Form, Role, Shape};

/// Half the side of the square that stands for a plane, radii of a pin.
const PLANE: f64 = 30.0;

impl Sketch<'_> {
    /// The shapes that contacts are between, each once.
    pub(super) fn outlines(&self) -> Vec<Shape> {
        let mut shapes: Vec<Shape> = Vec::new();
        for outline in self.model().contacts.iter().flat_map(|pair| &pair.shapes) {
            let shape = self.outline_of_contact(outline);
            shapes.extend(shape.filter(|shape| !shapes.contains(shape)));
        }
        shapes
    }

    /// True of a disc or a closed outline.
    fn is_filled(&self, outline: &Outline) -> bool {
        match outline {
            Outline::Round(round) | Outline::Ball(round) => self.numbers.value(round.radius) > 0.0,
            // Curves are drawn with their joints.
            Outline::Ring(_)
            | Outline::Bowl(_)
            | Outline::Points(_)
            | Outline::Plane(_)
            | Outline::Curve { .. } => false,
            Outline::Edges { form, .. } => *form == EdgesForm::Outline,
        }
    }

    /// True of a closed outline, and of a disc in which all joints of its body are.
    pub(super) fn is_whole(&self, outline: &Outline) -> bool {
        let (Outline::Round(round) | Outline::Ball(round)) = outline else {
            return self.is_filled(outline);
        };
        let radius = self.numbers.value(round.radius);
        let center = self.numbers.attached(round.center).position;
        let is_inside = |&point: &[f64; 3]| distance3(point, center) <= radius;
        self.is_filled(outline) && self.attached[round.center.body.0].iter().all(is_inside)
    }

    fn outline_of_contact(&self, outline: &Outline) -> Option<Shape> {
        let body = outline.anchors().first()?.body.0;
        let role = self.role_of(body);
        let line = |points: Vec<[f64; 3]>, is_closed: bool| {
            Some(Shape { body, role, form: Form::Line { points, is_closed } })
        };
        let has_own = self.has_own_shape(body);
        match outline {
            Outline::Curve { .. } | Outline::Points(_) => None,
            Outline::Ball(ball) => {
                let radius = self.numbers.value(ball.radius);
                let center = self.numbers.attached(ball.center).position;
                let form = Form::Rod { ends: [center; 2], radius };
                (!has_own).then_some(Shape { body, role, form })
            }
            Outline::Bowl(bowl) => {
                // The rim of the lower half.
                let radius = self.numbers.value(bowl.radius).abs();
                let [x, y, z] = self.numbers.attached(bowl.center).position;
                let points = fine_circle(radius).into_iter();
                line(points.map(|[u, v]| [x + u, y + v, z]).collect(), true)
            }
            // Bodies with shapes of their own show where they touch.
            Outline::Plane(_) if has_own => None,
            Outline::Plane(plane) => {
                let origin = self.numbers.attached(plane.anchor).position;
                let normal =
                    self.numbers.on_anchor(plane.anchor, self.numbers.vector(&plane.normal));
                let u = across3(normal, [0.0, 1.0, 0.0]);
                let v = cross3(normal, u);
                let half = PLANE * self.pin;
                let corners = [[half, half], [-half, half], [-half, -half], [half, -half]];
                line(Plane { origin, u, v }.lifted(&corners), true)
            }
            Outline::Round(round) | Outline::Ring(round) => {
                let radius = self.numbers.value(round.radius).abs();
                let origin = self.numbers.attached(round.center).position;
                let plane = Plane { origin, ..Plane::XY };
                let is_ring = matches!(outline, Outline::Ring(_));
                if is_ring {
                    let [x, y, z] = origin;
                    let points = fine_circle(radius).into_iter();
                    return line(points.map(|[u, v]| [x + u, y + v, z]).collect(), true);
                }
                let is_drawn = radius > 0.0 && !has_own;
                is_drawn.then(|| Shape::region(body, role, &plane, &[fine_circle(radius)]))
            }
            Outline::Edges { corners, form } => {
                let points: Vec<[f64; 3]> =
                    corners.iter().map(|&corner| self.numbers.attached(corner).position).collect();
                if *form != EdgesForm::Outline || role == Role::Ground {
                    return line(points, *form == EdgesForm::Outline);
                }
                let corners = points.iter().rev().map(|&[x, y, _]| [x, y]).collect();
                (!has_own).then(|| Shape::region(body, role, &Plane::XY, &[corners]))
            }
        }
    }
}
