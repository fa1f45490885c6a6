//! Pins, centres of mass, torsion springs.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use bksim_mbs::model::{Joint, JointKind, LoadKind};

use super::Sketch;
use crate::geometry::{
    Plane, Point, across3, along3, arc, circle, cross3, direction, distance3, scaled, unit3,
};
use crate::{Attached, Form, Role, Shape};

/// Radius of the sign of a centre of mass, radii of a pin.
const MASS: f64 = 1.0;
/// Radius of the eye at the end of a spring.
const EYE: f64 = 0.6;
/// Inner and outer radius of a torsion spring.
const SPIRAL: [f64; 2] = [1.6, 4.2];
/// Its turns.
const TURNS: f64 = 1.75;
/// Half length of a pin in space.
const PIN_LENGTH: f64 = 2.4;

impl Sketch<'_> {
    /// The pins of joints that turn.
    pub(super) fn pins(&self) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for joint in &self.model().joints {
            let ends = [joint.predecessor, joint.successor].map(|a| self.numbers.attached(a));
            let pinned = match joint.kind {
                JointKind::Revolute | JointKind::PinInSlot => &ends[1..],
                JointKind::Link { .. } => &ends[..],
                JointKind::Prismatic { .. } | JointKind::Weld { .. } => &[],
            };
            for &at in pinned {
                shapes.extend(self.pin(joint, at));
            }
        }
        shapes.extend(self.eyes());
        shapes
    }

    /// Small circles where springs and dampers are held by bodies that move, unless a pin is there.
    fn eyes(&self) -> Vec<Shape> {
        let model = self.model();
        let joints = model.joints.iter().flat_map(|joint| [joint.predecessor, joint.successor]);
        let pins: Vec<Attached> = joints.map(|anchor| self.numbers.attached(anchor)).collect();
        let mut shapes = Vec::new();
        for load in &model.loads {
            let LoadKind::Spring { a, b, .. } = load.kind else { continue };
            for at in [a, b].map(|anchor| self.numbers.attached(anchor)) {
                if at.body > 0 && !pins.contains(&at) {
                    let plane = Plane { origin: at.position, ..Plane::XY };
                    let ring = circle([0.0; 2], EYE * self.pin);
                    shapes.push(Shape::region(at.body, Role::Pin, &plane, &[ring]));
                }
            }
        }
        shapes
    }

    /// A circle; in space, on the axis that it turns about.
    fn pin(&self, joint: &Joint, at: Attached) -> Vec<Shape> {
        let plane = self.turning_plane(joint, at);
        let ring = circle([0.0; 2], self.pin);
        let mut shapes = vec![Shape::region(at.body, Role::Pin, &plane, &[ring])];
        if !self.is_planar() && joint.kind == JointKind::Revolute {
            let axis = cross3(plane.u, plane.v);
            let end = |side: f64| along3(at.position, side * PIN_LENGTH * self.pin, axis);
            let form = Form::Line { points: vec![end(-1.0), end(1.0)], is_closed: false };
            shapes.push(Shape { body: at.body, role: Role::Pin, form });
        }
        shapes
    }

    /// The plane across the axis of a joint; a revolute has the same axis in both its bodies.
    fn turning_plane(&self, joint: &Joint, at: Attached) -> Plane {
        if self.is_planar() {
            return Plane { origin: at.position, ..Plane::XY };
        }
        let stated = match joint.kind {
            JointKind::Revolute => unit3(self.numbers.vector(&joint.axis)),
            _ => None,
        };
        let axis = stated.unwrap_or([0.0, 0.0, 1.0]);
        let u = across3(axis, [0.0, 0.0, 1.0]);
        Plane { origin: at.position, u, v: cross3(axis, u) }
    }

    /// The signs of centres of mass, where no pin hides them.
    pub(super) fn masses(&self) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for body in 1..self.model().bodies.len() {
            let Some(com) = self.com(body) else { continue };
            let attached = &self.attached[body];
            let is_hidden = attached.iter().any(|&p| distance3(p, com) < 2.0 * self.pin);
            // A bob says as much.
            if is_hidden || self.is_bob(body) {
                continue;
            }
            let mut points = vec![com];
            points.extend(attached);
            let plane = self.plane_through(body, &points).unwrap_or(Plane::XY);
            let plane = Plane { origin: com, ..plane };
            let quarter = |from: f64| {
                let mut ring = arc([0.0; 2], MASS * self.pin, from, from + FRAC_PI_2);
                ring.push([0.0; 2]);
                ring
            };
            // Beside each other, so that no order of painting hides one.
            for (role, first) in [(Role::MassLight, FRAC_PI_2), (Role::MassDark, 0.0)] {
                let rings = [quarter(first), quarter(first + PI)];
                shapes.push(Shape::region(body, role, &plane, &rings));
            }
        }
        shapes
    }

    /// Spirals around joints that a spring turns back.
    pub(super) fn torsion_springs(&self) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for load in &self.model().loads {
            let LoadKind::Torsion { joint, stiffness, .. } = load.kind else { continue };
            // A stiffness of zero is a damper in the bearing: nothing to see.
            if self.model().pool.is_zero(stiffness) {
                continue;
            }
            let joint = &self.model().joints[joint.0];
            let at = self.numbers.attached(joint.successor);
            let [inner, outer] = SPIRAL.map(|x| x * self.pin);
            let n = 72;
            let point = |i: u32| {
                let part = f64::from(i) / f64::from(n);
                scaled(inner + (outer - inner) * part, direction(TAU * TURNS * part))
            };
            let points: Vec<Point> = (0..=n).map(point).collect();
            let plane = self.turning_plane(joint, at);
            shapes.push(Shape::line(at.body, Role::Spring, &plane, &points));
        }
        shapes
    }
}
