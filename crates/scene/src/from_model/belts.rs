//! Belts around any number of wheels: the wheels, the belt on each of them, and the strands between them.

use std::f64::consts::TAU;

use bksim_mbs::belt::ends;
use bksim_model::Belt;
use bksim_sim::belt::Way;

use super::Sketch;
use super::wheels::{fine_circle, position_on};
use crate::geometry::{Plane, arc};
use crate::{Attached, Form, Role, Shape, Span, SpanKind};

/// A belt where the start puts its wheels.
struct Laid {
    /// Centres and radii in the world, m; radii below zero where the belt turns right.
    wheels: Vec<([f64; 2], f64)>,
    way: Way,
}

impl Sketch<'_> {
    /// Discs of the wheels, and the belt around each, which stays with the body that carries the wheel.
    pub(super) fn belts(&self) -> Vec<Shape> {
        let model = self.model();
        let mut shapes = Vec::new();
        for belt in &model.belts {
            for wheel in &belt.wheels {
                let at = self.numbers.attached(ends(model, wheel)[0]);
                let radius = self.numbers.value(wheel.radius).abs();
                if radius > 0.0 && !self.has_own_shape(at.body) {
                    let plane = Plane { origin: at.position, ..Plane::XY };
                    let role = self.role_of(at.body);
                    shapes.push(Shape::region(at.body, role, &plane, &[fine_circle(radius)]));
                }
            }
            let Some(laid) = self.laid(belt) else { continue };
            for (k, wheel) in belt.wheels.iter().enumerate() {
                let carrier = ends(model, wheel)[1].body.0;
                let Some(pose) = self.numbers.first_pose(carrier) else { continue };
                // From where the strand before comes to the wheel.
                let (center, radius) = laid.wheels[k];
                let n = laid.way.strands.len();
                let [_, [x, y]] = laid.way.strands[(k + n - 1) % n];
                let from = (y - center[1]).atan2(x - center[0]);
                let to = from + radius.signum() * laid.way.wraps[k].min(TAU);
                let points = arc(center, radius.abs(), from, to);
                let points = points.iter().map(|&[x, y]| position_on(pose, [x, y, 0.0])).collect();
                let form = Form::Line { points, is_closed: false };
                shapes.push(Shape { body: carrier, role: Role::Link, form });
            }
        }
        shapes
    }

    /// The strands, between the bodies that carry the wheels.
    pub(super) fn strands(&self) -> Vec<Span> {
        let model = self.model();
        let mut spans = Vec::new();
        for belt in &model.belts {
            let Some(laid) = self.laid(belt) else { continue };
            let n = belt.wheels.len();
            for (k, touching) in laid.way.strands.iter().enumerate() {
                let end = |wheel: usize, [x, y]: [f64; 2]| {
                    let body = ends(model, &belt.wheels[wheel % n])[1].body.0;
                    let pose = self.numbers.first_pose(body)?;
                    Some(Attached { body, position: position_on(pose, [x, y, 0.0]) })
                };
                if let (Some(from), Some(to)) = (end(k, touching[0]), end(k + 1, touching[1])) {
                    let name = belt.name.clone();
                    spans.push(Span { name, ends: [from, to], kind: SpanKind::Link });
                }
            }
        }
        spans
    }

    /// A belt at the first instant, if that is known.
    fn laid(&self, belt: &Belt) -> Option<Laid> {
        let wheel = |wheel| {
            let carrier = self.numbers.attached(ends(self.model(), wheel)[1]);
            let [x, y, _] = self.numbers.first_pose(carrier.body)?.place(carrier.position);
            Some(([x, y], self.numbers.value(wheel.radius)))
        };
        let wheels = belt.wheels.iter().map(wheel).collect::<Option<Vec<_>>>()?;
        let way = Way::around(&wheels).ok()?;
        Some(Laid { wheels, way })
    }
}
