//! [`Robot`]: a model on its way to another format, as links, connections and what acts on them, numbers alone.

use bksim_model::diagnostic::{Diagnostic, Span};
use bksim_model::{Joint, MotionKind};

use crate::shapes::Solid;
use crate::spatial::{Inertia, Pose, Vector};

/// Highest power of a relation between two joints.
pub(super) const MAX_POWER: usize = 4;

/// A body; the ground is the first.
pub(super) struct Link {
    pub(super) name: String,
    pub(super) inertia: Inertia,
    /// Place of its frame in the world.
    pub(super) pose: Pose,
    pub(super) shapes: Vec<(Solid, Pose)>,
    /// The connection that carries it in the tree.
    pub(super) carrier: Option<usize>,
}

impl Link {
    pub(super) fn is_massless(&self) -> bool {
        self.inertia.mass == 0.0 && self.inertia.tensor == [0.0; 6]
    }
}

/// One motion of a joint, and what acts in it.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub(super) name: String,
    pub(super) kind: MotionKind,
    /// Unit vector in world axes, so that the child moves against the parent by the joint's coordinate.
    pub(super) along: Vector,
    /// Coordinate in the reference pose.
    pub(super) at: f64,
    pub(super) limits: Option<[Option<f64>; 2]>,
    pub(super) stiffness: f64,
    /// Coordinate at which the spring is at rest.
    pub(super) rest: f64,
    pub(super) damping: f64,
    pub(super) friction: f64,
    pub(super) armature: f64,
}

/// A joint between two links.
pub(super) struct Connection {
    /// Index of the joint in the model; `None` of a body that nothing holds.
    pub(super) joint: Option<usize>,
    pub(super) name: String,
    /// Word of the joint's type.
    pub(super) word: &'static str,
    pub(super) parent: usize,
    pub(super) child: usize,
    /// Joint point, world axes.
    pub(super) center: Vector,
    /// Motions in their order, those of a ball left out.
    pub(super) axes: Vec<Axis>,
    /// True if it turns as it likes after them.
    pub(super) has_ball: bool,
    /// Translation that goes with one turn, m.
    pub(super) lead: Option<f64>,
    pub(super) is_loop: bool,
    pub(super) span: Span,
}

/// Warnings and parts that are left out.
#[derive(Default)]
pub(super) struct Report {
    pub(super) faults: Vec<Diagnostic>,
    pub(super) left_out: Vec<(String, Span)>,
}

impl Report {
    pub(super) fn leave_out(&mut self, what: String, span: &Span) {
        self.left_out.push((what, span.clone()));
    }
}

/// A model on its way to another format.
pub(super) struct Robot {
    pub(super) name: String,
    pub(super) notes: Vec<String>,
    pub(super) links: Vec<Link>,
    pub(super) connections: Vec<Connection>,
    /// Links but the ground, parents first.
    pub(super) order: Vec<usize>,
    pub(super) is_planar: bool,
    pub(super) gravity: Vector,
    pub(super) mimics: Vec<Mimic>,
    pub(super) motors: Vec<Motor>,
    pub(super) tendons: Vec<Tendon>,
}

/// A motion that follows another one: y = c₀ + c₁ x + … + c₄ x⁴.
pub(super) struct Mimic {
    pub(super) name: String,
    /// Motion that follows, by its name.
    pub(super) of: String,
    /// Motion that leads; `None` where y is c₀.
    pub(super) by: Option<String>,
    pub(super) coefficients: [f64; MAX_POWER + 1],
}

impl Mimic {
    /// Coefficients of y − y₀ in powers of x − x₀.
    pub(super) fn about(&self, [y0, x0]: [f64; 2]) -> [f64; MAX_POWER + 1] {
        let mut shifted = self.coefficients;
        // Horner's scheme, once for each derivative.
        for first in 0..MAX_POWER {
            for power in (first..MAX_POWER).rev() {
                shifted[power] += x0 * shifted[power + 1];
            }
        }
        shifted[0] -= y0;
        if shifted[0].abs() < 1e-15 * (y0.abs() + x0.abs()) {
            shifted[0] = 0.0;
        }
        shifted
    }
}

/// An effort on a motion, in proportion to an input.
pub(super) struct Motor {
    pub(super) name: String,
    pub(super) on: String,
    pub(super) gear: f64,
}

/// A spring and damper between two points.
pub(super) struct Tendon {
    pub(super) name: String,
    /// Link and place in its frame.
    pub(super) ends: [(usize, Vector); 2],
    pub(super) stiffness: f64,
    pub(super) length: f64,
    pub(super) damping: f64,
}

/// Name of a motion: that of its joint, or that of one of several coordinates.
pub(super) fn axis_name(joint: &Joint, is_single: bool, motion_idx: usize) -> String {
    if is_single { joint.name.clone() } else { joint.coordinate_name(motion_idx) }
}
