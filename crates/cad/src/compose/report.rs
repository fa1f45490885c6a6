//! Facts about a composition, for people and for programs.

use super::frame::Frame;
use crate::drawing::Location;
use crate::geometry::{Path, Point};
use crate::mass::AreaProperties;

/// A body of a drawing.
#[derive(Clone, Debug)]
pub struct BodyReport {
    /// Name of the body.
    pub name: String,
    /// Where its mass comes from.
    pub source: MassSource,
    /// Mass as the text of a model file.
    pub mass: Option<String>,
    /// Centre of mass in world axes, drawing units.
    pub centre: Point,
    /// Outline's areas and moments, drawing units.
    pub area: Option<AreaProperties>,
    /// Frame of the body.
    pub frame: Frame,
    /// Curves in world axes, drawing units.
    pub paths: Vec<Path>,
    /// Where it was first met.
    pub location: Location,
}

/// Where a mass comes from.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum MassSource {
    /// The author states it.
    Stated,
    /// Density, thickness and area.
    Computed,
    /// Nothing says it.
    Missing,
}

/// A joint of a drawing.
#[derive(Clone, PartialEq, Debug)]
pub struct JointReport {
    /// Name of the joint.
    pub name: String,
    /// Kind of the joint.
    pub kind: &'static str,
    /// Bodies of the joint, the first one first.
    pub bodies: [String; 2],
    /// Where it is on each, world axes, drawing units.
    pub at: [Point; 2],
}

/// Two points taken as one.
#[derive(Clone, PartialEq, Debug)]
pub struct JointSnap {
    /// The attachment that was put onto the body, in words: ``joint `B` ``.
    pub what: String,
    /// The body it was put onto.
    pub body: String,
    /// The point of the body.
    pub from: Point,
    /// The point that it was taken as.
    pub to: Point,
    /// Their distance, drawing units.
    pub distance: f64,
}
