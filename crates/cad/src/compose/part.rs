//! Parts of a mechanism as they come out of a drawing: bodies with their geometry, and names.

use crate::attachment::{Attachment, Content, Value};
use crate::drawing::Location;
use crate::geometry::{Path, Point};
use crate::outline::Outline;

/// A body in the drawing. Number 0 is the ground.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Its name; `ground` for the first.
    pub name: String,
    /// Where it was first met.
    pub location: Option<Location>,
    /// Stated values, the drawing's and those of the file beside it, which come first.
    pub values: Vec<Value>,
    /// Its curves in world axes, drawing units, each with the number of its entity.
    pub paths: Vec<(Path, usize)>,
    /// Points of it that a joint may be meant to meet: centres, corners, ends.
    pub features: Vec<Point>,
    /// Its closed outlines.
    pub outline: Option<Outline>,
    /// Whether its outline has a fault that was reported.
    pub has_bad_outline: bool,
    /// Stated centre of mass, in world axes.
    pub centre: Option<Point>,
    /// Named points, in world axes.
    pub points: Vec<NamedPoint>,
    /// Its frame, once chosen.
    pub frame: Option<Frame>,
}

/// A named point of a body.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct NamedPoint {
    /// Unique in its body.
    pub name: String,
    /// In world axes, drawing units.
    pub at: Point,
    /// What says so.
    pub location: Location,
}

/// A frame in world axes: origin in drawing units, angle in rad.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Frame {
    /// Origin.
    pub origin: Point,
    /// Angle of its x axis to that of the world.
    pub angle: f64,
}

impl Frame {
    /// A frame with its x axis along a vector.
    pub fn along(origin: Point, axis: Point) -> Self {
        Self { origin, angle: axis[1].atan2(axis[0]) }
    }

    /// A point of the world in this frame.
    pub fn point_inward(&self, p_world: Point) -> Point {
        self.vector_inward([p_world[0] - self.origin[0], p_world[1] - self.origin[1]])
    }

    /// A vector of the world in this frame.
    pub fn vector_inward(&self, [x, y]: Point) -> Point {
        let (sin, cos) = self.angle.sin_cos();
        [cos * x + sin * y, cos * y - sin * x]
    }
}

impl Part {
    /// A body without anything.
    pub(crate) fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            location: None,
            values: Vec::new(),
            paths: Vec::new(),
            features: Vec::new(),
            outline: None,
            has_bad_outline: false,
            centre: None,
            points: Vec::new(),
            frame: None,
        }
    }

    /// The stated value of a key.
    pub(crate) fn value(&self, key: &str) -> Option<&Value> {
        find(&self.values, key)
    }

    /// Name of the point at a location; a new one is called `wish`, or `wish2`, ….
    pub(crate) fn point(
        &mut self,
        wish: &str,
        at: Point,
        location: &Location,
        tolerance: f64,
    ) -> String {
        let near = |point: &&NamedPoint| {
            (point.at[0] - at[0]).abs() <= tolerance && (point.at[1] - at[1]).abs() <= tolerance
        };
        if let Some(known) = self.points.iter().find(near) {
            return known.name.clone();
        }
        let mut name = wish.to_owned();
        let mut number = 2;
        while self.points.iter().any(|point| point.name == name) {
            name = format!("{wish}{number}");
            number += 1;
        }
        self.points.push(NamedPoint { name: name.clone(), at, location: location.clone() });
        name
    }
}

/// The value of a key in a list.
pub(crate) fn find<'v>(values: &'v [Value], key: &str) -> Option<&'v Value> {
    values.iter().find(|value| value.key == key)
}

/// The text of a key in an attachment.
pub(crate) fn text_of<'a>(attachment: &'a Attachment, key: &str) -> Option<&'a str> {
    match &find(&attachment.values, key)?.content {
        Content::Text(text) => Some(text),
        _ => None,
    }
}
