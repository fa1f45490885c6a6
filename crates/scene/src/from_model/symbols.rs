//! Pins, centres of mass, torsion springs.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use bksim_mbs::model::{JointKind, LoadKind};

use super::{Sketch, flat};
use crate::geometry::{Point, add, arc, circle, direction, distance, scaled};
use crate::{Attached, Role, Shape};

/// Radius of the sign of a centre of mass, radii of a pin.
const MASS: f64 = 1.0;
/// Inner and outer radius of a torsion spring, and its turns.
const SPIRAL: [f64; 3] = [1.5, 3.4, 2.25];

impl Sketch<'_> {
    /// The pins of joints that turn.
    pub(super) fn pins(&self) -> Vec<Shape> {
        let at = self.pinned().into_iter();
        let pin = |at: Attached| {
            Shape::region(at.body, Role::Pin, &[circle(flat(at.position), self.pin)])
        };
        at.map(pin).collect()
    }

    /// Where there is a pin.
    fn pinned(&self) -> Vec<Attached> {
        let mut at = Vec::new();
        for joint in &self.model().joints {
            match joint.kind {
                JointKind::Revolute | JointKind::PinInSlot => {
                    at.push(self.numbers.attached(joint.successor));
                }
                JointKind::Link { .. } => {
                    let ends = [joint.predecessor, joint.successor];
                    at.extend(ends.map(|anchor| self.numbers.attached(anchor)));
                }
                JointKind::Prismatic { .. } | JointKind::Weld { .. } => (),
            }
        }
        at
    }

    /// The signs of centres of mass, where they are not hidden by a pin.
    pub(super) fn masses(&self) -> Vec<Shape> {
        let mut shapes = Vec::new();
        let pinned: Vec<Vec<Point>> =
            self.attached.iter().map(|points| points.iter().copied().map(flat).collect()).collect();
        for body in 1..self.model().bodies.len() {
            let Some(com) = self.com(body) else { continue };
            let is_hidden = pinned[body].iter().any(|&p| distance(p, com) < 2.0 * self.pin);
            if is_hidden {
                continue;
            }
            let radius = MASS * self.pin;
            let quarter = |from: f64| {
                let mut ring = arc(com, radius, from, from + FRAC_PI_2);
                ring.push(com);
                ring
            };
            shapes.push(Shape::region(body, Role::MassLight, &[circle(com, radius)]));
            shapes.push(Shape::region(body, Role::MassDark, &[quarter(0.0), quarter(PI)]));
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
            let at = self.numbers.attached(self.model().joints[joint.0].successor);
            let [inner, outer, turns] = SPIRAL;
            let n = 24.0 * turns;
            let point = |i: u32| {
                let part = f64::from(i) / n;
                let radius = (inner + (outer - inner) * part) * self.pin;
                add(flat(at.position), scaled(radius, direction(TAU * turns * part)))
            };
            let points: Vec<Point> = (0..=54).map(point).collect();
            shapes.push(Shape::line(at.body, Role::Spring, &points));
        }
        shapes
    }
}
