//! Pins, welds, centres of mass, torsion springs.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use bksim_model::Joint;

use super::Sketch;
use super::looks::Look;
use crate::geometry::{
    Plane, Point, across3, along3, arc, block, circle, cross3, direction, distance3, scaled, unit3,
};
use crate::{Attached, Form, Role, Shape, Solid};

/// Radius of the sign of a centre of mass, radii of a pin.
const MASS: f64 = 1.0;
/// Half width of the square of a weld.
const WELD: f64 = 0.95;
/// Radius of the eyelet at the end of a spring.
const EYE: f64 = 0.6;
/// Inner and outer radius of a torsion spring.
const SPIRAL: [f64; 2] = [1.6, 4.2];
/// Number of its turns.
const TURNS: f64 = 1.75;
/// Half length of a pin in space.
const PIN_LENGTH: f64 = 1.8;
/// Sides of the prism that stands for its cylinder.
const FACETS: u32 = 24;
/// Half length and radius of the axles of a cross, radii of a pin.
const CROSS: f64 = 1.6;
const AXLE: f64 = 0.5;

impl Sketch<'_> {
    /// The pins of joints that turn, and the eyelets of springs.
    pub(super) fn pins(&self) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for joint in &self.model().joints {
            let ends = [joint.predecessor, joint.successor].map(|a| self.numbers.attached(a));
            let Look { n_pins, is_cross, .. } = Look::of(joint.kind);
            if let (true, Some(second)) = (is_cross, joint.kind.second_axis()) {
                shapes.extend(self.cross(joint, ends, self.numbers.vector(&second)));
                continue;
            }
            shapes.extend(ends[2 - n_pins..].iter().map(|&at| self.pin(joint, at)));
        }
        shapes.extend(self.eyes());
        shapes
    }

    /// Small circles where springs and dampers are attached to moving bodies, unless a pin is
    /// there.
    fn eyes(&self) -> Vec<Shape> {
        let model = self.model();
        let joints = model.joints.iter().flat_map(|joint| [joint.predecessor, joint.successor]);
        let pins: Vec<Attached> = joints.map(|anchor| self.numbers.attached(anchor)).collect();
        let mut shapes = Vec::new();
        for load in &model.loads {
            let (Some(ends), Some(_)) = (load.kind.ends(), load.kind.spring()) else { continue };
            for at in ends.map(|anchor| self.numbers.attached(anchor)) {
                if at.body > 0 && !pins.contains(&at) {
                    shapes.push(self.round(at, Role::Pin, EYE * self.pin));
                }
            }
        }
        shapes
    }

    /// The two axles of a universal joint, each in the fork that bears it.
    fn cross(&self, joint: &Joint, ends: [Attached; 2], second: [f64; 3]) -> Vec<Shape> {
        let first = self.numbers.axis(joint, ends[0].body);
        let second = self.numbers.on_anchor(joint.successor, second);
        let axle = |(at, axis): (Attached, [f64; 3])| {
            let axis = unit3(axis)?;
            let reach = CROSS * self.pin;
            let ends = [-reach, reach].map(|along| along3(at.position, along, axis));
            let form = Form::Rod { ends, radius: AXLE * self.pin };
            Some(Shape { body: at.body, role: Role::Pin, form })
        };
        [(ends[0], first), (ends[1], second)].into_iter().filter_map(axle).collect()
    }

    /// A circle; in space, a short cylinder along the axis of rotation.
    fn pin(&self, joint: &Joint, at: Attached) -> Shape {
        if self.is_planar() || !Look::of(joint.kind).has_axle {
            return self.round(at, Role::Pin, self.pin);
        }
        let plane = self.turning_plane(joint, at);
        let axis = cross3(plane.u, plane.v);
        let ring: Vec<Point> = (0..FACETS)
            .map(|i| scaled(self.pin, direction(TAU * f64::from(i) / f64::from(FACETS))))
            .collect();
        let half = PIN_LENGTH * self.pin;
        let place = |[x, y, z]: [f64; 3]| along3(plane.lift([x, y]), z, axis);
        let form = Form::Solid(Solid::prism(&ring, [-half, half], place));
        Shape { body: at.body, role: Role::Pin, form }
    }

    /// A circle, in space a ball.
    fn round(&self, at: Attached, role: Role, radius: f64) -> Shape {
        if !self.is_planar() {
            return Shape {
                body: at.body,
                role,
                form: Form::Rod { ends: [at.position; 2], radius },
            };
        }
        let plane = Plane { origin: at.position, ..Plane::XY };
        Shape::region(at.body, role, &plane, &[circle([0.0; 2], radius)])
    }

    /// Welds between moving bodies: solid, where pins are open.
    pub(super) fn welds(&self) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for joint in &self.model().joints {
            let ends = [joint.predecessor, joint.successor].map(|a| self.numbers.attached(a));
            // A weld to the ground has a wall.
            let is_weld = joint.kind.is_weld();
            if !is_weld || ends.iter().any(|end| end.body == 0) {
                continue;
            }
            let half = WELD * self.pin;
            shapes.push(if self.is_planar() {
                let plane = Plane { origin: ends[1].position, ..Plane::XY };
                let ring = block([0.0; 2], [1.0, 0.0], [half, half]);
                Shape::region(ends[1].body, Role::Weld, &plane, &[ring])
            } else {
                self.round(ends[1], Role::Weld, half)
            });
        }
        shapes
    }

    /// The plane across the axis of a joint; a revolute has the same axis in both its bodies.
    pub(super) fn turning_plane(&self, joint: &Joint, at: Attached) -> Plane {
        let stated = match joint.kind {
            kind if Look::of(kind).has_axle => unit3(self.numbers.axis(joint, at.body)),
            _ => None,
        };
        self.plane_across(at.position, stated.unwrap_or([0.0, 0.0, 1.0]))
    }

    /// The plane through a point across an axis.
    pub(super) fn plane_across(&self, origin: [f64; 3], axis: [f64; 3]) -> Plane {
        if self.is_planar() {
            return Plane { origin, ..Plane::XY };
        }
        let u = across3(axis, [0.0, 0.0, 1.0]);
        Plane { origin, u, v: cross3(axis, u) }
    }

    /// The signs of centres of mass, where no pin hides them.
    pub(super) fn masses(&self) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for body in 1..self.model().bodies.len() {
            let Some(com) = self.com(body) else { continue };
            let attached = &self.attached[body];
            let is_hidden = attached.iter().any(|&p| distance3(p, com) < 2.0 * self.pin);
            // A bob shows its centre of mass already.
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
            // Quarters without overlap, so that no order of painting hides one.
            for (role, first) in [(Role::MassLight, FRAC_PI_2), (Role::MassDark, 0.0)] {
                let rings = [quarter(first), quarter(first + PI)];
                shapes.push(Shape::region(body, role, &plane, &rings));
            }
        }
        shapes
    }

    /// Spirals around joints with a torsion spring.
    pub(super) fn torsion_springs(&self) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for load in &self.model().loads {
            let (Some((joint, motion_idx)), Some([stiffness, ..])) =
                (load.kind.joint_motion(), load.kind.spring())
            else {
                continue;
            };
            let joint = &self.model().joints[joint.0];
            // A stiffness of zero is a damper in the bearing: it has no symbol.
            if !joint.kind.turns(motion_idx) || self.model().pool.is_zero(stiffness) {
                continue;
            }
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
