//! [`Scene`]: a mechanism as shapes, as plain data.

use serde::Serialize;

use crate::{Cord, Solid, Turn};

/// A mechanism as shapes. Bodies are numbered as in the model, the ground first.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Scene {
    /// True if all motion is in planes z = const.
    pub is_planar: bool,
    /// Names of the bodies.
    pub bodies: Vec<String>,
    /// Shapes fixed to bodies, those in the back first. Spans lie between those that are
    /// [in front](Role::is_in_front) and the others.
    pub shapes: Vec<Shape>,
    /// Springs, dampers and links, stretched between two bodies.
    pub spans: Vec<Span>,
    /// Ropes and belts.
    pub cords: Vec<Cord>,
    /// Joints, named points and centres of mass: they can be labelled, trailed, or bear an arrow.
    pub markers: Vec<Marker>,
    /// Signs of torques, in the order of their shapes.
    #[serde(skip)]
    pub turns: Vec<Turn>,
    /// Radius of a pin, m: the measure of all symbols.
    pub pin: f64,
}

/// Something drawn on a body.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Shape {
    /// Index of its body.
    pub body: usize,
    /// The part of the mechanism that it depicts.
    pub role: Role,
    /// Geometry in the frame of the body, m.
    pub form: Form,
}

/// The geometry of a shape.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub enum Form {
    /// A plane area bounded by closed rings, filled where a line to the outside crosses an odd
    /// number of them; its edges are drawn too.
    Region(Vec<Vec<[f64; 3]>>),
    /// A line through points.
    Line {
        /// The points.
        points: Vec<[f64; 3]>,
        /// True if the last is joined to the first.
        is_closed: bool,
    },
    /// All points within a distance of a line: a rod with round ends, a ball where they coincide.
    Rod {
        /// The ends of the line.
        ends: [[f64; 3]; 2],
        /// The distance, m.
        radius: f64,
    },
    /// A solid with plane faces.
    Solid(Solid),
    /// The face of a solid at a [plane](crate::Section) that cuts it: in front of all that is left of the mechanism.
    Section {
        /// The rings about it; it is filled by the even–odd rule.
        rings: Vec<Vec<[f64; 3]>>,
        /// The lines of its hatching.
        hatching: Vec<[[f64; 3]; 2]>,
    },
}

/// The part of the mechanism that a shape depicts, which decides how it is painted.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Serialize)]
pub enum Role {
    /// The outline of the ground.
    Ground,
    /// The short strokes that mark fixed parts.
    Hatching,
    /// A guide or slot.
    Guide,
    /// A body; the number chooses one of the colours.
    Body(u8),
    /// A pin, painted over the bodies it joins.
    Pin,
    /// A joint that lets nothing move: a square, or a ball in space, and solid.
    Weld,
    /// The sign of a drive.
    Drive,
    /// The sign of a torque.
    Torque,
    /// The sign of a centre of mass: its light quarters.
    MassLight,
    /// The sign of a centre of mass: its dark quarters.
    MassDark,
    /// A spring.
    Spring,
    /// A damper.
    Damper,
    /// A massless link.
    Link,
    /// A curve laid over the mechanism; the number chooses one of the colours.
    Curve(u8),
    /// A curve that counts less.
    FaintCurve(u8),
    /// A region under the mechanism that a body sweeps.
    Swept(u8),
}

impl Role {
    /// True of a curve laid over the mechanism.
    pub fn is_curve(self) -> bool {
        matches!(self, Self::Curve(_) | Self::FaintCurve(_))
    }

    /// True if it is painted over springs, dampers and links.
    pub fn is_in_front(self) -> bool {
        let is_sign = matches!(self, Self::Weld | Self::Drive | Self::Torque);
        is_sign || self.is_curve() || matches!(self, Self::Pin | Self::MassLight | Self::MassDark)
    }
}

/// A point of a body.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Attached {
    /// Index of the body.
    pub body: usize,
    /// Position in the frame of the body, m.
    pub position: [f64; 3],
}

/// Something stretched between two points.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Span {
    /// Name of the load or joint.
    pub name: String,
    /// Ends of the span.
    pub ends: [Attached; 2],
    /// Spring, damper or link.
    pub kind: SpanKind,
}

/// Kind of a span.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub enum SpanKind {
    /// A spring; its unloaded length decides its number of turns.
    Spring {
        /// Unloaded length, m.
        length: f64,
        /// True if a damper is drawn next to it.
        is_damped: bool,
    },
    /// A damper.
    Damper {
        /// Distance of its ends at the start, m: half of it is the cylinder.
        length: f64,
    },
    /// An actuator: a barrel with a rod.
    Cylinder {
        /// Length at the start, m.
        length: f64,
    },
    /// A rigid massless link.
    Link,
}

/// A point that has a name.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Marker {
    /// `A` for a joint, `crank.P` for a point, `crank` for a centre of mass.
    pub name: String,
    /// Joint, point or centre of mass.
    pub kind: MarkerKind,
    /// Position on its body.
    pub at: Attached,
}

/// Kind of a marker.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
pub enum MarkerKind {
    /// A joint, on its second body; with its index in the model.
    Joint(usize),
    /// A named point.
    Point,
    /// A centre of mass.
    Mass,
}
