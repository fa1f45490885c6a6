//! Points, faces and curves that lift off a curve: the gap between both, at the place of the curve that is nearest. The
//! normal row of the joint is a contact in its place; the others keep the parameters of the curves there, and have no force, as nothing resists the parameters.

use bksim_expr::{Expr, Function, Pool};

use super::{OnCurve, Sides};
use crate::spatial::{self, Rotation, z_axis};
use bksim_model::{Joint, Vector};

/// A point, face or curve next to a curve, world axes.
pub(crate) struct Lifted {
    /// Distance along the normal, m, whose slope by the parameter is zero at the place.
    pub(crate) gap: Expr,
    /// Unit normal of the curve to the side to which the other lifts off.
    pub(crate) normal: Vector,
    /// The place on the curve.
    pub(crate) at: Vector,
}

impl Lifted {
    /// That of a joint that lifts off a curve; `None` of others.
    pub(crate) fn of(pool: &Pool, joint: &Joint, sides: &Sides) -> Option<Self> {
        let is_left = joint.kind.lifts()?;
        let placed = |on: &OnCurve, rotation: &Rotation, point: &Vector| {
            spatial::add(pool, point, &rotation.apply(pool, &on.offset))
        };
        let on_curve = sides.on_curve.as_ref()?;
        let place = placed(on_curve, &sides.predecessor.rotation, &sides.p_world_predecessor);
        let length = pool.sqrt(spatial::dot(pool, &on_curve.tangent, &on_curve.tangent));
        let unit = spatial::scale(pool, pool.div(pool.one(), length), &on_curve.tangent);
        let tangent = sides.predecessor.rotation.apply(pool, &unit);
        let left = spatial::cross(pool, &z_axis(pool), &tangent);
        let to_side = |normal: &Vector| if is_left { *normal } else { spatial::neg(pool, normal) };
        let gap_to = |normal: &Vector, other: &Vector| {
            let apart = spatial::sub(pool, other, &place);
            pool.simplify(spatial::dot(pool, normal, &apart))
        };
        if joint.kind.is_face() {
            // Across the face, which has one direction: with it the gap has no slope by the parameter.
            let along = sides.successor.rotation.apply(pool, &joint.axis);
            let same_way = spatial::dot(pool, &tangent, &along);
            let sense = pool.call(Function::Sign, &[same_way]).expect("one argument");
            let across = spatial::cross(pool, &z_axis(pool), &along);
            let normal = to_side(&spatial::scale(pool, sense, &across));
            return Some(Self {
                gap: gap_to(&normal, &sides.p_world_successor),
                normal,
                at: place,
            });
        }
        let normal = to_side(&left);
        let other = match &sides.on_second {
            Some(second) => placed(second, &sides.successor.rotation, &sides.p_world_successor),
            None => sides.p_world_successor,
        };
        let to_curve = spatial::scale(pool, on_curve.left, &left);
        let at = spatial::sub(pool, &place, &to_curve);
        Some(Self { gap: gap_to(&normal, &other), normal, at })
    }
}
