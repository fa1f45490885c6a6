//! The parts of a mechanism and its mobility.

use bksim_mbs::coordinate::CoordinateKind;
use bksim_mbs::particle::particles;
use bksim_model::{
    CoordinatePolicy, Coupling, CouplingKind, JointId, Measure, Model, MotionKind, Space,
};
use bksim_sim::mobility::{Mobility, freedoms_of_body, turns};
use bksim_sim::redundancy::{Condition, RepeatedCondition};
use serde_json::{Value, json};

use bksim_sim::Mechanism;

/// Names of all parts, the coordinates and who chose them, and the counts of mobility.
pub fn parts(mechanism: &Mechanism, found: &Mobility) -> Value {
    let model = &mechanism.model;
    // Rows of contacts are theirs.
    let own_loads = model.loads.iter().filter(|load| load.contact().is_none());
    json!({
        "model": model.name,
        "space": if model.space == Space::Planar { "planar" } else { "spatial" },
        "bodies": model.bodies.iter().skip(1).map(|b| &b.name).collect::<Vec<_>>(),
        "joints": model.joints.iter().map(|j| &j.name).collect::<Vec<_>>(),
        "couplings": model.couplings.iter().map(|c| &c.name).collect::<Vec<_>>(),
        "contacts": model.contacts.iter().map(|c| &c.name).collect::<Vec<_>>(),
        "loads": own_loads.map(|l| &l.name).collect::<Vec<_>>(),
        "drives": model.drives.iter().map(|d| &d.name).collect::<Vec<_>>(),
        "states": model.states.iter().map(|s| &s.name).collect::<Vec<_>>(),
        "coordinates": motion_coordinates(mechanism).collect::<Vec<_>>(),
        "coordinate_policy": coordinate_policy(mechanism),
        "coordinate_policy_chosen_by": match model.coordinates {
            CoordinatePolicy::Auto => "bksim",
            _ => "model",
        },
        "cut_joints": joint_names(mechanism, &mechanism.system.tree.cuts),
        "constraints": found.n_constraints,
        "rank": found.rank,
        "gruebler": found.gruebler,
        "mobility": found.mobility,
        "mobility_of_positions": found.of_positions,
        "redundant_conditions": found.n_redundant,
        "redundant_joints": joint_names(mechanism, &found.redundant),
        "count": count(mechanism, found),
        "redundant": redundant(mechanism, found),
    })
}

/// Relations between a turn and a slide, which stand for ropes or racks but load no bearing across their motions.
pub fn without_bearing(model: &Model) -> Vec<&str> {
    let moves = |relation, kind: MotionKind| {
        model.signals.iter().any(|signal| match signal.measure {
            Measure::JointPosition(joint, idx) => {
                model.joints[joint.0].kind.motions().get(idx) == Some(&kind)
                    && model.pool.depends_on(relation, signal.symbol)
            }
            _ => false,
        })
    };
    let is_between = |coupling: &&Coupling| {
        coupling.kind == CouplingKind::Relation
            && moves(coupling.relation, MotionKind::Rotation)
            && moves(coupling.relation, MotionKind::Translation)
    };
    model.couplings.iter().filter(is_between).map(|coupling| coupling.name.as_str()).collect()
}

/// The conditions that follow from others, by joint and direction, and what they follow from.
pub fn redundant(mechanism: &Mechanism, found: &Mobility) -> Vec<Value> {
    found.repeated.iter().map(|of| repeated(mechanism, of)).collect()
}

/// The terms of Grübler's or Kutzbach's count, by name.
fn count(mechanism: &Mechanism, found: &Mobility) -> Value {
    let model = &mechanism.model;
    let names = |of: &mut dyn Iterator<Item = &String>| of.cloned().collect::<Vec<_>>();
    let is_particle = particles(model);
    let of_particles =
        model.bodies.iter().zip(&is_particle).filter(|(_, is_particle)| **is_particle);
    let joints = model.joints.iter().map(|joint| {
        let taken = joint.kind.n_taken(model.space);
        json!({ "name": joint.name, "type": joint.kind.word(), "taken": taken })
    });
    json!({
        "freedoms_of_body": freedoms_of_body(model.space),
        "bodies": names(&mut model.bodies.iter().skip(1).map(|body| &body.name)),
        "turns_of_particle": turns(model.space),
        "particles": names(&mut of_particles.map(|(body, _)| &body.name)),
        "joints": joints.collect::<Vec<_>>(),
        "couplings": names(&mut model.couplings.iter().map(|coupling| &coupling.name)),
        "counted": found.gruebler,
        "mobility": found.mobility,
        "redundant": found.n_redundant,
    })
}

/// A condition that follows from others, and these.
fn repeated(mechanism: &Mechanism, of: &RepeatedCondition) -> Value {
    let model = &mechanism.model;
    let condition = |condition: &Condition| {
        json!({
            "of": condition.name(model),
            "direction": condition.direction_word(model),
            "effort": condition.effort(),
            "axis": condition.direction.axis().map_or(Vec::new(), Vec::from),
            "text": condition.words(model),
        })
    };
    let by = of.by.iter().map(condition);
    json!({ "condition": condition(&of.condition), "repeats": by.collect::<Vec<_>>() })
}

/// Names of the generalised coordinates; the integrals of states are none.
pub fn motion_coordinates(mechanism: &Mechanism) -> impl Iterator<Item = &str> {
    let all = mechanism.system.coordinates().iter();
    all.filter(|c| c.kind != CoordinateKind::Integral).map(|c| c.name.as_str())
}

/// The choice of its coordinates: `relative`, `absolute`.
pub fn coordinate_policy(mechanism: &Mechanism) -> &'static str {
    match mechanism.system.tree.policy {
        CoordinatePolicy::Absolute => "absolute",
        _ => "relative",
    }
}

/// The names of joints.
pub fn joint_names<'a>(mechanism: &'a Mechanism, joints: &[JointId]) -> Vec<&'a str> {
    joints.iter().map(|joint| mechanism.model.joints[joint.0].name.as_str()).collect()
}
