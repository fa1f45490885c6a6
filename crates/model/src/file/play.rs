//! Joints that contacts hold: pins and slides with play, and what lifts off curves; their contacts by name, and what is read of
//! them.

use bksim_expr::Expr;

use super::tree::{Table, Value};
use crate::body::Anchor;
use crate::diagnostic::Span;
use crate::ids::{JointId, Vector};

/// The key that gives a joint play.
pub(super) const CLEARANCE: &str = "clearance";
/// Types of joints that may have play.
pub(super) const PLAYING_TYPES: [&str; 2] = ["revolute", "prismatic"];
/// The key that lets what touches a curve lift off it.
pub(super) const LIFTS: &str = "lifts";
/// Types of joints that may lift off a curve.
pub(super) const LIFTING_TYPES: [&str; 3] = ["point-on-curve", "line-on-curve", "curve-on-curve"];
/// The sides of a slide by the names of their contacts, and the signs of their places to the left of the axis.
pub(super) const SIDES: [(&str, i32); 2] = [("left", 1), ("right", -1)];

/// A joint that contacts hold.
#[derive(Clone, Debug)]
pub(super) struct Play {
    pub(super) name: String,
    pub(super) ends: [Anchor; 2],
    pub(super) form: Form,
    pub(super) restitution: Expr,
    pub(super) friction: Option<[Expr; 2]>,
    pub(super) span: Span,
}

/// Sizes of journal and bush, or of slide and guide.
#[derive(Clone, Debug)]
pub(super) enum Form {
    /// A journal of this radius, with play.
    Pin { radius: Expr, clearance: Expr },
    /// Of this joint of something that lifts off a curve.
    Curve(JointId),
    /// A slide of this length and width, turned by `angle` against its guide, with its axis in the frames of the first
    /// and the second point.
    Slide { length: Expr, width: Expr, clearance: Expr, angle: Expr, axes: [Vector; 2] },
}

/// True of a joint that `clearance` gives play.
pub(super) fn has_play(word: &str, table: &Table) -> bool {
    PLAYING_TYPES.contains(&word) && table.get(CLEARANCE).is_some()
}

/// True of a joint with a curve that `lifts` lets go of it.
pub(super) fn may_lift(word: &str, table: &Table) -> bool {
    let lifts = table.get(LIFTS).map(|entry| &entry.node.value);
    LIFTING_TYPES.contains(&word) && matches!(lifts, Some(Value::Bool(true)))
}

/// The names of the contacts that stand for a joint.
pub(super) fn contacts_of_joint(name: &str, table: &Table, word: &str) -> Vec<String> {
    match word {
        _ if may_lift(word, table) => vec![name.to_owned()],
        _ if !has_play(word, table) => Vec::new(),
        "revolute" => vec![name.to_owned()],
        _ => SIDES.map(|(side, _)| format!("{name}_{side}")).to_vec(),
    }
}
