//! The types of `[joints.…]` in words, and the keys that go with each.

use super::play::has_play;
use super::tree::Table;
use crate::joint::JOINT_TYPES;

/// Keys of each type of joint, in the order of [`JOINT_TYPES`].
pub(super) const JOINT_KEYS: [&[&str]; JOINT_TYPES.len()] = [
    &[
        "type",
        "between",
        "axis",
        "second",
        "armature",
        "coordinate",
        "cut",
        "clearance",
        "radius",
        "mu",
        "static",
        "restitution",
    ],
    &[
        "type",
        "between",
        "axis",
        "second",
        "direction",
        "angle",
        "armature",
        "coordinate",
        "cut",
        "clearance",
        "length",
        "width",
        "mu",
        "static",
        "restitution",
    ],
    &["type", "between", "angle", "cut"],
    &["type", "between", "axis", "direction", "coordinate", "cut"],
    &["type", "between", "length"],
    &["type", "between", "coordinate", "cut"],
    &["type", "between", "axis", "second", "coordinate", "cut"],
    &["type", "between", "axis", "second", "coordinate", "cut"],
    &["type", "between", "axis", "second", "coordinate", "cut"],
    &["type", "between", "axis", "second", "lead", "coordinate", "cut"],
    &["type", "between", "coordinate", "cut"],
    &["type", "between", "axis", "coordinate", "cut"],
    &["type", "between", "axis", "coordinate", "cut"],
    &["type", "between", "axis", "second", "coordinate", "cut"],
    &["type", "between", "axis", "second", "coordinate", "cut"],
    &["type", "between", "axis", "second"],
    &["type", "between", "curve", "radius", "side", "coordinate"],
    &["type", "between", "curve", "axis", "direction", "coordinate"],
    &["type", "between", "min", "max", "restitution", "coordinate"],
    &["type", "between", "curve", "second_curve", "tangents", "rolling", "coordinate"],
    &["type", "between", "axis", "direction"],
    &["type", "between", "shape", "radius", "rim", "axis"],
];

/// The word that is a link where it has a `length`, and a cylinder where it has none.
pub(super) const DISTANCE: &str = "distance";

/// Keys of a distance, whichever it is.
pub(super) const DISTANCE_KEYS: [&str; 7] =
    ["type", "between", "length", "min", "max", "restitution", "coordinate"];

/// The word of [`JOINT_TYPES`] that a joint with the type `word` is of.
pub(super) fn type_of(word: &str, table: &Table) -> &'static str {
    let word = match word {
        DISTANCE if table.get("length").is_some() => "link",
        DISTANCE => "cylinder",
        // Contacts hold its bodies together.
        word if has_play(word, table) => "planar",
        word => word,
    };
    JOINT_TYPES.iter().map(|(known, _)| *known).find(|known| *known == word).unwrap_or("")
}

/// The types that a planar model may have; every other one leaves the plane.
pub(super) const PLANAR_TYPES: [&str; 10] = [
    "revolute",
    "prismatic",
    "weld",
    "slot",
    "link",
    "point-on-curve",
    "line-on-curve",
    "cylinder",
    "curve-on-curve",
    "knife-edge",
];
