//! [`Scene`]: a mechanism as shapes, as plain data.

use serde::Serialize;

/// A mechanism as shapes. Bodies are named by their place in the model, the ground first.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct Scene {
    /// Whether all motion is in planes z = const.
    pub is_planar: bool,
    /// Names of the bodies.
    pub bodies: Vec<String>,
    /// What is fixed to bodies, those in the back first. Spans lie between those that are
    /// [in front](Role::is_in_front) and the others.
    pub shapes: Vec<Shape>,
    /// What is stretched between two bodies.
    pub spans: Vec<Span>,
    /// Joints, named points and centres of mass: what can be labelled, trailed, or bear an arrow.
    pub markers: Vec<Marker>,
    /// Radius of a pin, m: the measure of all symbols.
    pub pin: f64,
}

/// Something drawn on a body.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Shape {
    /// Place of its body.
    pub body: usize,
    /// What it stands for.
    pub role: Role,
    /// What it looks like, in the frame of the body, m.
    pub form: Form,
}

/// What a shape looks like.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub enum Form {
    /// A plane area bounded by closed rings, filled where a line to the outside crosses an odd number
    /// of them; its edges are drawn too.
    Region(Vec<Vec<[f64; 3]>>),
    /// A line through points.
    Line {
        /// The points.
        points: Vec<[f64; 3]>,
        /// Whether the last is joined to the first.
        is_closed: bool,
    },
}

/// What a shape stands for, and thereby how it is painted.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Serialize)]
pub enum Role {
    /// The outline of the ground.
    Ground,
    /// The short strokes that mark what is fixed.
    Hatching,
    /// A guide or slot.
    Guide,
    /// A body; the number chooses one of the colours.
    Body(u8),
    /// A pin, painted over the bodies it joins.
    Pin,
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
}

impl Role {
    /// Whether it is painted over springs, dampers and links.
    pub fn is_in_front(self) -> bool {
        matches!(self, Self::Pin | Self::MassLight | Self::MassDark)
    }
}

/// A point of a body.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Attached {
    /// Place of the body.
    pub body: usize,
    /// Where it is in the frame of the body, m.
    pub position: [f64; 3],
}

/// Something stretched between two points.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Span {
    /// Name of the load or joint.
    pub name: String,
    /// Its ends.
    pub ends: [Attached; 2],
    /// What it is.
    pub kind: SpanKind,
}

/// What is stretched.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub enum SpanKind {
    /// A spring; with its unloaded length, m, from which its number of turns comes.
    Spring {
        /// Unloaded length, m.
        length: f64,
        /// Whether a damper is beside it.
        is_damped: bool,
    },
    /// A damper.
    Damper {
        /// Distance of its ends at the start, m: half of it is the cylinder.
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
    /// What it is.
    pub kind: MarkerKind,
    /// Where it is.
    pub at: Attached,
}

/// What a marker marks.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
pub enum MarkerKind {
    /// A joint, on its second body; its place in the model.
    Joint(usize),
    /// A named point.
    Point,
    /// A centre of mass.
    Mass,
}
