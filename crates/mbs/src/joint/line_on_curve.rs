//! Line on a curve: a line of the successor, in space a plane through it and along z, is tangent to a curve of the
//! predecessor, as the face of a flat follower is. The parameter of the curve at the place of contact is a
//! coordinate without inertia, whose own equation says that the contact has no moment where the curve is bent.

use bksim_expr::Pool;

use super::{JointWrench, Motion, Row, Sides, rows};
use crate::spatial::{self, Rotation, z_axis};
use bksim_model::{Joint, Vector};

/// The parameter of the curve; its axis has no meaning.
pub(super) fn motions(pool: &Pool, _: &Joint) -> Vec<Motion> {
    vec![Motion::rotation(z_axis(pool))]
}

pub(super) fn fixed_turn(_: &Pool, _: &Joint) -> Rotation {
    Rotation::default()
}

/// n · (r_P + r(s) − r_Q) = 0 and n · r′/|r′| = 0 for the normal n of the line.
pub(super) fn constraint_rows(pool: &Pool, joint: &Joint, sides: &Sides) -> Vec<Row> {
    let (Some(on_curve), Some(contact)) = (&sides.on_curve, contact(pool, joint, sides)) else {
        return Vec::new();
    };
    let normal = contact.force;
    let gap = spatial::sub(pool, &place(pool, sides), &sides.p_world_successor);
    let contact_row =
        Row { expression: spatial::dot(pool, &normal, &gap), direction: "normal", wrench: contact };
    let tangent = &on_curve.tangent;
    let length = pool.sqrt(spatial::dot(pool, tangent, tangent));
    let along = spatial::scale(pool, pool.div(pool.one(), length), tangent);
    let along = sides.predecessor.rotation.apply(pool, &along);
    vec![contact_row, rows::perpendicular_row(pool, &along, &normal)]
}

/// A unit force across the line at the place of contact, with its moment about the successor's point.
pub(super) fn contact(pool: &Pool, joint: &Joint, sides: &Sides) -> Option<JointWrench> {
    sides.on_curve.as_ref().filter(|_| joint.kind.is_face())?;
    let normal = spatial::cross(pool, &z_axis(pool), &joint.axis);
    let force = sides.successor.rotation.apply(pool, &normal);
    let arm = spatial::sub(pool, &place(pool, sides), &sides.p_world_successor);
    Some(JointWrench { force, moment: spatial::cross(pool, &arm, &force) })
}

/// A face on a curve, world axes.
pub(crate) struct Face {
    /// Unit tangent of the curve at the place of contact.
    pub(crate) tangent: Vector,
    /// Unit vector along the face.
    pub(crate) along: Vector,
    /// From the successor's point to the place, m.
    pub(crate) arm: Vector,
}

impl Face {
    /// That of a joint of this kind; `None` of others.
    pub(crate) fn of(pool: &Pool, joint: &Joint, sides: &Sides) -> Option<Self> {
        let on_curve = sides.on_curve.as_ref().filter(|_| joint.kind.is_face())?;
        let length = pool.sqrt(spatial::dot(pool, &on_curve.tangent, &on_curve.tangent));
        let unit = spatial::scale(pool, pool.div(pool.one(), length), &on_curve.tangent);
        Some(Self {
            tangent: sides.predecessor.rotation.apply(pool, &unit),
            along: sides.successor.rotation.apply(pool, &joint.axis),
            arm: spatial::sub(pool, &place(pool, sides), &sides.p_world_successor),
        })
    }
}

/// The place of contact, world axes.
fn place(pool: &Pool, sides: &Sides) -> Vector {
    let offset = sides.on_curve.as_ref().map_or(spatial::zero(pool), |place| place.offset);
    let offset = sides.predecessor.rotation.apply(pool, &offset);
    spatial::add(pool, &sides.p_world_predecessor, &offset)
}
