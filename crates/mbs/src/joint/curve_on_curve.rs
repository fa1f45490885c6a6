//! Curve on a curve: a curve of the successor is in contact with one of the predecessor, in space as prisms along z
//! are. The parameters of both at the place of contact are coordinates without inertia, whose own equations say that
//! the contact has no moment, and no force along the tangent where the curves slide.
//!
//! ```text
//! n · (p₁ − p₂) = 0,  t₁ · (p₁ − p₂) = 0    the places on both curves are one
//! t₁ · n₂ = 0                               and so are the tangents
//! L₁(s₁) ± L₂(s₂) = 0                       equal lengths have come by where the curves roll
//! ```
//!
//! The last row bears on the parameters alone: through their equations its multiplier is the force along the
//! tangent, the friction that rolling takes.

use bksim_expr::{Expr, Pool};

use super::{JointWrench, Motion, OnCurve, Row, Sides, rows};
use crate::spatial::{self, Rotation, z_axis};
use bksim_model::{Joint, Vector};

/// The parameters of the curves; their axes have no meaning.
pub(super) fn motions(pool: &Pool, _: &Joint) -> Vec<Motion> {
    vec![Motion::rotation(z_axis(pool)); 2]
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// The rows above; a unit force acts at the place of contact.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let Some(touch) = Touch::of(pool, joint, sides) else { return Vec::new() };
    let gap = spatial::sub(pool, &touch.places[0], &touch.places[1]);
    let arm = spatial::sub(pool, &touch.places[1], &sides.p_world_successor);
    let normals = touch.tangents.map(|tangent| across(pool, sides, &tangent));
    let along = |direction: &'static str, force: Vector| Row {
        expression: spatial::dot(pool, &force, &gap),
        direction,
        wrench: JointWrench { force, moment: spatial::cross(pool, &arm, &force) },
    };
    let mut rows = vec![
        along("normal", normals[0]),
        along("tangent", touch.tangents[0]),
        rows::perpendicular_row(pool, &touch.tangents[0], &normals[1]),
    ];
    rows.extend(touch.rolled.map(|expression| Row {
        expression,
        direction: "rolling",
        wrench: JointWrench::of_force(pool, spatial::zero(pool)),
    }));
    rows
}

/// The cosine of the tangents, or its opposite, which is one where the curves touch as stated.
pub(super) fn alignment(pool: &Pool, joint: &Joint, sides: &Sides) -> Option<Expr> {
    let is_same_way = joint.kind.is_same_way()?;
    let [first, second] = Touch::of(pool, joint, sides)?.tangents;
    let cosine = spatial::dot(pool, &first, &second);
    Some(if is_same_way { cosine } else { pool.neg(cosine) })
}

/// The place of contact with the motions about it: along z and about all axes, and along the tangent where the
/// curves slide.
pub(super) fn contact(pool: &Pool, joint: &Joint, sides: &Sides) -> Option<(Vector, Vec<Motion>)> {
    let touch = Touch::of(pool, joint, sides)?;
    let z = sides.predecessor.rotation.apply(pool, &z_axis(pool));
    let mut motions = vec![Motion::translation(z)];
    if touch.rolled.is_none() {
        motions.push(Motion::translation(touch.tangents[0]));
    }
    motions.extend(Motion::turns(pool));
    Some((touch.places[1], motions))
}

/// The places on both curves and the unit tangents there, world axes.
struct Touch {
    places: [Vector; 2],
    tangents: [Vector; 2],
    /// Zero where the curves roll, m.
    rolled: Option<Expr>,
}

impl Touch {
    fn of(pool: &Pool, joint: &Joint, sides: &Sides) -> Option<Self> {
        let is_same_way = joint.kind.is_same_way()?;
        let (first, second) = (sides.on_curve.as_ref()?, sides.on_second.as_ref()?);
        let place = |on: &OnCurve, rotation: &Rotation, point: &Vector| {
            let length = pool.sqrt(spatial::dot(pool, &on.tangent, &on.tangent));
            let unit = spatial::scale(pool, pool.div(pool.one(), length), &on.tangent);
            let at = spatial::add(pool, point, &rotation.apply(pool, &on.offset));
            (at, rotation.apply(pool, &unit))
        };
        let first_place = place(first, &sides.predecessor.rotation, &sides.p_world_predecessor);
        let second_place = place(second, &sides.successor.rotation, &sides.p_world_successor);
        let rolled = first.arc.zip(second.arc).map(|(first, second)| {
            if is_same_way { pool.sub(first, second) } else { pool.add(first, second) }
        });
        Some(Self {
            places: [first_place.0, second_place.0],
            tangents: [first_place.1, second_place.1],
            rolled,
        })
    }
}

/// The normal to the left of a tangent.
fn across(pool: &Pool, sides: &Sides, tangent: &Vector) -> Vector {
    let z = sides.predecessor.rotation.apply(pool, &z_axis(pool));
    spatial::cross(pool, &z, tangent)
}
