//! The table of the types of joints: a row for each kind, with what is true of all joints of it.

use super::MotionKind::{self, Rotation as R, Translation as T};
use crate::body::Space;

/// Facts that all joints of one kind share.
#[derive(Clone, Copy, Debug)]
pub struct JointType {
    /// Word of the type in a model file.
    pub word: &'static str,
    /// Motions in the order of their coordinates: first translations, then rotations, each about an axis that those
    /// before it have turned. Of a kind that is always cut none but the parameters of curves, which count as angles,
    /// and the length of a cylinder.
    pub motions: &'static [MotionKind],
    /// Name in documents.
    pub name: &'static str,
    /// Keys in a model file after `type` and `between`, with spaces between them.
    keys: &'static str,
    /// True if a planar model may have it; every other one leaves the plane.
    pub(crate) is_in_plane: bool,
    /// Of a kind that is always a constraint, the freedoms that it takes from a body in a plane and in space.
    pub(super) taken: Option<[i64; 2]>,
    /// Conditions on rates among them.
    pub(super) n_rates: i64,
}

impl JointType {
    /// The type with this word in model files; `None` of another word.
    pub fn of_word(word: &str) -> Option<&'static Self> {
        JOINT_TYPES.iter().find(|row| row.word == word)
    }

    /// The keys of a joint of this type in a model file.
    pub(crate) fn keys(&self) -> Vec<&'static str> {
        ["type", "between"].into_iter().chain(self.keys.split_whitespace()).collect()
    }

    const fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    const fn in_plane(self) -> Self {
        Self { is_in_plane: true, ..self }
    }

    const fn always_cut(self, taken: [i64; 2], n_rates: i64) -> Self {
        Self { taken: Some(taken), n_rates, ..self }
    }

    /// The number of freedoms that it takes from a body: those that are none of its motions, unless it is stated.
    pub(super) fn n_taken(&self, space: Space) -> i64 {
        let is_planar = space == Space::Planar;
        let n_body = if is_planar { 3 } else { 6 };
        match self.taken {
            Some([in_plane, in_space]) => {
                if is_planar {
                    in_plane
                } else {
                    in_space
                }
            }
            None => self.motions.iter().fold(n_body, |left, _| left - 1),
        }
    }
}

const fn row(word: &'static str, motions: &'static [MotionKind], keys: &'static str) -> JointType {
    JointType { word, name: word, motions, keys, is_in_plane: false, taken: None, n_rates: 0 }
}

/// The types of joints, in the order of [`JointKind`](super::JointKind).
pub const JOINT_TYPES: [JointType; 22] = [
    row(
        "revolute",
        &[R],
        "axis second armature coordinate cut \
 clearance radius mu static restitution",
    )
    .in_plane(),
    row(
        "prismatic",
        &[T],
        "axis second direction angle armature coordinate cut \
 clearance length width mu static restitution",
    )
    .in_plane(),
    row("weld", &[], "angle cut").in_plane(),
    row("slot", &[T, R], "axis direction coordinate cut").named("pin in slot").in_plane(),
    row("link", &[], "length").named("massless link").always_cut([1, 1], 0).in_plane(),
    row("spherical", &[R, R, R], "coordinate cut"),
    row("universal", &[R, R], "axis second coordinate cut"),
    row("cylindrical", &[T, R], "axis second coordinate cut"),
    row("planar", &[T, T, R], "axis second coordinate cut"),
    row("screw", &[R], "axis second lead coordinate cut"),
    row("free", &[T, T, T, R, R, R], "coordinate cut"),
    row("point-on-line", &[T, R, R, R], "axis coordinate cut"),
    row("point-on-plane", &[T, T, R, R, R], "axis coordinate cut"),
    row("parallel-axes", &[T, T, T, R], "axis second coordinate cut"),
    row("perpendicular-axes", &[T, T, T, R, R], "axis second coordinate cut"),
    row("constant-velocity", &[], "axis second").always_cut([1, 4], 0),
    row("point-on-curve", &[R], "curve radius side lifts mu static restitution coordinate")
        .always_cut([1, 2], 0)
        .in_plane(),
    row("line-on-curve", &[R], "curve axis direction side lifts mu static restitution coordinate")
        .always_cut([1, 1], 0)
        .in_plane(),
    row("cylinder", &[T], "min max restitution coordinate").always_cut([0, 0], 0).in_plane(),
    row(
        "curve-on-curve",
        &[R, R],
        "curve second_curve tangents rolling side lifts mu static restitution coordinate",
    )
    .always_cut([1, 1], 0)
    .in_plane(),
    row("knife-edge", &[], "axis direction").always_cut([1, 1], 1).in_plane(),
    row("rolling", &[], "shape radius rim axis").always_cut([0, 3], 2),
];
