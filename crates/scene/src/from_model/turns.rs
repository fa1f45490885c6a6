//! Drives and torques: arrows about joints, as textbooks draw a driven crank and a torque.
//!
//! The arrow of a drive points to where the angle or position grows. That of a torque turns in the sense of the torque at
//! the start of the motion, or to where the angle grows if that depends on the motion; [`Turn`] has what turns it over.

use std::f64::consts::{FRAC_PI_2, PI};

use bksim_model::{BodyId, Joint, JointId, LoadId, LoadKind, MotionKind};
use bksim_sim::load_forces::TorqueAxis;

use super::Sketch;
use crate::geometry::{
    Plane, Point, add, arc, circle, cross3, direction, left, scaled, sub3, unit3,
};
use crate::{Attached, Form, Role, Shape, Turn};

/// Radius of the arrow about a driven joint, radii of a pin: outside of a torsion spring.
const DRIVE: f64 = 5.2;
/// Radius of the arrow of a torque.
const TORQUE: f64 = 6.6;
/// Radius of the motor about its pin.
const MOTOR: f64 = 2.3;
/// Length and half width of the head of an arrow.
const HEAD: [f64; 2] = [1.9, 0.85];
/// Half of the angle of an arrow about a joint.
const HALF_TURN: f64 = 0.36 * PI;

impl Sketch<'_> {
    /// The signs of drives.
    pub(super) fn drives(&self) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for drive in &self.model().drives {
            let joint = &self.model().joints[drive.joint.0];
            if !is_rotation(joint, drive.motion_idx) {
                shapes.extend(self.pushed(drive.joint));
                continue;
            }
            let (at, plane) = self.holder(joint);
            let points = plane.lifted(&circle([0.0; 2], MOTOR * self.pin));
            let form = Form::Line { points, is_closed: true };
            shapes.push(Shape { body: at.body, role: Role::Drive, form });
            let side = self.open_side(joint);
            shapes.extend(self.turned(at.body, Role::Drive, &plane, (DRIVE, 1.0), side));
        }
        shapes
    }

    /// The signs of torques, two shapes for each, and what turns them over.
    pub(super) fn torques(&self) -> (Vec<Shape>, Vec<Turn>) {
        let (mut shapes, mut turns) = (Vec::new(), Vec::new());
        for (load_idx, load) in self.model().loads.iter().enumerate() {
            let of_motion =
                load.kind.joint_motion().filter(|_| load.kind.stated_effort().is_some());
            let joint = match (load.kind.torque(), of_motion) {
                (Some((on, from, _)), _) => self.joint_between(from, on),
                (_, Some((joint, motion_idx))) => {
                    let joint = &self.model().joints[joint.0];
                    Some(joint).filter(|joint| is_rotation(joint, motion_idx))
                }
                _ => continue,
            };
            let (body, plane, side) = if let Some(joint) = joint {
                let (at, plane) = self.holder(joint);
                (at.body, plane, self.open_side(joint))
            } else {
                let Some((on, _, vector)) = load.kind.torque() else { continue };
                let Some(com) = self.com(on.0) else { continue };
                let axis = unit3(self.numbers.vector(&vector)).unwrap_or([0.0, 0.0, 1.0]);
                (on.0, self.plane_across(com, axis), FRAC_PI_2)
            };
            let about = joint.map(|joint| self.numbers.axis(joint, joint.predecessor.body.0));
            let sense = self.sense(&load.kind, about);
            let sign = self.turned(body, Role::Torque, &plane, (TORQUE, sense), side);
            if !sign.iter().all(Shape::is_finite) {
                continue;
            }
            shapes.extend(sign);
            let axis = about.unwrap_or_else(|| cross3(plane.u, plane.v));
            let middle = plane.lift(direction(side));
            turns.push(Turn {
                about: TorqueAxis { load: LoadId(load_idx), body: BodyId(body), axis },
                line: [plane.origin, sub3(middle, plane.origin)],
                is_over: sense < 0.0,
            });
        }
        (shapes, turns)
    }

    /// One where a torque turns a joint to where its angle grows at the start, else minus one.
    fn sense(&self, load: &LoadKind, axis: Option<[f64; 3]>) -> f64 {
        let start = (self.model().time, self.model().solve.t_start);
        let value = match (load.torque(), axis) {
            (Some((_, _, vector)), Some(axis)) => {
                let vector = vector.map(|e| self.numbers.value_at(e, start));
                vector.iter().zip(axis).map(|(a, b)| a * b).sum()
            }
            _ => load.stated_effort().map_or(1.0, |value| self.numbers.value_at(value, start)),
        };
        if value < 0.0 { -1.0 } else { 1.0 }
    }

    /// The first body of a joint, and the plane across the joint's axis there.
    pub(super) fn holder(&self, joint: &Joint) -> (Attached, Plane) {
        let at = self.numbers.attached(joint.predecessor);
        (at, self.turning_plane(joint, at))
    }

    /// The revolute joint between two bodies, if there is one.
    fn joint_between(&self, from: BodyId, on: BodyId) -> Option<&Joint> {
        self.model().joints.iter().find(|joint| {
            let ends = [joint.predecessor.body, joint.successor.body];
            joint.kind.is_pin() && (ends == [from, on] || ends == [on, from])
        })
    }

    /// The angle of the side on which no support stands.
    fn open_side(&self, joint: &Joint) -> f64 {
        let [at, other] =
            [joint.predecessor, joint.successor].map(|anchor| self.numbers.attached(anchor));
        if at.body != 0 || !self.is_planar() {
            return FRAC_PI_2;
        }
        let [_, up] = self.free_side(at, other);
        up.signum() * FRAC_PI_2
    }

    /// An arrow about the origin of a plane, anticlockwise for a sense of one and clockwise for minus one, `side` being
    /// the angle of its middle.
    fn turned(
        &self,
        body: usize,
        role: Role,
        plane: &Plane,
        (radius, sense): (f64, f64),
        side: f64,
    ) -> Vec<Shape> {
        let radius = radius * self.pin;
        let end = side + sense * HALF_TURN;
        let shaft = arc([0.0; 2], radius, side - sense * HALF_TURN, end);
        // The head lies along the arc's chord over its length.
        let tip = end + sense * 0.5 * HEAD[0] * self.pin / radius;
        let along = scaled(sense, left(direction(tip)));
        let foot = scaled(radius, direction(end));
        vec![Shape::line(body, role, plane, &shaft), self.head(body, role, plane, foot, along)]
    }

    /// An arrow along a rail, next to the slider that is driven on it.
    fn pushed(&self, joint: JointId) -> Vec<Shape> {
        let rail = self.rails[joint.0].as_ref();
        let Some((rail, slider)) = rail.and_then(|rail| Some((rail, rail.slider?))) else {
            return Vec::new();
        };
        let [_, [_, top]] = rail.extent;
        // Clear of the hatching of a guide.
        let height = top + 3.2 * self.pin;
        let [from, to] = [-2.6, 1.6].map(|x| [x * self.pin, height]);
        vec![
            Shape::line(slider.body, Role::Drive, &slider.plane, &[from, to]),
            self.head(slider.body, Role::Drive, &slider.plane, to, [1.0, 0.0]),
        ]
    }

    fn head(&self, body: usize, role: Role, plane: &Plane, foot: Point, along: Point) -> Shape {
        let [length, half] = HEAD.map(|x| x * self.pin);
        let corner = |side: f64| add(foot, scaled(side * half, left(along)));
        let ring = vec![add(foot, scaled(length, along)), corner(1.0), corner(-1.0)];
        Shape::region(body, role, plane, &[ring])
    }
}

/// True if this motion of a joint is a rotation.
pub(super) fn is_rotation(joint: &Joint, motion_idx: usize) -> bool {
    joint.kind.motions().get(motion_idx) == Some(&MotionKind::Rotation)
}
