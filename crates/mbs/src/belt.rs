//! Strands of belts: the forces with which they pull at their wheels.
//!
//! A strand with tension one pulls at the first wheel along its direction e, at the point where the belt leaves
//! it, and at the second one against e, where it comes to it:
//!
//! ```text
//! d = c₂ − c₁,  δ = r₂ − r₁,  s = √(d·d − δ²),  e = (s d − δ ẑ × d)/d·d
//! at c₁ − r₁ ẑ × e and c₂ − r₂ ẑ × e              radii below zero where the belt turns right
//! ```

use bksim_expr::{Expr, Pool, SymbolId};
use bksim_model::{Anchor, Belt, BeltId, BeltWheel, BodyId, GROUND, Model, Vector};

use crate::folding::short;
use crate::force::Wrench;
use crate::kinematics::Kinematics;
use crate::spatial;

/// The wheel of a belt with its centre, and the body that carries it there.
pub fn ends(model: &Model, wheel: &BeltWheel) -> [Anchor; 2] {
    let joint = &model.joints[wheel.joint.0];
    let (wheel, carrier) = (joint.successor, joint.predecessor);
    if wheel.body == GROUND { [carrier, wheel] } else { [wheel, carrier] }
}

/// The wrenches of a strand with tension one, from the wheel of this number to the next.
pub(crate) fn strand_wrenches(
    model: &Model,
    kinematics: &Kinematics,
    belt: &Belt,
    strand: usize,
) -> Vec<Wrench> {
    let pool = &model.pool;
    let wheels = [strand, (strand + 1) % belt.wheels.len()].map(|k| &belt.wheels[k]);
    let wheel_ends = wheels.map(|wheel| ends(model, wheel)[0]);
    let centers = wheels.map(|wheel| kinematics.anchor(model, ends(model, wheel)[1]));
    let bodies = wheel_ends.map(|end| end.body);
    let places = wheel_ends.map(|end| kinematics.anchor(model, end));
    span_wrenches(pool, centers, places, bodies, wheels.map(|wheel| wheel.radius))
}

/// The wrenches of a free strand with tension one between two wheels, with the places where the forces are taken to act.
pub(crate) fn span_wrenches(
    pool: &Pool,
    centers: [Vector; 2],
    places: [Vector; 2],
    bodies: [BodyId; 2],
    [first, second]: [Expr; 2],
) -> Vec<Wrench> {
    let z = spatial::z_axis(pool);
    let d = spatial::sub(pool, &centers[1], &centers[0]);
    let delta = pool.sub(second, first);
    let square = short(pool, spatial::dot(pool, &d, &d));
    let length = pool.sqrt(pool.sub(square, pool.mul(delta, delta)));
    let along = spatial::scale(pool, length, &d);
    let across = spatial::scale(pool, delta, &spatial::cross(pool, &z, &d));
    let part = pool.div(pool.one(), square);
    let e = spatial::scale(pool, part, &spatial::sub(pool, &along, &across));
    let aside = spatial::cross(pool, &z, &e);

    // At the centre, which is a point of the wheel, with the moment about it.
    let on = |k: usize, radius: Expr, force: Vector| {
        let arm = spatial::neg(pool, &spatial::scale(pool, radius, &aside));
        let moment = spatial::cross(pool, &arm, &force);
        Wrench { body: bodies[k], force, at: places[k], moment }
    };
    vec![on(0, first, e), on(1, second, spatial::neg(pool, &e))]
}

/// The wrenches of all belts that stretch; `signals` are the measures as expressions.
pub(crate) fn elastic_wrenches(
    model: &Model,
    kinematics: &Kinematics,
    signals: &[(SymbolId, Expr)],
) -> Vec<Wrench> {
    let belts = (0..model.belts.len()).map(BeltId);
    belts.flat_map(|belt| elastic_wrenches_of(model, kinematics, signals, belt)).collect()
}

/// The wrenches of one belt that stretches, none of another.
pub(crate) fn elastic_wrenches_of(
    model: &Model,
    kinematics: &Kinematics,
    signals: &[(SymbolId, Expr)],
    belt: BeltId,
) -> Vec<Wrench> {
    let pool = &model.pool;
    let belt = &model.belts[belt.0];
    let mut wrenches = Vec::new();
    for (strand, &tension) in belt.tensions.iter().enumerate() {
        let tension = pool.substitute(tension, signals);
        let unit = strand_wrenches(model, kinematics, belt, strand);
        wrenches.extend(unit.iter().map(|wrench| wrench.scaled(pool, tension)));
    }
    wrenches
}
