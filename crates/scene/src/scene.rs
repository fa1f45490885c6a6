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
    /// All that is within a distance of a line: a rod with round ends, a ball where they coincide.
    Rod {
        /// The ends of the line.
        ends: [[f64; 3]; 2],
        /// The distance, m.
        radius: f64,
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
    /// What holds two bodies together for good: as a pin, and solid.
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
}

impl Role {
    /// Whether it is painted over springs, dampers and links.
    pub fn is_in_front(self) -> bool {
        let is_sign = matches!(self, Self::Weld | Self::Drive | Self::Torque);
        is_sign || matches!(self, Self::Pin | Self::MassLight | Self::MassDark)
    }
}

impl Scene {
    /// How far towards the eye each shape is painted in space, m, from how far their middles are
    /// (`own`, by shape): signs before what they go through, and before the whole rod that they are
    /// on, of which the middle says little.
    pub fn depths(&self, own: &[f64]) -> Vec<f64> {
        let mut rods = vec![f64::NEG_INFINITY; self.bodies.len()];
        for (shape, &own) in self.shapes.iter().zip(own) {
            let is_rod = matches!(shape.form, Form::Rod { .. }) && !shape.role.is_in_front();
            if let Some(rod) = rods.get_mut(shape.body).filter(|_| is_rod) {
                *rod = rod.max(own);
            }
        }
        let painted = |(shape, &own): (&Shape, &f64)| {
            let rod = rods.get(shape.body).copied().unwrap_or(own);
            if shape.role.is_in_front() { own.max(rod) + self.pin } else { own }
        };
        self.shapes.iter().zip(own).map(painted).collect()
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
