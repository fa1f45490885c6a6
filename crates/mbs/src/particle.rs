//! Particles: bodies without moments of inertia that nothing turns and whose turning nothing asks for; they need no
//! coordinates of orientation.

use std::collections::HashSet;

use bksim_model::{
    Anchor, BodyId, CouplingKind, GROUND, JointId, JointKind, Measure, Model, Shape, Signal, Space,
};

/// By body, whether it is a particle.
///
/// All joints and loads meet it in its centre of mass, in ways that leave its turning free, and no angle of it is
/// stated, driven, measured or named.
pub fn particles(model: &Model) -> Vec<bool> {
    let pool = &model.pool;
    let mut is_particle: Vec<bool> = model
        .bodies
        .iter()
        .map(|body| {
            let inertia = [body.inertia.moments, body.inertia.products].concat();
            let n_names = if model.space == Space::Planar { 2 } else { 3 };
            !pool.is_zero(body.mass)
                && inertia.into_iter().all(|part| pool.is_zero(part))
                && body.coordinate_names.len() <= n_names
        })
        .collect();
    is_particle[GROUND.0] = false;
    if !is_particle.contains(&true) {
        return is_particle;
    }
    let candidates = is_particle.clone();
    let mut turns = |body: BodyId| is_particle[body.0] = false;
    let is_central = |anchor: Anchor| {
        let body = &model.bodies[anchor.body.0];
        let at = anchor.point.map(|point| body.points[point.0].position);
        at.unwrap_or([pool.zero(); 3]) == body.com
    };

    // Joints, and what acts in their motions.
    let asked = asked_motions(model);
    for (idx, joint) in model.joints.iter().enumerate() {
        let ends = [joint.predecessor, joint.successor];
        for (place, end) in ends.into_iter().enumerate().filter(|(_, end)| candidates[end.body.0]) {
            let leaves_turning = match joint.kind {
                JointKind::Link { .. } | JointKind::Cylinder => true,
                JointKind::Spherical => !asked.contains(&JointId(idx)),
                JointKind::Revolute => {
                    model.space == Space::Planar && !asked.contains(&JointId(idx))
                }
                JointKind::PointOnCurve { .. } => place == 1,
                JointKind::PointOnLine | JointKind::PointOnPlane => {
                    place == 1 && !asked.contains(&JointId(idx))
                }
                _ => false,
            };
            if !leaves_turning || !is_central(end) {
                turns(end.body);
            }
        }
    }
    // Loads.
    for load in &model.loads {
        if let Some((on, from, _)) = load.kind.torque() {
            [on, from].into_iter().for_each(&mut turns);
        }
        let follows_body = load.kind.point_force().is_some_and(|(_, _, follows)| follows);
        let points = load.kind.points().into_iter();
        let turned = points.filter(|&point| follows_body || !is_central(point));
        turned.map(|point| point.body).for_each(&mut turns);
    }
    // Wheels.
    for coupling in model.all_couplings() {
        match coupling.kind {
            CouplingKind::Gear(wheels) | CouplingKind::Belt(wheels) => {
                wheels.wheels.into_iter().for_each(|wheel| turns(wheel.body));
                turns(wheels.carrier);
            }
            CouplingKind::Rack(rack) => rack.bodies.into_iter().for_each(&mut turns),
            CouplingKind::Relation
            | CouplingKind::Rate
            | CouplingKind::Screw
            | CouplingKind::Strand(..)
            | CouplingKind::Rope(..) => (),
        }
    }
    for wheel in model.belts.iter().flat_map(|belt| &belt.wheels) {
        let joint = &model.joints[wheel.joint.0];
        for end in [joint.predecessor, joint.successor] {
            turns(end.body);
        }
    }
    for node in model.ropes.iter().flat_map(|rope| &rope.nodes) {
        if !pool.is_zero(node.radius) || !is_central(node.center) {
            turns(node.center.body);
        }
    }
    for pair in &model.contacts {
        // What rubs on a roller turns it.
        let is_roller = |shape: &Shape| match shape {
            Shape::Curve { joint, .. } => {
                let kind = &model.joints[joint.0].kind;
                let curve = kind.curve().map(|curve| &model.curves[curve.0]);
                kind.roller().is_some() || curve.is_some_and(|curve| curve.pitch(pool).is_some())
            }
            _ => false,
        };
        let has_roller = pair.shapes.iter().any(is_roller);
        for shape in &pair.shapes {
            let is_point = match shape {
                Shape::Round(round) => pool.is_zero(round.radius) && is_central(round.center),
                _ => false,
            };
            if has_roller || !is_point {
                shape.anchors().into_iter().for_each(|anchor| turns(anchor.body));
            }
        }
    }
    // Whatever is stated or measured.
    let measures = model.initial.iter().map(|initial| initial.measure);
    let measures = measures.chain(signals(model).map(|signal| signal.measure));
    for measure in measures {
        turned_by(model, measure, &is_central).into_iter().for_each(&mut turns);
    }
    model.orientations.iter().for_each(|stated| turns(stated.body));
    is_particle
}

fn signals(model: &Model) -> impl Iterator<Item = &Signal> {
    model.signals.iter().chain(&model.at_start)
}

/// The joints whose motions are named, driven, loaded, stated or measured.
fn asked_motions(model: &Model) -> HashSet<JointId> {
    let named = model.joints.iter().enumerate();
    let named = named.filter(|(_, joint)| !joint.coordinate_names.is_empty());
    let driven = model.drives.iter().map(|drive| drive.joint);
    let loaded =
        model.loads.iter().filter_map(|load| load.kind.joint_motion().map(|(joint, _)| joint));
    let measures = model.initial.iter().map(|initial| initial.measure);
    let measures = measures.chain(signals(model).map(|signal| signal.measure));
    let measured = measures.filter_map(|measure| match measure {
        Measure::JointPosition(joint, _)
        | Measure::JointVelocity(joint, _)
        | Measure::JointAcceleration(joint, _) => Some(joint),
        _ => None,
    });
    let named = named.map(|(idx, _)| JointId(idx));
    named.chain(driven).chain(loaded).chain(measured).collect()
}

/// The bodies whose turning a measure depends on.
fn turned_by(model: &Model, measure: Measure, is_central: &dyn Fn(Anchor) -> bool) -> Vec<BodyId> {
    match measure {
        Measure::PointPosition(body, point @ Some(_), _)
        | Measure::PointVelocity(body, point @ Some(_), _)
        | Measure::PointAcceleration(body, point @ Some(_), _)
            if !is_central(Anchor { body, point }) =>
        {
            vec![body]
        }
        Measure::BodyAngle(body)
        | Measure::BodyRate(body)
        | Measure::CardanAngle(body, _)
        | Measure::CardanRate(body, _)
        | Measure::RollPitchYaw(body, _)
        | Measure::Quaternion(body, _)
        | Measure::DirectionCosine(body, ..)
        | Measure::AngularVelocity(body, ..)
        | Measure::AngularAcceleration(body, ..) => vec![body],
        Measure::Turn(body, against, joint) => {
            let joint = &model.joints[joint.0];
            vec![body, against, joint.predecessor.body, joint.successor.body]
        }
        _ => Vec::new(),
    }
}
