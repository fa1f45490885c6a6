//! A joint of a drawing, and the scene in which joints are found.

use bksim_cad::geometry::Point;
use bksim_cad::geometry::vector::along;

use super::bodies::{Bodies, Pin};
use super::hatching::Base;
use super::pieces::Pieces;

/// A body, or the ground.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum On {
    Ground,
    Body(usize),
}

/// Kind of a joint by what it allows.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Kind {
    Pin,
    Slide {
        axis: Point,
    },
    /// The pin of the first body in a slot of the last.
    Slot {
        axis: Point,
    },
    /// Rate of the second over that of the first, against what holds their centres; pitch radii.
    Gear {
        ratio: f64,
        radii: [f64; 2],
        is_internal: bool,
    },
    /// Pitch radius of the wheel, the first body; direction of the rack.
    Rack {
        radius: f64,
        axis: Point,
    },
    /// The outline of the first body moves the second one, along the normal of the contact.
    Cam {
        normal: Point,
        /// Radius of a roller about a pin of the second body; of a flat face none.
        roller: Option<f64>,
    },
}

impl Kind {
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Pin => "pin",
            Self::Slide { .. } => "slide",
            Self::Slot { .. } => "pin in slot",
            Self::Gear { is_internal: false, .. } => "gear",
            Self::Gear { .. } => "gear inside",
            Self::Rack { .. } => "rack",
            Self::Cam { .. } => "cam",
        }
    }
}

/// A joint.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    pub(super) kind: Kind,
    pub(super) at: Point,
    pub(super) on: Vec<On>,
    pub(super) name: String,
    /// Strokes that show it.
    pub(super) from: Vec<usize>,
}

impl Joint {
    pub(super) fn new(kind: Kind, at: Point, on: Vec<On>, from: Vec<usize>) -> Self {
        Self { kind, at, on, name: String::new(), from }
    }

    /// Centre of the pin: of a roller on a cam, away from the contact.
    pub(super) fn centre(&self) -> Point {
        match self.kind {
            Kind::Cam { normal, roller } => along(self.at, roller.unwrap_or_default(), normal),
            _ => self.at,
        }
    }

    /// Name of the part that joins the k-th of the further bodies: a pin of three bodies is two joints of a model.
    pub(super) fn part_name(&self, k: usize) -> String {
        if k == 0 { self.name.clone() } else { format!("{}_{}", self.name, k + 1) }
    }
}

/// Scene in which joints are found.
pub(super) struct Scene<'a> {
    pub(super) pieces: &'a Pieces,
    pub(super) pins: &'a [Pin],
    pub(super) bases: &'a [Base],
    pub(super) is_fixed: &'a mut Vec<bool>,
    pub(super) bodies: &'a mut Bodies,
}
