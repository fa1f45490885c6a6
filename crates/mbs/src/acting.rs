//! Every wrench on a body that is cut free, by the part of the model that it comes from.

use bksim_model::{BeltId, BodyId, ContactId, JointId, JointKind, LoadId, LoadKind, Model, RopeId};

use crate::constraint::{Constraint, Source};
use crate::coupling::separating_wrenches;
use crate::force::{self, Wrench};
use crate::power::Actor;
use crate::reaction::acceleration;
use crate::recursion::BodyAcceleration;
use crate::signal::signal_values;
use crate::spatial;
use crate::system::SymbolicSystem;
use crate::{belt, mesh, rope};

/// A wrench with the part of the model that it comes from.
#[derive(Clone, Debug)]
pub struct Acting {
    /// The load, belt, rope, drive or coupling. Stops, friction and places of contacts are loads.
    pub actor: Actor,
    /// Expressions of t, q, v and λ.
    pub wrench: Wrench,
}

/// The wrenches on all bodies, without the reactions of joints, which [`crate::reaction::reactions`] has; a multiplier of
/// friction is that of a sample, which it has while it slides, too. The whole force along a cylinder is its reaction.
pub fn acting(model: &Model, system: &SymbolicSystem) -> Vec<Acting> {
    let (pool, kinematics) = (&model.pool, &system.kinematics);
    let signals = signal_values(model, kinematics);
    let is_cylinder = |joint: JointId| model.joints[joint.0].kind == JointKind::Cylinder;
    let mut found: Vec<(Actor, Vec<Wrench>)> = Vec::new();
    for (k, load) in model.loads.iter().enumerate() {
        if let LoadKind::Effort { joint, .. } | LoadKind::JointSpring { joint, .. } = load.kind
            && is_cylinder(joint)
        {
            continue;
        }
        let action = force::action(model, kinematics, &signals, &load.kind);
        let mesh = mesh::elastic_wrenches(model, kinematics, &signals, &load.kind);
        let wrenches = [action.conservative, action.applied, mesh].concat();
        found.push((Actor::Load(LoadId(k)), wrenches));
    }
    for k in 0..model.belts.len() {
        let wrenches = belt::elastic_wrenches_of(model, kinematics, &signals, BeltId(k));
        found.push((Actor::Belt(BeltId(k)), wrenches));
    }
    for k in 0..model.ropes.len() {
        let wrenches = rope::elastic_wrenches(model, kinematics, &signals, RopeId(k));
        found.push((Actor::Rope(RopeId(k)), wrenches));
    }
    for row in &system.constraints {
        let actor = match row.source {
            Source::Joint(_) | Source::Quaternion(_) => continue,
            source if source.joint(model).is_some_and(is_cylinder) => continue,
            Source::Coupling(id) => Actor::Coupling(id),
            Source::Drive(id) => Actor::Drive(id),
            Source::Stop(id) | Source::Friction(id) => Actor::Load(id),
        };
        let lambda = pool.symbol_expr(row.lambda);
        let mut wrenches: Vec<Wrench> =
            row.wrenches.iter().map(|wrench| wrench.scaled(pool, lambda)).collect();
        let row: &[Constraint] = std::slice::from_ref(row);
        let separating = separating_wrenches(model, kinematics, row).into_iter();
        wrenches.extend(separating.flat_map(|(wrenches, _)| wrenches));
        found.push((actor, wrenches));
    }
    let parts = found.into_iter().flat_map(|(actor, wrenches)| {
        wrenches.into_iter().map(move |wrench| Acting { actor, wrench })
    });
    parts.filter(|acting| !is_zero(model, &acting.wrench)).collect()
}

/// The wrenches of a contact on its second body: what presses at each place, and what rubs.
pub fn of_contact(model: &Model, system: &SymbolicSystem, contact: ContactId) -> [Vec<Wrench>; 2] {
    let pool = &model.pool;
    let body = second_body(model, contact);
    let mut found = [Vec::new(), Vec::new()];
    for row in &system.constraints {
        let (load, part) = match row.source {
            Source::Stop(load) => (load, 0),
            Source::Friction(load) => (load, 1),
            _ => continue,
        };
        if model.loads[load.0].contact() != Some(contact) {
            continue;
        }
        let lambda = pool.symbol_expr(row.lambda);
        let own = row.wrenches.iter().filter(|wrench| Some(wrench.body) == body);
        found[part].extend(own.map(|wrench| wrench.scaled(pool, lambda)));
    }
    found
}

/// The body of the second outline of a contact; `None` of one without places.
pub fn second_body(model: &Model, contact: ContactId) -> Option<BodyId> {
    let place = model.contacts[contact.0].places.first()?;
    let [mover, base] = [place.mover.center.body, place.base.anchor().body];
    Some(if place.is_second { mover } else { base })
}

/// The inertia of a body by d'Alembert: −m r̈ in its centre of mass and −d/dt (A I′ Aᵀ ω), of q, v and v̇. With it the
/// wrenches on the body are in balance.
pub fn inertia(model: &Model, system: &SymbolicSystem, body: BodyId) -> Wrench {
    let pool = &model.pool;
    let at = system.kinematics.position(model, body, None);
    let BodyAcceleration { com, angular_momentum_rate } = acceleration(model, system, body, &at);
    let mass = pool.neg(model.bodies[body.0].mass);
    let force = spatial::scale(pool, mass, &com);
    Wrench { body, force, at, moment: spatial::neg(pool, &angular_momentum_rate) }
}

/// The point of a joint at which its reaction acts, without a force.
pub fn point_of(model: &Model, system: &SymbolicSystem, joint: JointId) -> Wrench {
    let (anchor, zero) = (model.joints[joint.0].successor, spatial::zero(&model.pool));
    let at = system.kinematics.anchor(model, anchor);
    Wrench { body: anchor.body, force: zero, at, moment: zero }
}

fn is_zero(model: &Model, wrench: &Wrench) -> bool {
    wrench.force.iter().chain(&wrench.moment).all(|&part| model.pool.is_zero(part))
}
